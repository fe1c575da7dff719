//! Sizes of effects: the one parameter that grows when an effect is made larger.

use super::Effect;

impl Effect {
    /// The size, in the unit of the parameter that it is.
    pub fn size_mut(&mut self) -> Vec<&mut f64> {
        match self {
            Self::Eccentricity { amplitude_rad, .. }
            | Self::DiscTilt { amplitude_rad, .. }
            | Self::Whirl { amplitude_rad, .. } => vec![amplitude_rad],
            Self::LocalDefect { error_rad, .. } => vec![error_rad],
            Self::LineError { rms_rad, .. } => vec![rms_rad],
            Self::WidthError { rad } => rad.iter_mut().collect(),
            Self::QuadratureError { rad } => vec![rad],
            Self::EdgeDelay { rise_s, fall_s } => rise_s.iter_mut().chain(fall_s).collect(),
            Self::ChannelSkew { channel_s } => channel_s.iter_mut().collect(),
            Self::ThresholdRipple { angle_rad, .. }
            | Self::ThresholdDrift { angle_rad, .. }
            | Self::Hysteresis { angle_rad }
            | Self::BurstNoise { angle_rad, .. }
            | Self::Telegraph { angle_rad, .. } => vec![angle_rad],
            Self::Backlash { gap_rad } => vec![gap_rad],
            Self::TorqueRipple(o) | Self::GearMesh(o) | Self::BearingTorque(o) => {
                vec![&mut o.torque_n_m]
            }
            Self::BearingRunout { runout_rad, .. } => vec![runout_rad],
            Self::TorqueTone { torque_n_m, .. }
            | Self::LoadStep { torque_n_m, .. }
            | Self::Chirp { torque_n_m, .. }
            | Self::OrderChirp { torque_n_m, .. }
            | Self::ModulatedOrder { torque_n_m, .. } => vec![torque_n_m],
            Self::SpeedDrift { fraction_per_s } => vec![fraction_per_s],
            Self::Friction {
                coulomb_n_m,
                viscous_n_m_s,
                drag_n_m_s2,
                stribeck_n_m,
                ..
            } => vec![coulomb_n_m, viscous_n_m_s, drag_n_m_s2, stribeck_n_m],
            Self::StickSlip {
                stiffness_n_m_rad, ..
            } => vec![stiffness_n_m_rad],
            Self::TorsionalResonance { inertia_share, .. } => vec![inertia_share],
            Self::TimestampJitter { jitter_s } => vec![jitter_s],
            Self::CaptureLatency { mean_s } => vec![mean_s],
            Self::CaptureTask { busy_s, .. } => vec![busy_s],
            Self::Creep { per_turn_rad, .. } => vec![per_turn_rad],
            Self::Cell(cell) => vec![&mut cell.size],
            Self::ClosedLoop {
                kp_n_m_s, ki_n_m, ..
            } => vec![kp_n_m_s, ki_n_m],
            Self::LostEdges { .. } | Self::ExtraEdges { .. } | Self::IndexSlip { .. } => Vec::new(),
        }
    }

    /// The largest of its sizes, without sign; 0 for what is counted.
    #[must_use]
    pub fn size(&self) -> f64 {
        let mut copy = self.clone();
        let sizes = copy.size_mut().into_iter();
        sizes.fold(0.0, |most, size| most.max(size.abs()))
    }

    /// The effect so many times as large.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let mut copy = self.clone();
        for size in copy.size_mut() {
            *size *= factor;
        }
        copy
    }
}

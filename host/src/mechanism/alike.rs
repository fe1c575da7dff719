//! Which mechanisms look the same in some recording.

use super::Mechanism;

impl Mechanism {
    /// Mechanisms that the same recording may show alike; if one is another's look-alike, so is the other the one's.
    #[must_use]
    pub const fn look_alikes(self) -> &'static [Self] {
        match self {
            Self::LineError => &[
                Self::LocalDefect,
                Self::TorqueRipple,
                Self::Eccentricity,
                Self::DiscTilt,
                Self::ClosedLoop,
            ],
            Self::WidthError => &[Self::EdgeDelay, Self::ThresholdDrift, Self::Hysteresis],
            Self::QuadratureError => &[Self::ChannelSkew],
            Self::Eccentricity => &[
                Self::TorqueRipple,
                Self::LineError,
                Self::ClosedLoop,
                Self::Bearing,
            ],
            Self::DiscTilt => &[Self::TorqueRipple, Self::LineError, Self::ClosedLoop],
            Self::LocalDefect => &[Self::LineError, Self::LostEdges, Self::ExtraEdges],
            Self::Hysteresis => &[Self::Backlash, Self::WidthError],
            Self::EdgeDelay => &[Self::WidthError, Self::ThresholdDrift],
            Self::ChannelSkew => &[Self::QuadratureError],
            Self::ThresholdRipple => &[Self::TorqueTone, Self::CaptureLatency],
            Self::ThresholdDrift => &[Self::WidthError, Self::EdgeDelay, Self::SpeedDrift],
            Self::TimestampJitter => &[Self::CaptureLatency],
            Self::CaptureLatency => &[Self::TimestampJitter, Self::ThresholdRipple],
            Self::LostEdges => &[Self::IndexSlip, Self::LocalDefect],
            Self::ExtraEdges => &[Self::LocalDefect, Self::IndexSlip],
            Self::IndexSlip => &[Self::LostEdges, Self::ExtraEdges],
            Self::TorqueRipple => &[
                Self::Eccentricity,
                Self::DiscTilt,
                Self::LineError,
                Self::TorqueTone,
                Self::GearMesh,
                Self::Bearing,
                Self::ClosedLoop,
            ],
            Self::GearMesh => &[Self::Bearing, Self::TorqueTone, Self::TorqueRipple],
            Self::Bearing => &[
                Self::GearMesh,
                Self::TorqueTone,
                Self::TorqueRipple,
                Self::Eccentricity,
            ],
            Self::TorqueTone => &[
                Self::GearMesh,
                Self::Bearing,
                Self::TorqueRipple,
                Self::TorsionalResonance,
                Self::ThresholdRipple,
                Self::StickSlip,
            ],
            Self::TorsionalResonance => &[Self::TorqueTone, Self::StickSlip],
            Self::Friction => &[Self::SpeedDrift, Self::LoadStep],
            Self::StickSlip => &[Self::TorqueTone, Self::TorsionalResonance],
            Self::Backlash => &[Self::Hysteresis],
            Self::LoadStep => &[Self::SpeedDrift, Self::Friction],
            Self::SpeedDrift => &[Self::Friction, Self::LoadStep, Self::ThresholdDrift],
            Self::ClosedLoop => &[
                Self::TorqueRipple,
                Self::Eccentricity,
                Self::DiscTilt,
                Self::LineError,
            ],
            Self::Unknown => &[],
        }
    }
}

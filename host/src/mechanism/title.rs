//! What a mechanism is called in a report.

use super::Mechanism;

impl Mechanism {
    /// A few words for people, without a full stop.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Self::LineError => "line position error of the disc",
            Self::WidthError => "signal width error",
            Self::QuadratureError => "quadrature error",
            Self::Eccentricity => "disc off its centre",
            Self::DiscTilt => "tilted or oval disc",
            Self::LocalDefect => "defect at one place of the disc",
            Self::Hysteresis => "hysteresis of the head",
            Self::EdgeDelay => "rise and fall delayed unequally",
            Self::ChannelSkew => "channels delayed unequally",
            Self::ThresholdRipple => "pick-up on the comparator's level",
            Self::ThresholdDrift => "drift of the comparator's level",
            Self::TimestampJitter => "time noise of the capture",
            Self::CaptureLatency => "late captures",
            Self::LostEdges => "lost edges",
            Self::ExtraEdges => "extra edges",
            Self::IndexSlip => "index slipped against the disc",
            Self::TorqueRipple => "torque ripple of the motor",
            Self::GearMesh => "torque of a gear mesh",
            Self::Bearing => "bearing or other run-out at a non-integer order",
            Self::TorqueTone => "torque at a fixed frequency",
            Self::TorsionalResonance => "torsional resonance",
            Self::Friction => "friction",
            Self::StickSlip => "stick-slip",
            Self::Backlash => "backlash",
            Self::LoadStep => "load step",
            Self::SpeedDrift => "slow change of the drive's speed",
            Self::ClosedLoop => "speed loop that follows the encoder's own error",
            Self::Unknown => "none of the known mechanisms",
        }
    }
}

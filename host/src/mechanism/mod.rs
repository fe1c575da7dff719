//! The mechanisms that a diagnosis can name: fixed ids, and what is known of each without any recording.
//!
//! This is data only. The forward models are in [`crate::sim`], their parameters in [`crate::twin`]; a twin has a section for every
//! mechanism but [`Mechanism::Unknown`].

mod alike;
mod mark;
mod separated;
#[cfg(test)]
mod tests;
mod title;

use std::fmt;

use serde::{Deserialize, Serialize};

pub use mark::{EdgeClasses, LockedTo};

/// A cause of a difference between simulation and recording.
///
/// The id, as in the JSON, is the name in `snake_case`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mechanism {
    /// Line position error eps of this disc (twin: `errors`).
    LineError,
    /// Signal width error xi: falling edges against rising ones (`errors.width_a_rad`, ..).
    WidthError,
    /// Quadrature error p: one channel against the other (`errors.quadrature_rad`, ..).
    QuadratureError,
    /// Disc centre off the axis: (d/R) sin(theta - theta0) (`errors.eccentricity`).
    Eccentricity,
    /// Tilted or oval disc, or a Hooke's joint: the second order (`errors.tilt`).
    DiscTilt,
    /// Dirt, a scratch, a line that is missing or has merged with the next (`local_defect`).
    LocalDefect,
    /// Edges shift with the direction of motion (`hysteresis`).
    Hysteresis,
    /// Delays of rise and fall differ (`edge_delay`).
    EdgeDelay,
    /// Delays of the channels differ (`channel_skew`).
    ChannelSkew,
    /// Mains or PWM pick-up on the comparator's level (`threshold_ripple`).
    ThresholdRipple,
    /// The comparator's level drifts with lamp or temperature (`threshold_drift`).
    ThresholdDrift,
    /// White time noise of the capture (`timer.jitter_s`).
    TimestampJitter,
    /// Captures that come late, one-sided or in bursts at a task's rate (`capture_latency`).
    CaptureLatency,
    /// Edges that the capture missed (`faults.lost_edges`, ..).
    LostEdges,
    /// Edges that no mark made (`faults.glitch_probability`).
    ExtraEdges,
    /// Coupling or index moved against the disc (`index_slip`).
    IndexSlip,
    /// Cogging or commutation torque at whole orders (`ripple`).
    TorqueRipple,
    /// Torque at an order that a gear ratio gives (`gear_mesh`).
    GearMesh,
    /// Torque or run-out at an order that is tied to no declared ratio (`bearing`).
    Bearing,
    /// Torque at a fixed frequency (`torque_tone`).
    TorqueTone,
    /// A lightly damped torsional mode that noise or orders excite (`torsional_resonance`).
    TorsionalResonance,
    /// Coulomb, viscous, Stribeck and speed-squared terms that shape a run-down (`shaft`).
    Friction,
    /// A limit cycle of friction and spring at low speed (`stick_slip`).
    StickSlip,
    /// A dead angle after a reversal (`backlash`).
    Backlash,
    /// A torque that comes and goes (`load_step`).
    LoadStep,
    /// A slow change of the drive's speed (`speed_drift`).
    SpeedDrift,
    /// A speed loop that chases the encoder's own error (`drive.speed_loop`).
    ClosedLoop,
    /// None of these.
    Unknown,
}

impl Mechanism {
    /// All of them, in the order of the table; [`Self::Unknown`] is the last.
    pub const ALL: [Self; 28] = [
        Self::LineError,
        Self::WidthError,
        Self::QuadratureError,
        Self::Eccentricity,
        Self::DiscTilt,
        Self::LocalDefect,
        Self::Hysteresis,
        Self::EdgeDelay,
        Self::ChannelSkew,
        Self::ThresholdRipple,
        Self::ThresholdDrift,
        Self::TimestampJitter,
        Self::CaptureLatency,
        Self::LostEdges,
        Self::ExtraEdges,
        Self::IndexSlip,
        Self::TorqueRipple,
        Self::GearMesh,
        Self::Bearing,
        Self::TorqueTone,
        Self::TorsionalResonance,
        Self::Friction,
        Self::StickSlip,
        Self::Backlash,
        Self::LoadStep,
        Self::SpeedDrift,
        Self::ClosedLoop,
        Self::Unknown,
    ];

    /// The id, as in the JSON.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::LineError => "line_error",
            Self::WidthError => "width_error",
            Self::QuadratureError => "quadrature_error",
            Self::Eccentricity => "eccentricity",
            Self::DiscTilt => "disc_tilt",
            Self::LocalDefect => "local_defect",
            Self::Hysteresis => "hysteresis",
            Self::EdgeDelay => "edge_delay",
            Self::ChannelSkew => "channel_skew",
            Self::ThresholdRipple => "threshold_ripple",
            Self::ThresholdDrift => "threshold_drift",
            Self::TimestampJitter => "timestamp_jitter",
            Self::CaptureLatency => "capture_latency",
            Self::LostEdges => "lost_edges",
            Self::ExtraEdges => "extra_edges",
            Self::IndexSlip => "index_slip",
            Self::TorqueRipple => "torque_ripple",
            Self::GearMesh => "gear_mesh",
            Self::Bearing => "bearing",
            Self::TorqueTone => "torque_tone",
            Self::TorsionalResonance => "torsional_resonance",
            Self::Friction => "friction",
            Self::StickSlip => "stick_slip",
            Self::Backlash => "backlash",
            Self::LoadStep => "load_step",
            Self::SpeedDrift => "speed_drift",
            Self::ClosedLoop => "closed_loop",
            Self::Unknown => "unknown",
        }
    }

    /// The mechanism with an id; none if there is no such id.
    #[must_use]
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mechanism| mechanism.id() == id)
    }
}

impl fmt::Display for Mechanism {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.id())
    }
}

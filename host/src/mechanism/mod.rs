//! The mechanisms that a diagnosis can name. `catalogue.toml` has a card for each: its physics, its numbers, its mark and its
//! look-alikes.
//!
//! A new mechanism is a table of that file and a line of the table here; which cell of the diagnosis it names is said in
//! [`crate::diagnose::name`]. A twin has a section for every mechanism but [`Mechanism::Unknown`], and [`crate::sim`] runs it.

mod card;
mod mark;
#[cfg(test)]
mod tests;

use std::fmt;

use serde::{Deserialize, Serialize};

pub use card::{Card, Quantity, RUN_OUT_RAD, TASK_HZ};
pub use mark::{EdgeClasses, LockedTo};

/// Makes of each line a mechanism and its id.
macro_rules! table {
    ($($(#[$doc:meta])* $name:ident = $id:ident,)*) => {
        /// A cause of a difference between simulation and recording.
        ///
        /// The id, as in the JSON, is the name in `snake_case`.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum Mechanism {
            $($(#[$doc])* $name,)*
        }

        impl Mechanism {
            /// All of them, in the order of the table; [`Self::Unknown`] is the last.
            pub const ALL: [Self; [$(stringify!($id)),*].len()] = [$(Self::$name),*];

            /// The id, as in the JSON.
            #[must_use]
            pub const fn id(self) -> &'static str {
                match self {
                    $(Self::$name => stringify!($id),)*
                }
            }
        }
    };
}

table! {
    /// Line position error eps of this disc (twin: `errors`).
    LineError = line_error,
    /// Signal width error xi: falling edges against rising ones (`errors.width_a_rad`, ..).
    WidthError = width_error,
    /// Quadrature error p: one channel against the other (`errors.quadrature_rad`, ..).
    QuadratureError = quadrature_error,
    /// Disc centre off the axis: (d/R) sin(theta - theta0) (`errors.eccentricity`).
    Eccentricity = eccentricity,
    /// Tilted or oval disc, or a Hooke's joint: the second order (`errors.tilt`).
    DiscTilt = disc_tilt,
    /// Dirt, a scratch, a line that is missing or has merged with the next (`local_defect`).
    LocalDefect = local_defect,
    /// Edges shift with the direction of motion (`hysteresis`).
    Hysteresis = hysteresis,
    /// Delays of rise and fall differ (`edge_delay`).
    EdgeDelay = edge_delay,
    /// Delays of the channels differ (`channel_skew`).
    ChannelSkew = channel_skew,
    /// Mains or PWM pick-up on the comparator's level (`threshold_ripple`).
    ThresholdRipple = threshold_ripple,
    /// The comparator's level drifts with lamp or temperature (`threshold_drift`).
    ThresholdDrift = threshold_drift,
    /// White time noise of the capture (`timer.jitter_s`).
    TimestampJitter = timestamp_jitter,
    /// Captures that come late, one-sided or in bursts at a task's rate (`capture_latency`).
    CaptureLatency = capture_latency,
    /// Edges that the capture missed (`faults.lost_edges`, ..).
    LostEdges = lost_edges,
    /// Edges that no mark made (`faults.glitch_probability`).
    ExtraEdges = extra_edges,
    /// Coupling or index moved against the disc (`index_slip`).
    IndexSlip = index_slip,
    /// Cogging or commutation torque at whole orders (`ripple`).
    TorqueRipple = torque_ripple,
    /// Torque at an order that a gear ratio gives (`gear_mesh`).
    GearMesh = gear_mesh,
    /// Torque or run-out at an order that is tied to no declared ratio (`bearing`).
    Bearing = bearing,
    /// Torque at a fixed frequency (`torque_tone`).
    TorqueTone = torque_tone,
    /// A lightly damped torsional mode that noise or orders excite (`torsional_resonance`).
    TorsionalResonance = torsional_resonance,
    /// Coulomb, viscous, Stribeck and speed-squared terms that shape a run-down (`shaft`).
    Friction = friction,
    /// A limit cycle of friction and spring at low speed (`stick_slip`).
    StickSlip = stick_slip,
    /// A dead angle after a reversal (`backlash`).
    Backlash = backlash,
    /// A torque that comes and goes (`load_step`).
    LoadStep = load_step,
    /// A slow change of the drive's speed (`speed_drift`).
    SpeedDrift = speed_drift,
    /// A speed loop that chases the encoder's own error (`drive.speed_loop`).
    ClosedLoop = closed_loop,
    /// None of these.
    Unknown = unknown,
}

impl Mechanism {
    /// The mechanism with an id; none if there is no such id.
    #[must_use]
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mechanism| mechanism.id() == id)
    }

    /// All that is known of it.
    #[must_use]
    pub fn card(self) -> &'static Card {
        &card::CARDS[&self]
    }

    /// A few words for people, without a full stop.
    #[must_use]
    pub fn title(self) -> &'static str {
        &self.card().title
    }

    /// The recording to make next: what to change and what then shows. One or two sentences.
    #[must_use]
    pub fn separated_by(self) -> &'static str {
        &self.card().separated_by
    }

    /// Mechanisms that the same recording may show alike; if one is another's look-alike, so is the other the one's.
    #[must_use]
    pub fn look_alikes(self) -> &'static [Self] {
        &self.card().look_alikes
    }
}

impl fmt::Display for Mechanism {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.id())
    }
}

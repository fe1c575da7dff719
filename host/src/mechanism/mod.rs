//! The mechanisms that a diagnosis can name. `catalogue.toml` has a card for each: its physics, its numbers, its mark and its
//! look-alikes.
//!
//! A new mechanism is a table of that file and a line of the table here; which cell of the diagnosis it names is said in
//! `diagnose::name`. A twin has a section for every mechanism but [`Mechanism::Unknown`], and [`crate::sim`] runs it.

mod card;
#[cfg(test)]
mod tests;

use std::fmt;

use serde::{Deserialize, Serialize};

pub use card::{Card, Quantity};

/// Makes of each line a mechanism and its id.
macro_rules! table {
    ($($name:ident = $id:ident,)*) => {
        /// A cause of a difference between simulation and recording: what each is says [`Mechanism::card`].
        ///
        /// The id, as in the JSON, is the name in `snake_case`.
        #[allow(missing_docs)]
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum Mechanism {
            $($name,)*
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
    LineError = line_error,
    WidthError = width_error,
    QuadratureError = quadrature_error,
    Eccentricity = eccentricity,
    DiscTilt = disc_tilt,
    LocalDefect = local_defect,
    Hysteresis = hysteresis,
    EdgeDelay = edge_delay,
    ChannelSkew = channel_skew,
    ThresholdRipple = threshold_ripple,
    ThresholdDrift = threshold_drift,
    TimestampJitter = timestamp_jitter,
    CaptureLatency = capture_latency,
    LostEdges = lost_edges,
    ExtraEdges = extra_edges,
    IndexSlip = index_slip,
    TorqueRipple = torque_ripple,
    GearMesh = gear_mesh,
    Bearing = bearing,
    TorqueTone = torque_tone,
    TorsionalResonance = torsional_resonance,
    Friction = friction,
    StickSlip = stick_slip,
    Backlash = backlash,
    LoadStep = load_step,
    SpeedDrift = speed_drift,
    ClosedLoop = closed_loop,
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
}

impl fmt::Display for Mechanism {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.id())
    }
}

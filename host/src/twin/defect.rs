//! A place of the disc that is out of line.

use serde::{Deserialize, Serialize};

/// A channel of an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Channel {
    /// The first.
    A,
    /// The second.
    B,
    /// The third Hall sensor.
    C,
}

impl Channel {
    /// The channel of a number, 0 being A.
    #[must_use]
    pub const fn numbered(number: u8) -> Self {
        match number {
            0 => Self::A,
            1 => Self::B,
            _ => Self::C,
        }
    }
}

/// A kind of edge, as it looks going forward.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Flank {
    /// The level rises.
    Rise,
    /// The level falls.
    Fall,
}

/// `[[local_defect]]`: dirt, a scratch or a bad line. A part of the disc: adds
/// error exp(-d^2 / (2 width^2)) to e(k), where d is the way from the edge's grid angle to the defect, the shorter way round, to a
/// list of errors too.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LocalDefect {
    /// Place on the disc.
    pub angle_rad: f64,
    /// Width: sigma of the bump, above 0 and up to pi.
    pub width_rad: f64,
    /// Error at its peak, of either sign.
    pub error_rad: f64,
    /// The channel it is on; all where left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channel: Option<Channel>,
    /// The edges it moves; both where left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edge: Option<Flank>,
}

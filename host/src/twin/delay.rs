//! Delays between a mark passing the head and its capture.

use serde::{Deserialize, Serialize};

use super::is_zero;

/// `edge_delay`: rise and fall of a channel are captured with delays of their own, as a comparator or an optocoupler makes them.
/// What counts is how the level changes: passed in reverse, a mark at which A rises makes A fall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EdgeDelay {
    /// Channel A.
    #[serde(default, skip_serializing_if = "RiseFall::is_none")]
    pub a: RiseFall,
    /// Channel B.
    #[serde(default, skip_serializing_if = "RiseFall::is_none")]
    pub b: RiseFall,
    /// The third Hall sensor.
    #[serde(default, skip_serializing_if = "RiseFall::is_none")]
    pub c: RiseFall,
}

/// Delays of one channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RiseFall {
    /// Delay of a rise, 0 to 1 s.
    #[serde(default)]
    pub rise_s: f64,
    /// Delay of a fall, 0 to 1 s.
    #[serde(default)]
    pub fall_s: f64,
}

impl RiseFall {
    fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

/// `channel_skew`: whole channels are captured with delays of their own, as unequal filters or cables make them. Comes on top of
/// [`EdgeDelay`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChannelSkew {
    /// Delay of both edges of A, 0 to 1 s.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub a_s: f64,
    /// Delay of both edges of B, 0 to 1 s.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub b_s: f64,
    /// Delay of both edges of the third Hall sensor, 0 to 1 s.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub c_s: f64,
}

//! What depends on the direction of motion.

use serde::{Deserialize, Serialize};

use super::Channel;

/// `hysteresis`: of head or comparator: every edge is late by half of the angle in its direction of motion, the index too where no
/// channel is named.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hysteresis {
    /// Angle between a mark's places forward and in reverse, 0 to 1 rad.
    pub angle_rad: f64,
    /// The channel it is on; all where left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channel: Option<Channel>,
}

/// `backlash`: the disc follows the shaft through a play. It is half a gap behind in the direction of motion; after a reversal it stands
/// until the shaft has crossed the gap. A shaft that stands at time 0 is in the middle. The true angle is the shaft's.
///
/// Where the shaft's motion is given, edges come as with a [`Hysteresis`] of the gap on all channels: a play is that on every mark.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Backlash {
    /// Width of the play, 0 to pi.
    pub gap_rad: f64,
}

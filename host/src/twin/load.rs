//! Torque that a load puts on the shaft for a while.

use serde::{Deserialize, Serialize};

/// `load_step`: a constant torque that comes at one time and goes at another, as a tool that bites or a clutch that closes. Steps
/// that overlap add up. It is there whatever the drive does, and a drive's profile knows nothing of it: an open loop gives way by
/// torque / (b + stiffness).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadStep {
    /// Torque on the shaft, positive forward: a load that brakes a shaft turning forward is negative.
    pub torque_n_m: f64,
    /// When it comes, 0 or later.
    pub from_s: f64,
    /// When it goes, after `from_s`; it stays where left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub until_s: Option<f64>,
}

//! The drive's speed changes slowly.

use serde::{Deserialize, Serialize};

/// `speed_drift`: the speed of an open-loop drive is that of its profile times 1 + fraction_per_s t, or times
/// 1 + fraction (1 - exp(-t / tau)). The drive's push follows it, as that of a ramp does. A speed that drifts down to zero stays there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpeedDrift {
    /// Rate, 1/s, of either sign.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fraction_per_s: Option<f64>,
    /// Where it settles, above -1 and up to 1; with `tau_s`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fraction: Option<f64>,
    /// Time constant, above 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tau_s: Option<f64>,
}

//! What turns with the shaft at an order that is not whole.

use serde::{Deserialize, Serialize};

/// `[[bearing]]`: a rolling bearing's torque, as that of [`super::Ripple`], or its run-out, which moves the disc: an error of
/// runout sin(order theta + phase) that adds to e(k), theta being the shaft's angle through all turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bearing {
    /// Cycles a turn.
    pub order: f64,
    /// Phase at angle 0.
    #[serde(default)]
    pub phase_rad: f64,
    /// Amplitude as a torque.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_n_m: Option<f64>,
    /// Amplitude as the relative speed swing it makes at the nominal speed, as that of [`super::Ripple`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_fraction: Option<f64>,
    /// Amplitude as an error of the angle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub runout_rad: Option<f64>,
}

//! Torque at a fixed frequency.

use serde::{Deserialize, Serialize};

/// `[[torque_tone]]`: a torque sin(2 pi f t + phase) on the shaft, as an unbalanced load elsewhere on the frame or a drive's current
/// ripple makes it. Free of friction it swings the shaft by torque / (J (2 pi f)^2) rad, whatever the speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorqueTone {
    /// Frequency, above 0 and up to 1 MHz.
    pub f_hz: f64,
    /// Phase at time 0.
    #[serde(default)]
    pub phase_rad: f64,
    /// Amplitude as a torque.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_n_m: Option<f64>,
    /// Amplitude as the relative speed swing it makes at the nominal speed w: torque = fraction w |i J 2 pi f + b + stiffness|.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_fraction: Option<f64>,
}

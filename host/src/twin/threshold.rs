//! The comparator's level moves: rises come late and falls early, or the other way round.
//!
//! A level that is higher by dL is met later on a rising flank and earlier on a falling one, by dL over the signal's slope, seen forward.
//! That is an angle, whatever the speed, and the same marks are hit in reverse: there a rise is late and a fall early in the direction of
//! motion too. A shift by an angle a is the same as a width error xi = 2 a, whose sign it shares, with the line moved by -a.

use serde::{Deserialize, Serialize};

use super::Channel;

/// `[[threshold_ripple]]`: mains or PWM pick-up: a shift of angle sin(2 pi f t + phase), taken at the very time of the edge.
///
/// Each mark changes once for each passage of the shaft: a shaft slower than the level's swing does not make it chatter, as a comparator's
/// own hysteresis sees to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ThresholdRipple {
    /// Frequency, up to 1 MHz.
    pub f_hz: f64,
    /// Phase at time 0.
    #[serde(default)]
    pub phase_rad: f64,
    /// Amplitude: the level's swing over the signal's slope; up to an eighth of a line, with all other shifts of the level.
    pub angle_rad: f64,
    /// The channel it is on; all where left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channel: Option<Channel>,
}

/// `[[threshold_drift]]`: lamp or temperature: a shift of angle (1 - exp(-(t - from) / tau)) from a time on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ThresholdDrift {
    /// Where it settles, of either sign; up to an eighth of a line, with all other shifts of the level.
    pub angle_rad: f64,
    /// Time constant, above 0.
    pub tau_s: f64,
    /// When it begins, 0 or later.
    #[serde(default)]
    pub from_s: f64,
    /// The channel it is on; all where left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channel: Option<Channel>,
}

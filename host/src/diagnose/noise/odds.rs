//! Probabilities.

use std::f64::consts::SQRT_2;

/// Probability that a normal number is further up than this many standard deviations.
#[must_use]
pub fn normal_above(deviations: f64) -> f64 {
    0.5 * libm::erfc(deviations / SQRT_2)
}

/// Of one of so many places, each with this probability.
#[must_use]
pub fn anywhere(probability: f64, places: f64) -> f64 {
    -libm::expm1(places * libm::log1p(-probability.min(1.0 - 1e-16)))
}

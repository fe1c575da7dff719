//! Whether a mode rings all the time: torque noise drives it throughout, so each stretch of a recording by itself shows it at the
//! same frequency. What a step leaves is in one stretch, what sweeps is at another frequency in each, and what other stamps than
//! declared leave goes away with levels of the recording's own.

use super::super::noise_fit::simplex;
use super::mode_fit::Mode;
use super::mode_likelihood::{cost, misfit};
use super::spectral::Band;
use super::two_mass::TwoMass;

/// Stretches of a recording at the most.
const STRETCHES: usize = 8;
/// Part of a recording's gain that its stretches have together: shorter ones see less of a narrow peak.
const TOGETHER: f64 = 0.3;
/// Part of that which is left without the best of them, times what it would be if all were alike.
const WITHOUT_BEST: f64 = 0.4;
/// Part of the stretches that show it.
const MOST: f64 = 0.6;
/// Largest misfit of a stretch on the average.
const MISFIT: f64 = 2.5;

/// Into how many stretches to part a recording of so many seconds: each tells lines as far apart as the mode's peak is wide.
pub(super) fn stretches_of(seconds: f64, mode: &TwoMass) -> usize {
    let wide_hz = 2.0 * mode.damping_ratio * mode.f_hz;
    ((seconds * wide_hz) as usize).clamp(2, STRETCHES)
}

/// Twice the log likelihood ratio of a mode in each stretch, against levels of the recording's own.
fn gains(parts: &[Vec<Band>], mode: &Mode) -> Vec<f64> {
    let [torque, stamps] = mode.levels;
    let sum = |x: &[f64]| -> f64 {
        let each = parts.iter();
        each.map(|bands| cost(bands, x[0].exp(), x[1].exp(), None))
            .sum()
    };
    let own = simplex(&sum, &[0.0, 0.0], 0.2);
    let own = if sum(&own) < sum(&[torque.ln(), stamps.ln()]) {
        own
    } else {
        vec![torque.ln(), stamps.ln()]
    };
    parts
        .iter()
        .map(|bands| {
            cost(bands, own[0].exp(), own[1].exp(), None)
                - cost(bands, torque, stamps, Some(&mode.masses))
        })
        .collect()
}

/// Whether a mode of this gain in a recording rings in its stretches.
#[must_use]
pub(super) fn rings(parts: &[Vec<Band>], mode: &Mode, gain: f64) -> bool {
    let gains = gains(parts, mode);
    let count = gains.len() as f64;
    let sum: f64 = gains.iter().sum();
    let best = gains.iter().copied().fold(0.0, f64::max);
    let shown = gains.iter().filter(|gain| **gain > 0.0).count() as f64;
    let [torque, stamps] = mode.levels;
    let off = misfit(parts, &mode.masses, torque, stamps);
    sum > TOGETHER * gain
        && sum - best >= WITHOUT_BEST * sum * (count - 1.0) / count
        && shown >= MOST * count
        && off < MISFIT
}

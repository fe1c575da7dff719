//! The likelihood of a spectrum with a torsional mode in it.
//!
//! The spectrum of the innovations along time is a (1 - t) + g t |Z0 / Z|^2, with t the share that torque noise has in what the
//! filter expects, a and g the levels of stamps and torque, and |Z0 / Z|^2 of [`super::two_mass`], with what shakes the far side in it.
//! Its lines are exponential, so their likelihood is Whittle's, -sum(ln S + P / S) (Whittle, Arkiv foer Matematik 2, 1953). Tones,
//! which stand alone, are left out before.

use super::spectral::{Band, SEEN};
use super::two_mass::TwoMass;

/// The spectrum in a band: levels of torque and stamps, with or without a mode.
pub(super) fn expected(band: &Band, torque: f64, stamps: f64, mode: Option<&TwoMass>) -> f64 {
    let gain = mode.map_or(1.0, |mode| {
        let at = |f_hz: f64| mode.gain(f_hz, band.damping);
        match band.line_hz {
            Some(line_hz) => {
                let [side, middle] = SEEN;
                middle * at(band.f_hz) + side * (at(band.f_hz - line_hz) + at(band.f_hz + line_hz))
            }
            None => at(band.f_hz),
        }
    });
    stamps * (1.0 - band.torque) + torque * band.torque * gain
}

/// How unlikely bands are: twice the logarithm, less what hangs on nothing.
pub(super) fn cost(bands: &[Band], torque: f64, stamps: f64, mode: Option<&TwoMass>) -> f64 {
    let each = bands.iter().map(|band| {
        let expected = expected(band, torque, stamps, mode);
        2.0 * band.lines * (expected.ln() + band.power / expected)
    });
    each.sum()
}

/// The same for levels that few loud bands do not lift.
pub(super) fn usual(all: &[Vec<Band>], torque: f64, stamps: f64) -> f64 {
    const LOUD: f64 = 2.0;
    let each = all.iter().flatten().map(|band| {
        let expected = expected(band, torque, stamps, None);
        let ratio = band.power / expected;
        let size = if ratio < LOUD {
            ratio
        } else {
            LOUD * (1.0 + (ratio / LOUD).ln())
        };
        2.0 * band.lines * (expected.ln() + size)
    });
    each.sum()
}

/// Chi squared of what a mode leaves in wider bands around it, over their count.
pub(super) fn misfit(all: &[Vec<Band>], mode: &TwoMass, torque: f64, stamps: f64) -> f64 {
    let around = [0.6 * mode.f_hz, 1.6 * mode.f_hz];
    off(all, around, &|band| {
        expected(band, torque, stamps, Some(mode))
    })
}

/// Chi squared of bands from here to there against what is expected, over their count.
pub(super) fn off(
    all: &[Vec<Band>],
    [from_hz, until_hz]: [f64; 2],
    expected: &dyn Fn(&Band) -> f64,
) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for bands in all {
        let from = bands.partition_point(|band| band.f_hz < from_hz);
        let until = bands.partition_point(|band| band.f_hz < until_hz);
        for wide in bands[from..until.max(from)].chunks(12) {
            let (mut ratio, mut lines) = (0.0, 0.0);
            for band in wide {
                ratio += band.lines * band.power / expected(band);
                lines += band.lines;
            }
            // Exponential lines: the mean of so many, its cube root close to normal (Wilson and Hilferty, PNAS 17, 1931).
            let ninth = 1.0 / (9.0 * lines);
            let normal = ((ratio / lines).cbrt() - 1.0 + ninth) / ninth.sqrt();
            sum += normal * normal;
            count += 1.0;
        }
    }
    // Few bands scatter more.
    sum / (count + 6.0 * count.sqrt()).max(1.0)
}

//! Whether what is left is noise: rhythms, slow changes, places of the disc, and its scatter in time.

use rayon::prelude::*;

use super::board::{Board, Model};
use super::locate::{Along, Among, spectrum};
use super::rounding;

/// Something that is left and no mechanism explains.
#[derive(Clone, Debug, PartialEq)]
pub struct Leftover {
    /// What was looked at, in words: "between 12.0 and 19.5 Hz, all edges alike".
    pub text: String,
    /// Sum of squares above that of noise.
    pub squares: f64,
    /// Probability that noise shows as much anywhere in what was looked at.
    pub p_value: f64,
    /// Recording.
    pub bench: usize,
    /// Orders that bound it.
    pub orders: Vec<f64>,
    /// Frequencies that bound it, Hz.
    pub frequencies_hz: Vec<f64>,
    /// Edges that show it.
    pub among: Among,
}

/// Bands a factor of two in frequency.
const BANDS: usize = 14;

/// Everything that is left, strongest first; and the probability that the whole is noise.
#[must_use]
pub fn leftovers(board: &Board, model: &Model) -> (Vec<Leftover>, f64) {
    let mut all = Vec::new();
    let mut least: f64 = 1.0;
    for (number, bench) in board.benches.iter().enumerate() {
        if rounding::is_all_of(bench, &model.left[number]) {
            continue;
        }
        let seen = &bench.seen;
        let a_second = seen.turns() / seen.seconds().max(f64::MIN_POSITIVE);
        let mut amongs = Among::all(seen.classes);
        amongs.retain(|among| !matches!(among, Among::LevelOf(_)));
        let spectra = amongs.into_par_iter().map(|among| {
            let spectrum = spectrum(bench, &model.left[number], among, Along::Turn);
            (among, spectrum)
        });
        for (among, spectrum) in spectra.collect::<Vec<_>>() {
            let (points, mean) = independent(&spectrum.powers);
            let alike = among == Among::All;
            let top = spectrum.powers.len();
            // Single lines.
            if let Some(&(order, power)) = spectrum.peaks(0.0, 1).first() {
                let p = points * (-power / mean).exp();
                least = least.min(p);
                all.push(Leftover {
                    text: format!(
                        "order {order:.2} ({:.4} Hz at mean speed), {}",
                        order * a_second,
                        words(among)
                    ),
                    squares: 2.0 * power,
                    p_value: p.min(1.0),
                    bench: number,
                    orders: vec![order],
                    frequencies_hz: vec![order * a_second],
                    among,
                });
            }
            // Bands, each half as wide as the one above. Torque noise of another colour than the model's tilts the spectrum of all
            // edges alike: there a part of a band is held against the rest of it.
            // The model's torque noise is white up to the edges' own rate, which no torque is.
            let mut end = if alike { top / 2 } else { top };
            for _ in 0..BANDS {
                let start = (end / 2).max(1);
                if end < 16 {
                    break;
                }
                let parts = if alike { 8 } else { 1 };
                let usual = if alike {
                    independent(&spectrum.powers[start..end]).1
                } else {
                    mean
                };
                for part in 0..parts {
                    let width = (end - start).div_ceil(parts);
                    let (low, high) = (start + part * width, (start + (part + 1) * width).min(end));
                    if high < low + 6 {
                        continue;
                    }
                    let count = (high - low) as f64 * points / top as f64;
                    let sum: f64 = spectrum.powers[low..high]
                        .iter()
                        .map(|p| p / usual)
                        .sum::<f64>()
                        * points
                        / top as f64;
                    // The median is not known exactly either.
                    let own = if alike { 1.0 + 1.0 / parts as f64 } else { 1.0 };
                    let p = upper_tail((sum - count) / (count * own).sqrt(), count);
                    least = least.min(p);
                    if p < 1e-3 {
                        let (low, high) = (low as f64 * spectrum.step, high as f64 * spectrum.step);
                        all.push(Leftover {
                            text: format!(
                                "orders {low:.2} to {high:.2} ({:.3} to {:.3} Hz at mean speed), {}",
                                low * a_second,
                                high * a_second,
                                words(among)
                            ),
                            squares: 2.0 * (sum - count),
                            p_value: p,
                            bench: number,
                            orders: vec![low, high],
                            frequencies_hz: vec![low * a_second, high * a_second],
                            among,
                        });
                    }
                }
                end = start;
            }
        }
    }
    let bands = (board.benches.len() * 11 * BANDS) as f64;
    for one in &mut all {
        one.p_value = (one.p_value * bands).min(1.0);
    }
    all.retain(|one| one.p_value < 1e-4);
    all.sort_by(|a, b| b.squares.total_cmp(&a.squares));
    (all, (least * bands).min(1.0))
}

/// Independent entries of a padded spectrum, and their usual power: of most of them, so that a band does not hide in the mean.
fn independent(powers: &[f64]) -> (f64, f64) {
    let mut sorted: Vec<f64> = powers.to_vec();
    let middle = sorted.len() / 2;
    if sorted.is_empty() {
        return (1.0, 1.0);
    }
    let (_, median, _) = sorted.select_nth_unstable_by(middle, f64::total_cmp);
    let mean = (*median / std::f64::consts::LN_2).clamp(0.5, 2.0);
    (0.5 * powers.len() as f64, mean)
}

/// Probability of a mean of exponentials so many standard deviations up or more (Wilson and Hilferty's cube root of chi-square).
fn upper_tail(deviation: f64, count: f64) -> f64 {
    let freedom = 2.0 * count;
    let ratio = 1.0 + deviation / count.sqrt();
    if ratio <= 0.0 {
        return 1.0;
    }
    let third = 2.0 / (9.0 * freedom);
    let normal = (ratio.cbrt() - (1.0 - third)) / third.sqrt();
    0.5 * libm::erfc(normal / std::f64::consts::SQRT_2)
}

/// Edges in words.
#[must_use]
pub const fn words(among: Among) -> &'static str {
    match among {
        Among::All => "all edges alike",
        Among::Level | Among::LevelOf(_) => "rising against falling edges",
        Among::Channel(_) => "channel against channel",
    }
}

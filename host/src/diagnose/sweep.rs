//! Frequencies that sweep evenly with time, of which no single line explains much: found along straight lines through spectra of short
//! parts of a recording, and then closely, as one wave.

use std::f64::consts::TAU;

use rayon::prelude::*;
use realfft::num_complex::Complex;
use rustfft::FftPlanner;

use super::effect::Carrier;
use super::scan::{Spectrum, local_median};

/// Parts into which a recording is cut. Within one a sweep has to stay within about what the part tells apart: so many parts show sweeps
/// over as many frequencies as their square, few of them the slow ones that are lines in short parts.
const PARTS: [usize; 2] = [8, 64];
/// Values that a part needs.
const LEAST: usize = 8;
/// How much of a line counts in one part, in means of noise: what is loud for a short while is no sweep.
const LOUDEST: f32 = 12.0;
/// How much finer than a part the closer look cuts, and how many steps of the rate it looks to either side for each part.
const FINER: usize = 8;
const ASIDE: i64 = 2;

/// The sweep that stands out most by parts of each number.
pub fn carriers(spectrum: &Spectrum) -> Vec<Carrier> {
    let parts = PARTS.into_iter();
    let each =
        parts.filter_map(|parts| Some(closely(spectrum, parts, along_lines(spectrum, parts)?)));
    each.collect()
}

/// Frequency in the middle of the first part and of the last, Hz, of the straight line that has most power in all parts.
fn along_lines(spectrum: &Spectrum, parts: usize) -> Option<[f64; 2]> {
    let (first_s, last_s) = spectrum.ends();
    let part_s = (last_s - first_s) / parts as f64;
    let count = spectrum.values.len() / parts;
    if count < LEAST || part_s <= 0.0 {
        return None;
    }
    // Two points to what a part tells apart.
    let step = 0.5 / part_s;
    let power = (0..parts).into_par_iter().map(|part| {
        let from_s = first_s + part as f64 * part_s;
        let until = |until_s: f64| spectrum.along.partition_point(|at_s| *at_s < until_s);
        let own = until(from_s)..until(from_s + part_s);
        let own = Spectrum {
            values: spectrum.values[own.clone()].to_vec(),
            along: spectrum.along[own].to_vec(),
            unit: spectrum.unit,
        };
        if own.values.len() < LEAST {
            return vec![0.0; count];
        }
        let power = own.power(step, count);
        let each = power.iter().zip(local_median(&power));
        each.map(|(power, floor)| ((power / floor) as f32).min(LOUDEST))
            .collect()
    });
    let power: Vec<Vec<f32>> = power.collect();
    // No sweep is what a part of the recording hardly tells from a line, nor more than the parts can follow.
    let slowest = 4;
    let widest = 2 * parts;
    let best = (slowest..count).into_par_iter().map(|from| {
        let until = from.saturating_sub(widest).max(slowest)..(from + widest).min(count - 1) + 1;
        let until = until.filter(|until| until.abs_diff(from) > 1);
        let sum = |until: usize| {
            let slope = (until as f32 - from as f32) / (parts - 1) as f32;
            let each = power.iter().enumerate();
            each.map(|(part, power)| power[(from as f32 + slope * part as f32 + 0.5) as usize])
                .sum::<f32>()
        };
        let each = until.map(|until| (sum(until), from, until));
        each.max_by(|a, b| a.0.total_cmp(&b.0))
    });
    let (_, from, until) = best.flatten().max_by(|a, b| a.0.total_cmp(&b.0))?;
    Some([from as f64 * step, until as f64 * step])
}

/// The sweep near one by parts that is one wave all along.
fn closely(spectrum: &Spectrum, parts: usize, [from_hz, until_hz]: [f64; 2]) -> Carrier {
    let (first_s, last_s) = spectrum.ends();
    let seconds = last_s - first_s;
    let middle_s = 0.5 * (first_s + last_s);
    let rate = (until_hz - from_hz) * parts as f64 / ((parts - 1) as f64 * seconds);
    let middle_hz = 0.5 * (from_hz + until_hz);
    // The wave as it turns about the coarse one.
    let cells = FINER * parts;
    let mut turns = vec![Complex::<f64>::default(); cells];
    for (value, at_s) in spectrum.values.iter().zip(&spectrum.along) {
        let since_s = at_s - middle_s;
        let phase = TAU * since_s * (middle_hz + 0.5 * rate * since_s);
        let cell = ((at_s - first_s) / seconds * cells as f64) as usize;
        turns[cell.min(cells - 1)] += Complex::from_polar(*value, -phase);
    }
    let length = (2 * cells).next_power_of_two();
    let fft = FftPlanner::<f64>::new().plan_fft_forward(length);
    let aside = ASIDE * parts as i64;
    let step = 1.0 / (seconds * seconds);
    let cell_s = seconds / cells as f64;
    let best = (-aside..=aside).into_par_iter().map(|by| {
        let by = by as f64 * step;
        let mut row = vec![Complex::default(); length];
        for (cell, (out, value)) in row.iter_mut().zip(&turns).enumerate() {
            let since_s = (cell as f64 + 0.5) * cell_s - 0.5 * seconds;
            *out = value * Complex::from_polar(1.0, -0.5 * TAU * by * since_s * since_s);
        }
        fft.process(&mut row);
        let each = row.iter().map(Complex::norm_sqr).enumerate();
        let (at, most) = each.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default();
        let at = if 2 * at > length {
            at as f64 - length as f64
        } else {
            at as f64
        };
        (most, by, at / (length as f64 * cell_s))
    });
    let (_, by, off_hz) = best.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default();
    let rate = rate + by;
    Carrier::Chirp(middle_hz + off_hz - rate * middle_s, rate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn sweeps_over_few_frequencies_and_over_many_are_found_in_noise() {
        for (seed, rate) in [0.001, -0.004, 0.1, -0.15].into_iter().enumerate() {
            let mut dice = ChaCha8Rng::seed_from_u64(seed as u64);
            let along: Vec<f64> = (0..10_000).map(|at| 0.01 * at as f64).collect();
            let values = along.iter().map(|at_s| {
                let phase = TAU * at_s * (20.0 + 0.5 * rate * at_s);
                // Sum of squares over noise: 200.
                0.2 * phase.cos() + 3.46 * (dice.random::<f64>() - 0.5)
            });
            let spectrum = Spectrum {
                values: values.collect(),
                along: along.clone(),
                unit: 1.0,
            };
            let found = carriers(&spectrum).into_iter().any(|carrier| {
                let Carrier::Chirp(f_hz, by) = carrier else {
                    return false;
                };
                (f_hz - 20.0).abs() < 0.02 && (by - rate).abs() < 4e-4
            });
            assert!(found, "{rate}");
        }
    }
}

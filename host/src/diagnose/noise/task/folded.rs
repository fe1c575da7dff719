//! Rates of a task whose busy time is a good part of its period: edges that are late by less than noise still add up in the periodogram
//! of what is left against time, multiples summed (Schuster, Terrestrial Magnetism 3, 1898).

use super::super::super::board::Bench;
use super::super::super::spectrum::Spectrum;
use super::busy::Busy;
use super::stamps::Stamps;
use super::{FASTEST_HZ, SLOWEST_HZ};

/// The most cells of a periodogram.
const CELLS: f64 = (1 << 21) as f64;
/// Multiples summed.
const MULTIPLES: usize = 3;
/// Natural logarithm of the probability that a candidate needs to have by chance.
const BY_CHANCE: f64 = -24.0;
/// Cells of a period.
const PHASES: usize = 64;

/// A task by the rate that stands out most, if one does.
#[must_use]
pub fn by_rhythm(rows: &[Stamps<'_>], spectra: &[Spectrum]) -> Option<Busy> {
    rough(rows, candidate(spectra)?)
}

/// Power at a frequency in all recordings, as a smooth rhythm has it: fall of the sum of squares.
#[must_use]
pub fn tone(spectra: &[Spectrum], f_hz: f64) -> f64 {
    spectra
        .iter()
        .map(|spectrum| 2.0 * near(spectrum, f_hz))
        .sum()
}

/// Cells of time that show the fastest rate.
#[must_use]
pub fn cell_s(length_s: f64) -> f64 {
    (1.0 / (3.0 * FASTEST_HZ)).max(2.0 * length_s / CELLS)
}

/// Periodogram of what is left against time.
#[must_use]
pub fn spectrum(bench: &Bench, left: &[f64]) -> Spectrum {
    let seen = &bench.seen;
    let length = seen.seconds().max(f64::MIN_POSITIVE);
    let first = seen.times_s.first().copied().unwrap_or(0.0);
    let cell = cell_s(length);
    let numbers = (0..seen.len()).map(|at| {
        (
            seen.times_s[at] - first,
            left[at] * seen.speeds[at].signum(),
        )
    });
    Spectrum::of(numbers, length, cell, FASTEST_HZ.min(1.0 / (3.0 * cell)))
}

/// The greatest power of the entries about a frequency.
pub(super) fn near(spectrum: &Spectrum, f_hz: f64) -> f64 {
    let at = (f_hz / spectrum.step + 0.5) as usize;
    let around = spectrum
        .powers
        .get(at.saturating_sub(1)..(at + 2).min(spectrum.powers.len()));
    around.map_or(0.0, |powers| powers.iter().copied().fold(0.0, f64::max))
}

/// The rate least likely to stand out by chance.
fn candidate(spectra: &[Spectrum]) -> Option<f64> {
    let longest = spectra.iter().min_by(|a, b| a.step.total_cmp(&b.step))?;
    let top = longest.powers.len();
    let mut best = (0.0_f64, 0.0);
    for multiples in [1, MULTIPLES] {
        let from = (SLOWEST_HZ / longest.step) as usize * multiples;
        // The fastest multiple goes from entry to entry.
        for last in from.max(multiples)..top {
            let f_hz = last as f64 * longest.step / multiples as f64;
            let alone = near(longest, f_hz);
            if alone < 3.0 {
                continue;
            }
            let (mut sum, mut each) = (0.0, true);
            for spectrum in spectra {
                let own: f64 = (1..=multiples)
                    .map(|multiple| near(spectrum, f_hz * multiple as f64))
                    .sum();
                each &= own > 4.0 + 2.0 * multiples as f64;
                sum += own;
            }
            let chance = log_chance(sum, multiples * spectra.len());
            if each && chance < best.1 {
                best = (f_hz, chance);
            }
        }
    }
    (best.1 < BY_CHANCE).then_some(best.0)
}

/// Logarithm of the probability that so many exponential numbers, each the greatest of three, sum to more.
fn log_chance(sum: f64, count: usize) -> f64 {
    let mut term = 1.0;
    let mut all = 1.0;
    for at in 1..count {
        term *= sum / at as f64;
        all += term;
    }
    all.ln() - sum + count as f64 * 3.0_f64.ln()
}

/// Weight and weighted lateness of each part of the period.
fn folded(row: &Stamps<'_>, f_hz: f64) -> Vec<[f64; 2]> {
    let mut cells = vec![[0.0; 2]; PHASES];
    for at in 0..row.len() {
        let (time, weight, late) = (row.crossed_s(at), row.weight(at), row.late_s[at]);
        let cell = ((time * f_hz).rem_euclid(1.0) * PHASES as f64) as usize;
        let cell = &mut cells[cell.min(PHASES - 1)];
        *cell = [cell[0] + weight, cell[1] + weight * late];
    }
    cells
}

/// Rate, busy time and each recording's phase, from the edges folded over the period.
pub(super) fn rough(rows: &[Stamps<'_>], f_hz: f64) -> Option<Busy> {
    let folded: Vec<Vec<[f64; 2]>> = rows.iter().map(|row| folded(row, f_hz)).collect();
    let cell_s = 1.0 / (f_hz * PHASES as f64);
    let mut best: Option<(f64, Busy)> = None;
    for busy in 1..=PHASES / 2 {
        let busy_s = (busy as f64 + 0.5) * cell_s;
        let mut ends_s = Vec::with_capacity(rows.len());
        let mut sum = 0.0;
        for cells in &folded {
            let gain = |start: usize| {
                let (mut weight, mut mean, mut both, mut square, mut late) =
                    (0.0, 0.0, 0.0, 0.0, 0.0);
                for (at, cell) in cells.iter().enumerate() {
                    let since = ((at + PHASES - start) % PHASES) as f64 + 0.5;
                    let size = (busy_s - since * cell_s).max(0.0);
                    weight += cell[0];
                    mean += cell[0] * size;
                    late += cell[1];
                    both += cell[1] * size;
                    square += cell[0] * size * size;
                }
                // The mean is the shaft's.
                2.0 * (both - late * mean / weight) - (square - mean * mean / weight)
            };
            let each = (0..PHASES).map(|start| (start, gain(start)));
            let (start, gain) = each.max_by(|a, b| a.1.total_cmp(&b.1))?;
            sum += gain;
            ends_s.push(start as f64 * cell_s + busy_s);
        }
        if best.as_ref().is_none_or(|(other, _)| sum > *other) {
            best = Some((
                sum,
                Busy {
                    f_hz,
                    busy_s,
                    ends_s,
                },
            ));
        }
    }
    best.filter(|(gain, _)| *gain > 0.0)
        .map(|(_, task)| task.centred(rows))
}

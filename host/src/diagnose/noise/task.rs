//! `capture_latency` by a task: captures wait while a task runs, f times a second for a time b each.
//!
//! An edge that falls a time x into the busy time is stamped at its end: late by b - x. That repeats in time at f and its multiples,
//! which may lie above the rate of edges: turning unevenly, edges tell these from their aliases. So rates are looked for in the
//! periodogram of what is left against time, multiples summed (Schuster, Terrestrial Magnetism 3, 1898), and then f, b and each
//! recording's phase are fitted by least squares. Where an edge would have been stamped is what its neighbours let expect; its
//! own stamp is at the end of the busy time.

use super::super::board::{Bench, Board, Column};
use super::super::noise_fit::simplex;
use super::super::spectrum::Spectrum;
use super::odds::anywhere;
use super::{NoiseFinding, NoiseParameter};
use crate::mechanism::{Mechanism, TASK_HZ};

/// Slowest and fastest rate looked for, Hz.
const SLOWEST_HZ: f64 = TASK_HZ[0];
const FASTEST_HZ: f64 = TASK_HZ[1];
/// The most cells of a periodogram.
const CELLS: f64 = (1 << 21) as f64;
/// Multiples summed.
const MULTIPLES: usize = 3;
/// Natural logarithm of the probability that a candidate needs to have by chance.
const BY_CHANCE: f64 = -24.0;
/// Fall of the sum of squares that a finding needs beyond its cost, and over that of a smooth rhythm.
const LEAST_GAIN: f64 = 40.0;
const LEAST_OVER_TONE: f64 = 15.0;
/// Mean square that is left, at the most; 1 is noise.
const NOISE: f64 = 2.0;
/// Cells of a period.
const PHASES: usize = 64;

/// A task that was found.
#[derive(Clone, Debug)]
pub struct Task {
    /// As a finding.
    pub finding: NoiseFinding,
    /// Its pattern, white, as large as it is.
    pub column: Column,
    /// Fall of the sum of squares.
    pub squares: f64,
}

/// One recording: when each edge crossed, how much it says and how late it is.
struct Row<'a> {
    bench: &'a Bench,
    left: &'a [f64],
    crossed_s: Vec<f64>,
    weights: Vec<f64>,
    late_s: Vec<f64>,
}

/// Looks for a task in what is left, white.
#[must_use]
pub fn find(board: &Board, left: &[Vec<f64>]) -> Option<Task> {
    let slow = |bench: &Bench| {
        let speeds = bench.seen.speeds.iter().map(|speed| speed.abs());
        let (low, high) = speeds.fold((f64::INFINITY, 0.0_f64), |(low, high), w| {
            (low.min(w), high.max(w))
        });
        low < 0.1 * high
    };
    if board.benches.iter().any(slow) {
        return None;
    }
    let spectra: Vec<Spectrum> = board
        .benches
        .iter()
        .zip(left)
        .map(|(b, left)| spectrum(b, left))
        .collect();
    let (f_hz, places) = candidate(&spectra)?;
    let mut rows: Vec<Row<'_>> = board
        .benches
        .iter()
        .zip(left)
        .map(|(b, l)| Row::new(b, l))
        .collect();
    let mut numbers = rough(&rows, f_hz)?;
    for _ in 0..2 {
        numbers = refined(&rows, &numbers);
        rows.iter_mut()
            .enumerate()
            .for_each(|(at, row)| row.cross_again(&numbers, at));
    }
    let before: f64 = left.iter().flatten().map(|x| x * x).sum();
    let squares = before - cost(&rows, &numbers);
    let edges = board.edges() as f64;
    let count = 2 + rows.len();
    let delta_bic = squares - (count as f64) * edges.ln();
    let tone: f64 = spectra.iter().map(|s| 2.0 * near(s, f_hz)).sum();
    // With the task taken off there is noise, else it stands in for something larger.
    let noise = before - squares < NOISE * edges;
    if !noise || delta_bic < LEAST_GAIN || squares < tone + LEAST_OVER_TONE {
        return None;
    }
    let errors = errors(&rows, &numbers);
    let first = &rows[0];
    let phase = (numbers[2] - first.bench.seen.times_s[0]).rem_euclid(1.0 / numbers[0]);
    let phase = (phase + first.bench.seen.times_s[0]).rem_euclid(1.0 / numbers[0]);
    let values = [
        ("task_hz", numbers[0]),
        ("busy_s", numbers[1]),
        ("phase_s", phase),
    ];
    let parameters = values
        .into_iter()
        .zip(&errors)
        .map(|((name, value), error)| NoiseParameter {
            name,
            value,
            standard_error: *error,
        });
    let finding = NoiseFinding {
        mechanism: Mechanism::CaptureLatency,
        parameters: parameters.collect(),
        delta_bic,
        p_value: anywhere(libm::exp(-0.5 * squares), places),
        text: format!(
            "a task holds up captures {:.3} times a second for {:.3e} s each: edges within come at its end",
            numbers[0], numbers[1]
        ),
        frequencies_hz: vec![numbers[0]],
        times_s: Vec::new(),
        runner_up: Some((Mechanism::TorqueTone, squares - tone)),
    };
    let column = rows
        .iter()
        .enumerate()
        .map(|(at, row)| Some(row.pattern(&numbers, at)));
    Some(Task {
        finding,
        column: Column::of(column),
        squares,
    })
}

fn spectrum(bench: &Bench, left: &[f64]) -> Spectrum {
    let seen = &bench.seen;
    let length = seen.seconds().max(f64::MIN_POSITIVE);
    let first = seen.times_s.first().copied().unwrap_or(0.0);
    let cell = (1.0 / (3.0 * FASTEST_HZ)).max(2.0 * length / CELLS);
    let numbers = (0..seen.len()).map(|at| {
        (
            seen.times_s[at] - first,
            left[at] * seen.speeds[at].signum(),
        )
    });
    Spectrum::of(numbers, length, cell, FASTEST_HZ.min(1.0 / (3.0 * cell)))
}

/// The greatest power of the entries about a frequency.
fn near(spectrum: &Spectrum, f_hz: f64) -> f64 {
    let at = (f_hz / spectrum.step + 0.5) as usize;
    let around = spectrum
        .powers
        .get(at.saturating_sub(1)..(at + 2).min(spectrum.powers.len()));
    around.map_or(0.0, |powers| powers.iter().copied().fold(0.0, f64::max))
}

/// The rate least likely to stand out by chance, and how many were tried.
fn candidate(spectra: &[Spectrum]) -> Option<(f64, f64)> {
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
    (best.1 < BY_CHANCE).then_some((best.0, 2.0 * top as f64))
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

impl<'a> Row<'a> {
    fn new(bench: &'a Bench, left: &'a [f64]) -> Self {
        let precisions = bench.whitener().precisions();
        let speeds = &bench.seen.speeds;
        let weights = precisions
            .iter()
            .zip(speeds)
            .map(|(d, w)| d * w * w)
            .collect();
        let mut row = Self {
            bench,
            left,
            crossed_s: bench.seen.times_s.clone(),
            weights,
            late_s: vec![0.0; left.len()],
        };
        row.late_s = row.later(left);
        row.crossed_s
            .iter_mut()
            .zip(&row.late_s)
            .for_each(|(time, late)| *time -= late);
        row
    }

    /// How much later each edge is than the others let expect, s.
    fn later(&self, white: &[f64]) -> Vec<f64> {
        let mut rows = white.to_vec();
        self.bench.transposed(&mut rows);
        let each = rows.iter().zip(&self.weights).zip(&self.bench.seen.speeds);
        each.map(|((u, weight), w)| if *weight > 0.0 { -u * w / weight } else { 0.0 })
            .collect()
    }

    fn late(numbers: &[f64], at: usize, crossed_s: f64) -> f64 {
        let since = (crossed_s - numbers[2 + at]).rem_euclid(1.0 / numbers[0]);
        (numbers[1] - since).max(0.0)
    }

    /// The task's pattern, white.
    fn pattern(&self, numbers: &[f64], at: usize) -> Vec<f64> {
        let each = self.crossed_s.iter().zip(&self.bench.seen.speeds);
        self.bench.whitened(
            each.map(|(time, w)| -w * Self::late(numbers, at, *time))
                .collect(),
        )
    }

    /// Where edges crossed with the task's own part in their neighbours taken off.
    fn cross_again(&mut self, numbers: &[f64], at: usize) {
        let rest: Vec<f64> = self
            .left
            .iter()
            .zip(self.pattern(numbers, at))
            .map(|(l, p)| l - p)
            .collect();
        let more = self.later(&rest);
        for ((crossed, time), more) in self
            .crossed_s
            .iter_mut()
            .zip(&self.bench.seen.times_s)
            .zip(more)
        {
            *crossed = time - Self::late(numbers, at, *crossed) - more;
        }
    }

    /// Weight and weighted lateness of each part of the period.
    fn folded(&self, f_hz: f64) -> Vec<[f64; 2]> {
        let mut cells = vec![[0.0; 2]; PHASES];
        for ((time, weight), late) in self.crossed_s.iter().zip(&self.weights).zip(&self.late_s) {
            let cell = ((time * f_hz).rem_euclid(1.0) * PHASES as f64) as usize;
            let cell = &mut cells[cell.min(PHASES - 1)];
            *cell = [cell[0] + weight, cell[1] + weight * late];
        }
        cells
    }
}

fn cost(rows: &[Row<'_>], numbers: &[f64]) -> f64 {
    let each = rows.iter().enumerate().map(|(at, row)| {
        let pattern = row.pattern(numbers, at);
        row.left
            .iter()
            .zip(pattern)
            .map(|(l, p)| (l - p) * (l - p))
            .sum::<f64>()
    });
    each.sum()
}

/// Rate, busy time and each recording's phase, from the edges folded over the period.
fn rough(rows: &[Row<'_>], f_hz: f64) -> Option<Vec<f64>> {
    let folded: Vec<Vec<[f64; 2]>> = rows.iter().map(|row| row.folded(f_hz)).collect();
    let cell_s = 1.0 / (f_hz * PHASES as f64);
    let mut best: Option<(f64, Vec<f64>)> = None;
    for busy in 1..=PHASES / 2 {
        let busy_s = (busy as f64 + 0.5) * cell_s;
        let mut numbers = vec![f_hz, busy_s];
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
            numbers.push(start as f64 * cell_s);
        }
        if best.as_ref().is_none_or(|(other, _)| sum > *other) {
            best = Some((sum, numbers));
        }
    }
    best.filter(|(gain, _)| *gain > 0.0)
        .map(|(_, numbers)| numbers)
}

/// Steps that matter: of the rate, the busy time and each phase.
fn steps(rows: &[Row<'_>], numbers: &[f64]) -> Vec<f64> {
    let long = rows
        .iter()
        .map(|row| row.bench.seen.times_s.last().copied().unwrap_or(1.0))
        .fold(0.0, f64::max);
    let mut steps = vec![
        0.3 * numbers[1] * numbers[0] / long.max(f64::MIN_POSITIVE),
        0.2 * numbers[1],
    ];
    steps.resize(numbers.len(), 0.2 * numbers[1]);
    steps
}

fn refined(rows: &[Row<'_>], numbers: &[f64]) -> Vec<f64> {
    let steps = steps(rows, numbers);
    let place = |x: &[f64]| -> Vec<f64> {
        let mut there: Vec<f64> = (0..numbers.len())
            .map(|i| numbers[i] + steps[i] * x[i])
            .collect();
        there[0] = there[0].max(0.5 * numbers[0]);
        there[1] = there[1].clamp(0.02 * numbers[1], 0.9 / there[0]);
        there
    };
    let zero = vec![0.0; numbers.len()];
    place(&simplex(&|x| cost(rows, &place(x)), &zero, 1.0))
}

/// Standard errors of rate, busy time and the first phase, from how far the pattern moves.
fn errors(rows: &[Row<'_>], numbers: &[f64]) -> Vec<f64> {
    let steps: Vec<f64> = steps(rows, numbers).iter().map(|step| 0.1 * step).collect();
    let moved: Vec<Vec<Vec<f64>>> = (0..numbers.len())
        .map(|i| {
            let (mut up, mut down) = (numbers.to_vec(), numbers.to_vec());
            up[i] += steps[i];
            down[i] -= steps[i];
            let each = rows.iter().enumerate().map(|(at, row)| {
                let both = row.pattern(&up, at).into_iter().zip(row.pattern(&down, at));
                both.map(|(a, b)| (a - b) / (2.0 * steps[i])).collect()
            });
            each.collect()
        })
        .collect();
    let count = numbers.len();
    let information = nalgebra::DMatrix::from_fn(count, count, |i, j| {
        let pairs = moved[i].iter().flatten().zip(moved[j].iter().flatten());
        pairs.map(|(a, b)| a * b).sum::<f64>() * steps[i] * steps[j]
    });
    let covariance = information.try_inverse();
    let each = (0..count).map(|i| {
        covariance
            .as_ref()
            .map_or(f64::INFINITY, |c| c[(i, i)].max(0.0).sqrt() * steps[i])
    });
    each.take(3).collect()
}

//! Length of the whitened signals without what nuisance parameters explain.

use realfft::RealFftPlanner;

use super::passed::Passed;
use crate::rig::Rig;

/// Steps of the conjugate gradients, at most.
const STEPS: usize = 60;

/// What is left of the whitened signals after least squares in offset and mean speed of each recording, and in the disc's pattern, common to all, where
/// the twin does not give it.
pub(super) fn residual(rigs: &[Rig], runs: &[&Passed], signals: &[Vec<f64>]) -> Vec<f64> {
    let white = |signals: &[Vec<f64>]| -> Vec<Vec<f64>> {
        let each = runs.iter().zip(signals);
        each.map(|(run, signal)| run.whitener.apply(signal))
            .collect()
    };
    let nuisances: Vec<Vec<Vec<f64>>> = runs.iter().map(|run| nuisances(run)).collect();
    let mut left = white(signals);
    clear(&mut left, &nuisances);
    if rigs.iter().all(|rig| rig.disc_known) {
        return left.concat();
    }
    let edges = rigs[0].encoder.edges();
    let spread = |pattern: &[f64]| -> Vec<Vec<f64>> {
        let out = runs
            .iter()
            .map(|run| run.k.iter().map(|&k| pattern[k]).collect())
            .collect::<Vec<_>>();
        let mut out = white(&out);
        clear(&mut out, &nuisances);
        out
    };
    let gather = |left: &[Vec<f64>]| -> Vec<f64> {
        let mut sum = vec![0.0; edges];
        for (run, left) in runs.iter().zip(left) {
            let back = run.whitener.transposed(left);
            for (&k, value) in run.k.iter().zip(back) {
                sum[k] += value;
            }
        }
        sum
    };
    // The left side is close to a circulant: it is turned by its own spectrum, read off its answer to one edge.
    let mut one = vec![0.0; edges];
    one[edges / 2] = 1.0;
    let answer = gather(&spread(&one));
    let precondition = Circulant::new(&answer, edges / 2);
    let mut residual = gather(&left);
    let mut turned = precondition.solve(&residual);
    let mut direction = turned.clone();
    let mut product = dot(&residual, &turned);
    let first = product;
    for _ in 0..STEPS {
        if product.is_nan() || product <= 1e-10 * first || product <= 0.0 {
            break;
        }
        let moved = spread(&direction);
        let bend = norm2(&moved);
        if bend <= 0.0 {
            break;
        }
        let step = product / bend;
        for (left, moved) in left.iter_mut().flatten().zip(moved.iter().flatten()) {
            *left -= step * moved;
        }
        residual = gather(&left);
        turned = precondition.solve(&residual);
        let next = dot(&residual, &turned);
        let share = next / product;
        product = next;
        for (direction, turned) in direction.iter_mut().zip(&turned) {
            *direction = turned + share * *direction;
        }
    }
    left.concat()
}

/// Length of a signal.
pub(super) fn length(signal: &[f64]) -> f64 {
    dot(signal, signal).sqrt()
}

/// Takes out of a signal what others explain.
pub(super) fn take_out(signal: &mut [f64], others: Vec<Vec<f64>>) {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for mut other in others {
        let before = length(&other);
        for _ in 0..2 {
            for known in &basis {
                let share = dot(&other, known);
                other
                    .iter_mut()
                    .zip(known)
                    .for_each(|(o, k)| *o -= share * k);
            }
        }
        let after = length(&other);
        if after > 1e-6 * before && after > 0.0 {
            other.iter_mut().for_each(|o| *o /= after);
            basis.push(other);
        }
    }
    for column in &basis {
        let share = dot(signal, column);
        signal
            .iter_mut()
            .zip(column)
            .for_each(|(s, c)| *s -= share * c);
    }
}

/// Offset and mean speed of a recording, whitened, orthogonal and of length 1.
fn nuisances(run: &Passed) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    // An angle that is off moves all edges alike; a speed that is off moves one by the time gone, or by the way where it is off by a
    // share, as that of a shaft which was let go faster is.
    let mut columns = vec![vec![1.0; run.time.len()], run.angle.clone()];
    if !run.runs_down {
        columns.push(run.time.clone());
    }
    for column in columns {
        let mut white = run.whitener.apply(&column);
        let before = dot(&white, &white);
        for _ in 0..2 {
            for other in &basis {
                let share = dot(&white, other);
                white
                    .iter_mut()
                    .zip(other)
                    .for_each(|(w, o)| *w -= share * o);
            }
        }
        let after = dot(&white, &white);
        if after > 1e-9 * before && after > 0.0 {
            let scale = 1.0 / after.sqrt();
            white.iter_mut().for_each(|w| *w *= scale);
            basis.push(white);
        }
    }
    basis
}

fn clear(signals: &mut [Vec<f64>], nuisances: &[Vec<Vec<f64>>]) {
    for (signal, basis) in signals.iter_mut().zip(nuisances) {
        for column in basis {
            let share = dot(signal, column);
            signal
                .iter_mut()
                .zip(column)
                .for_each(|(s, c)| *s -= share * c);
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm2(signals: &[Vec<f64>]) -> f64 {
    signals.iter().map(|signal| dot(signal, signal)).sum()
}

/// A circulant matrix by its spectrum.
struct Circulant {
    forward: std::sync::Arc<dyn realfft::RealToComplex<f64>>,
    inverse: std::sync::Arc<dyn realfft::ComplexToReal<f64>>,
    gains: Vec<f64>,
}

impl Circulant {
    /// From the answer to a single 1 at a place.
    fn new(answer: &[f64], place: usize) -> Self {
        let mut planner = RealFftPlanner::new();
        let forward = planner.plan_fft_forward(answer.len());
        let inverse = planner.plan_fft_inverse(answer.len());
        let mut column = answer.to_vec();
        column.rotate_left(place);
        let mut spectrum = forward.make_output_vec();
        let _ = forward.process(&mut column, &mut spectrum);
        let most = spectrum.iter().fold(0.0, |most: f64, s| most.max(s.re));
        let gains = spectrum.iter().map(|s| 1.0 / s.re.max(1e-9 * most));
        Self {
            gains: gains.collect(),
            forward,
            inverse,
        }
    }

    fn solve(&self, right: &[f64]) -> Vec<f64> {
        let mut values = right.to_vec();
        let mut spectrum = self.forward.make_output_vec();
        let _ = self.forward.process(&mut values, &mut spectrum);
        for (value, gain) in spectrum.iter_mut().zip(&self.gains) {
            *value *= *gain / right.len() as f64;
        }
        // Rounding leaves a hair of an imaginary part where there can be none.
        spectrum[0].im = 0.0;
        if right.len().is_multiple_of(2)
            && let Some(last) = spectrum.last_mut()
        {
            last.im = 0.0;
        }
        let _ = self.inverse.process(&mut spectrum, &mut values);
        values
    }
}

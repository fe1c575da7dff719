//! From orders back to edges: what is to be taken from every edge is drawn on a coarse grid and interpolated.

use super::close::saturated;
use super::order::OrderPlan;
use super::scale::Fine;
use super::spectrum::{COEFFICIENT_BITS, Coefficient, Sample};
use super::transform::{phasor, turned};
use super::weigh::WEIGHT_ONE;
use crate::shape::CLASSES_MAX;

/// Edges between two samples at the most.
const APART_MAX: usize = 32;

/// Fraction bits of an interpolation's weights.
const WEIGHT_BITS: u32 = 30;

/// Cubic interpolation between the samples of a turn.
struct Curve<'a, S> {
    grid: &'a [S],
    /// Edges from one sample to the next.
    apart: usize,
    /// Weights of two samples on either side, for each number of edges past a sample: Lagrange's cubic.
    weights: [[i32; 4]; APART_MAX],
}

impl<'a, S: Sample> Curve<'a, S> {
    fn new(grid: &'a [S], apart: usize) -> Self {
        let weights = core::array::from_fn(|part| {
            let (n, t) = (apart as i64, part as i64);
            let all = [
                -t * (n - t) * (2 * n - t),
                3 * (n + t) * (n - t) * (2 * n - t),
                3 * (n + t) * t * (2 * n - t),
                -(n + t) * t * (n - t),
            ];
            all.map(|weight| saturated((weight << WEIGHT_BITS) / (6 * n * n * n).max(1)))
        });
        Self {
            grid,
            apart,
            weights,
        }
    }

    fn at(&self, sample: usize) -> i64 {
        let samples = self.grid.len();
        let wrapped = if sample >= samples {
            sample - samples
        } else {
            sample
        };
        self.grid
            .get(wrapped)
            .map_or(0, |sample| i64::from(sample.value()))
    }

    /// Value `part` edges after a sample.
    fn value(&self, sample: usize, part: usize) -> i64 {
        let Some(weights) = self.weights.get(part).filter(|_| part != 0) else {
            return self.at(sample);
        };
        let places = [sample + self.grid.len() - 1, sample, sample + 1, sample + 2];
        let sum: i64 = places
            .iter()
            .zip(weights)
            .map(|(&place, &weight)| self.at(place) * i64::from(weight))
            .sum();
        (sum + (1 << (WEIGHT_BITS - 1))) >> WEIGHT_BITS
    }
}

/// What is believed of the errors, beside the curve.
pub(super) struct Believed<'a> {
    /// Weight of all orders, Q15; the curve holds what single orders differ from that.
    pub common: u32,
    /// Geometry at orders 1 and 2.
    pub mounting: [Coefficient; 2],
    /// Means of the classes.
    pub offsets: &'a [i32; CLASSES_MAX],
}

/// Orders 1 and 2 from edge to edge.
struct Mounting {
    now: [[i32; 2]; 2],
    step: [[i32; 2]; 2],
}

impl Mounting {
    fn new(sizes: [Coefficient; 2], edges: usize) -> Self {
        Self {
            now: sizes.map(|size| [size.re, size.im]),
            step: [1, 2].map(|order| phasor(order, edges)),
        }
    }

    /// At the next edge, the first time at edge 0.
    fn next(&mut self) -> i64 {
        let mut sum = 0;
        for (now, step) in self.now.iter_mut().zip(self.step) {
            sum += i64::from(now[0]);
            *now = turned(*now, step);
        }
        // Twice the real part.
        sum >> (COEFFICIENT_BITS - 1)
    }
}

/// Adds the curve drawn in `grid` to every error, after weighing it, and puts right what
/// the motion found did to it.
///
/// The curve F is what is taken out of the errors as motion, with its sign turned. Where the shaft ran fast by a share v, an
/// edge's error came out short by v of it, from the time at which it was passed: it is put back with v = -dF/dtheta
/// (amplitude modulation, eq. (5)). What that makes of orders 1 and 2 lies at low orders that noise
/// drowns; those are left as they were weighed.
pub(super) fn draw<S: Sample>(
    errors: &mut [i32],
    grid: &[S],
    believed: &Believed<'_>,
    plan: OrderPlan,
    fine: Fine,
) {
    let classes = plan.edges / plan.lines;
    let edges = errors.len();
    let curve = Curve::new(grid, edges / grid.len().max(1));
    let (mut before, mut here) = (
        curve.value(grid.len() - 1, curve.apart - 1),
        curve.value(0, 0),
    );
    let (mut sample, mut part, mut class) = (0, 0, 0);
    let mut mounting = Mounting::new(believed.mounting, edges);
    let half = 1_i64 << (WEIGHT_ONE.trailing_zeros() - 1);
    // With few edges every order is single, and what is drawn is geometry.
    let scale = if plan.has_neighbours() {
        edges as i64
    } else {
        0
    };
    for error in errors {
        part += 1;
        if part == curve.apart {
            (sample, part) = (sample + 1, 0);
        }
        let next = curve.value(sample, part);
        let kept =
            (i64::from(*error) * i64::from(believed.common) + half) >> WEIGHT_ONE.trailing_zeros();
        let error_here = kept + here;
        let whole = error_here + i64::from(believed.offsets[class]);
        // Steps to either side, as a share of the grid's.
        let slope_q30 = ((next - before) * scale) >> (3 + fine.bits);
        let put_back = ((whole - mounting.next()) * slope_q30) >> 30;
        *error = saturated(error_here - put_back);
        (before, here) = (here, next);
        class = if class + 1 == classes { 0 } else { class + 1 };
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    const ALL: Believed<'static> = Believed {
        common: WEIGHT_ONE,
        mounting: [Coefficient { re: 0, im: 0 }; 2],
        offsets: &[0; CLASSES_MAX],
    };

    #[test]
    fn a_wave_on_a_coarse_grid_is_drawn_at_every_edge() {
        let (edges, samples) = (10_000_usize, 2500);
        let wave = |x: f64| 2e5 * (core::f64::consts::TAU * 30.0 * x + 0.4).sin();
        let grid: Vec<i32> = (0..samples)
            .map(|j| wave(j as f64 / 2500.0).round() as i32)
            .collect();
        let mut errors = std::vec![0; edges];
        let fine = Fine { bits: 10 };
        let plan = OrderPlan::new(edges, edges, 625);
        draw(&mut errors, &grid, &ALL, plan, fine);
        for (k, &error) in errors.iter().enumerate() {
            let want = wave(k as f64 / edges as f64);
            assert!((f64::from(error) - want).abs() < 3.0, "{k}: {error} {want}");
        }
    }

    #[test]
    fn a_pattern_modulated_by_a_known_swing_comes_back() {
        let edges = 400_usize;
        let fine = Fine { bits: 4 };
        let plan = OrderPlan::new(edges, edges, edges);
        let turn = 4_294_967_296.0 * 16.0;
        let angle = |k: usize, order: f64| core::f64::consts::TAU * order * k as f64 / edges as f64;
        // Errors of a 2000th of a turn and a swing of the speed by 10 % at order 3.
        let truth = |k: usize| turn / 2000.0 * angle(k, 90.0).sin();
        let swing = |k: usize| -0.1 / (3.0 * core::f64::consts::TAU) * turn * angle(k, 3.0).cos();
        let fast = |k: usize| 0.1 * angle(k, 3.0).sin();
        // e(observed) = motion + e (1 - v); what is taken out is the motion with its sign turned.
        let observed = |k: usize| swing(k) + truth(k) * (1.0 - fast(k));
        let mut errors: Vec<i32> = (0..edges).map(|k| observed(k) as i32).collect();
        let grid: Vec<i32> = (0..edges).map(|k| -swing(k) as i32).collect();
        draw(&mut errors, &grid, &ALL, plan, fine);
        for (k, &error) in errors.iter().enumerate() {
            let off = f64::from(error) - truth(k);
            assert!(off.abs() < 0.012 * turn / 2000.0, "{k}: {off}");
        }
    }
}

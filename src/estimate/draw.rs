//! From orders back to edges: what is to be taken from every edge is drawn on a coarse grid and interpolated.

use core::task::{Poll, ready};

use super::close::saturated;
use super::cursor::Cursor;
use super::order::OrderPlan;
use super::scale::Fine;
use super::spectrum::{COEFFICIENT_BITS, Coefficient, Sample};
use super::split::{phasor, turned};
use super::transform::AddOrders;
use super::weigh::WEIGHT_ONE;
use crate::shape::CLASSES_MAX;

/// Edges between two samples at the most.
const APART_MAX: usize = 32;

/// Fraction bits of an interpolation's weights.
const WEIGHT_BITS: u32 = 30;

/// Weights of two samples on either side, for each number of edges past a sample: Lagrange's cubic.
type CurveWeights = [[i32; 4]; APART_MAX];

/// Those at `part` edges of `apart`.
fn lagrange(apart: usize, part: usize) -> [i32; 4] {
    let (n, t) = (apart as i64, part as i64);
    let all = [
        -t * (n - t) * (2 * n - t),
        3 * (n + t) * (n - t) * (2 * n - t),
        3 * (n + t) * t * (2 * n - t),
        -(n + t) * t * (n - t),
    ];
    all.map(|weight| saturated((weight << WEIGHT_BITS) / (6 * n * n * n).max(1)))
}

/// Cubic interpolation between the samples of a turn.
struct Curve<'a, S> {
    grid: &'a [S],
    weights: &'a CurveWeights,
}

impl<S: Sample> Curve<'_, S> {
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
#[derive(Clone, Copy)]
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

/// Samples, rows of weights and edges of a slice.
const SAMPLES: usize = 2000;
const ROWS: usize = 8;
const EDGES: usize = 64;

/// Draws orders over the errors: adds their curve to every error, after weighing it, and puts right what the motion found did
/// to it.
///
/// The curve F is what is taken out of the errors as motion, with its sign turned. Where the shaft ran fast by a share v, an
/// edge's error came out short by v of it, from the time at which it was passed: it is put back with v = -dF/dtheta
/// (amplitude modulation, eq. (5)). What that makes of orders 1 and 2 lies at low orders that noise
/// drowns; those are left as they were weighed.
pub(super) struct Drawing {
    part: Part,
    cursor: Cursor,
}

// What one part works with takes the place of the last one's.
#[allow(clippy::large_enum_variant)]
enum Part {
    /// The grid is cleared.
    Clear,
    /// The orders are added up on it.
    Orders(AddOrders),
    Weights(CurveWeights),
    Edges(CurveWeights, Pen),
}

/// Where drawing has come to.
struct Pen {
    /// The curve at the edge before and at this one.
    before: i64,
    here: i64,
    /// The sample before the next edge, and how many edges that is past it.
    sample: usize,
    part: usize,
    class: usize,
    mounting: Mounting,
}

impl Drawing {
    pub(super) const START: Self = Self {
        part: Part::Clear,
        cursor: Cursor::START,
    };

    /// The `grid` has room for the samples of [`OrderPlan`]; order n of `more` is at n - 1.
    #[inline(never)]
    pub(super) fn slice<S: Sample>(
        &mut self,
        errors: &mut [i32],
        grid: &mut [S],
        more: &[Coefficient],
        believed: Believed<'_>,
        plan: OrderPlan,
        fine: Fine,
    ) -> Poll<()> {
        match &mut self.part {
            Part::Clear => {
                let stretch = self.cursor.next(SAMPLES, grid.len());
                grid[stretch].fill(S::of(0));
                ready!(self.cursor.at_end(grid.len()));
                *self = Self::at(Part::Orders(AddOrders::START));
            }
            Part::Orders(add) => {
                ready!(add.slice(grid, more));
                *self = Self::at(Part::Weights([[0; 4]; APART_MAX]));
            }
            Part::Weights(weights) => {
                let apart = plan.decimation.min(APART_MAX);
                for part in self.cursor.next(ROWS, apart) {
                    weights[part] = lagrange(apart, part);
                }
                ready!(self.cursor.at_end(apart));
                let curve = Curve { grid, weights };
                let pen = Pen {
                    before: curve.value(grid.len() - 1, apart - 1),
                    here: curve.value(0, 0),
                    sample: 0,
                    part: 0,
                    class: 0,
                    mounting: Mounting::new(believed.mounting, plan.edges),
                };
                *self = Self::at(Part::Edges(*weights, pen));
            }
            Part::Edges(weights, pen) => {
                let curve = Curve { grid, weights };
                for error in &mut errors[self.cursor.next(EDGES, plan.edges)] {
                    pen.draw(error, &curve, &believed, plan, fine);
                }
                return self.cursor.at_end(plan.edges);
            }
        }
        Poll::Pending
    }

    const fn at(part: Part) -> Self {
        Self {
            part,
            cursor: Cursor::START,
        }
    }
}

impl Pen {
    fn draw<S: Sample>(
        &mut self,
        error: &mut i32,
        curve: &Curve<'_, S>,
        believed: &Believed<'_>,
        plan: OrderPlan,
        fine: Fine,
    ) {
        const HALF: i64 = 1 << (WEIGHT_ONE.trailing_zeros() - 1);
        self.part += 1;
        if self.part == plan.decimation {
            (self.sample, self.part) = (self.sample + 1, 0);
        }
        let next = curve.value(self.sample, self.part);
        let kept =
            (i64::from(*error) * i64::from(believed.common) + HALF) >> WEIGHT_ONE.trailing_zeros();
        let error_here = kept + self.here;
        let whole = error_here + i64::from(believed.offsets[self.class]);
        // With few edges every order is single, and what is drawn is geometry.
        let scale = if plan.has_neighbours() {
            plan.edges as i64
        } else {
            0
        };
        // Steps to either side, as a share of the grid's.
        let slope_q30 = ((next - self.before) * scale) >> (3 + fine.bits);
        let put_back = ((whole - self.mounting.next()) * slope_q30) >> 30;
        *error = saturated(error_here - put_back);
        (self.before, self.here) = (self.here, next);
        let last = (self.class + 1) * plan.lines == plan.edges;
        self.class = if last { 0 } else { self.class + 1 };
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::super::cursor::whole;
    use super::*;
    use std::vec::Vec;

    fn draw(errors: &mut [i32], grid: &mut [i32], plan: OrderPlan, fine: Fine) {
        let mut drawing = Drawing::at(Part::Weights([[0; 4]; APART_MAX]));
        whole(|| drawing.slice(errors, grid, &[], ALL, plan, fine));
    }

    const ALL: Believed<'static> = Believed {
        common: WEIGHT_ONE,
        mounting: [Coefficient { re: 0, im: 0 }; 2],
        offsets: &[0; CLASSES_MAX],
    };

    #[test]
    fn a_wave_on_a_coarse_grid_is_drawn_at_every_edge() {
        let (edges, samples) = (10_000_usize, 2500);
        let wave = |x: f64| 2e5 * (core::f64::consts::TAU * 30.0 * x + 0.4).sin();
        let mut grid: Vec<i32> = (0..samples)
            .map(|j| wave(j as f64 / 2500.0).round() as i32)
            .collect();
        let mut errors = std::vec![0; edges];
        let fine = Fine { bits: 10 };
        let plan = OrderPlan::new(edges, edges, 625);
        draw(&mut errors, &mut grid, plan, fine);
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
        let mut grid: Vec<i32> = (0..edges).map(|k| -swing(k) as i32).collect();
        draw(&mut errors, &mut grid, plan, fine);
        for (k, &error) in errors.iter().enumerate() {
            let off = f64::from(error) - truth(k);
            assert!(off.abs() < 0.012 * turn / 2000.0, "{k}: {off}");
        }
    }
}

//! The rate of a loop, ever finer.
//!
//! A rate that is off by a part of an edge at the end takes another edge's speed at some samples, more of them the further it is off.

use rayon::prelude::*;

use super::gains::{Gains, Side, gains};
use super::solve::{unit, without};
use super::spans::Spans;
use crate::diagnose::kalman::Whitener;

/// Edges at the end by which the finest rates differ: the stamps say no more.
const FINEST: f64 = 4e-4;
/// Edges at the end that are looked through, and steps.
const AROUND: f64 = 0.02;
const STEPS: i32 = 10;
/// Deviations from which on an innovation is an event's.
const FAR: f64 = 3.0;

/// Edges that the longest recording would have since time 0.
fn edges(sides: &[Side]) -> f64 {
    let each = sides.iter().map(|side| side.sampled.edges_since_zero());
    each.fold(0.0, f64::max)
}

/// The rate near one, with known gains, that leaves fewest events: a sample that is taken a little too early or late sees the speed of
/// another edge, and the push that it gets wrong is one.
#[must_use]
pub fn polished(sides: &[Side], f_hz: f64, sizes: [f64; 2]) -> f64 {
    let edges = edges(sides);
    let of = |side| Events::of(side, f_hz, sizes);
    let sides: Vec<Events<'_>> = sides.par_iter().map(of).collect();
    let mut best = (f_hz, events(&sides, &[f_hz])[0]);
    let mut look = |step: f64, range: std::ops::RangeInclusive<i32>| {
        let middle = best.0;
        let rates = range.filter(|i| *i != 0);
        let rates: Vec<f64> = rates
            .map(|i| middle * (1.0 + f64::from(i) * step / edges))
            .collect();
        for (f, there) in rates.iter().zip(events(&sides, &rates)) {
            if there < best.1 {
                best = (*f, there);
            }
        }
    };
    look(AROUND / f64::from(STEPS), -STEPS..=STEPS);
    let mut step = 0.5 * AROUND / f64::from(STEPS);
    while step > FINEST {
        look(step, -1..=1);
        step *= 0.5;
    }
    best.0
}

/// A side with all that does not hang on the rate; its edges are those for a rate near.
struct Events<'a> {
    side: &'a Side<'a>,
    spans: Spans,
    whitener: Whitener,
    /// Steady pushes, white, orthonormal.
    steady: Vec<Vec<f64>>,
    sizes: [f64; 2],
}

impl<'a> Events<'a> {
    fn of(side: &'a Side<'a>, near: f64, sizes: [f64; 2]) -> Self {
        let edges = side.sampled.edges_for(near, 1);
        let whitener = side.sampled.whitener(&edges, side.noise);
        let spans = side.sampled.spans(edges);
        let mut orthonormal: Vec<Vec<f64>> = Vec::new();
        for mut steady in side.sampled.steady(&spans) {
            whitener.whiten(&mut steady);
            if let Some(before) = orthonormal.last() {
                without(&mut steady, before);
            }
            orthonormal.push(unit(steady));
        }
        Self {
            side,
            spans,
            whitener,
            steady: orthonormal,
            sizes,
        }
    }

    /// What a rate leaves, where what is far out counts little.
    fn left(&self, f_hz: f64) -> f64 {
        let sampled = &self.side.sampled;
        let mut left = sampled.angles_at(&self.spans.edges);
        for (column, size) in sampled.gains(&self.spans, f_hz).iter().zip(self.sizes) {
            for (angle, value) in left.iter_mut().zip(column) {
                *angle -= size * value;
            }
        }
        self.whitener.whiten(&mut left);
        for steady in &self.steady {
            without(&mut left, steady);
        }
        left.iter().map(|w| (w / FAR).powi(2).ln_1p()).sum()
    }
}

/// What some rates near one leave of all sides, in their order.
fn events(sides: &[Events<'_>], rates: &[f64]) -> Vec<f64> {
    let each = rates.par_iter().map(|f_hz| {
        let sides: Vec<f64> = sides.par_iter().map(|side| side.left(*f_hz)).collect();
        sides.into_iter().sum()
    });
    each.collect()
}

/// The best rate near one, to a small part of what shifts the last sample by an edge.
#[must_use]
pub fn sharpened(sides: &[Side], f_hz: f64) -> Option<(f64, Gains)> {
    let edges = edges(sides);
    let mut best = (f_hz, gains(sides, f_hz)?);
    let mut step = 0.2 / edges;
    while step > 2e-3 / edges {
        let around = [1.0 - step, 1.0 + step].map(|factor| best.0 * factor);
        let tried: Vec<(f64, Option<Gains>)> = around
            .into_par_iter()
            .map(|f_hz| (f_hz, gains(sides, f_hz)))
            .collect();
        let tried = tried.into_iter();
        let tried = tried.filter_map(|(f_hz, gains)| Some((f_hz, gains?)));
        match tried.min_by(|a, b| a.1.cost.total_cmp(&b.1.cost)) {
            Some(better) if better.1.cost < best.1.cost => best = better,
            _ => step *= 0.5,
        }
    }
    Some(best)
}

/// Least -2 log likelihood of the rates that shift the last sample by so many edges.
#[must_use]
pub fn beside(sides: &[Side], f_hz: f64, shift: f64) -> f64 {
    let edges = edges(sides);
    let cost = |way: f64| {
        let gains = gains(sides, f_hz * (1.0 + way * shift / edges));
        gains.map_or(f64::INFINITY, |gains| gains.cost)
    };
    let (below, above) = rayon::join(|| cost(-1.0), || cost(1.0));
    below.min(above)
}

/// Standard error of the rate: half of what makes events enough for a 95 % interval's edge.
#[must_use]
pub fn rate_error(sides: &[Side], f_hz: f64, sizes: [f64; 2]) -> f64 {
    let edges = edges(sides);
    let of = |side| Events::of(side, f_hz, sizes);
    let prepared: Vec<Events<'_>> = sides.par_iter().map(of).collect();
    let here = events(&prepared, &[f_hz])[0];
    // Which edge comes first is known no better than the stamps.
    let stamps = |side: &Side| side.noise.stamp_s * side.sampled.rate_hz;
    let mut shift = sides.iter().map(stamps).fold(FINEST, f64::max);
    let worse = |shift: f64| {
        let rates = [-1.0, 1.0].map(|way| f_hz * (1.0 + way * shift / edges));
        let ways = events(&prepared, &rates);
        ways[0].min(ways[1]) - here
    };
    while shift < 0.3 * edges && worse(shift) < 4.0 {
        shift *= 1.5;
    }
    0.5 * shift / edges * f_hz
}

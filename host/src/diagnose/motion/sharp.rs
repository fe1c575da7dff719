//! The rate of a loop, ever finer.
//!
//! A rate that is off by a part of an edge at the end takes another edge's speed at some samples, more of them the further it is off.

use super::gains::{Gains, Side, gains};
use super::solve::{unit, without};

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
    let cost = |f: f64| {
        let each = sides.iter().map(|side| events(side, f_hz, f, sizes));
        each.sum::<f64>()
    };
    let mut best = (f_hz, cost(f_hz));
    let mut look = |step: f64, range: std::ops::RangeInclusive<i32>| {
        let middle = best.0;
        for i in range.filter(|i| *i != 0) {
            let f = middle * (1.0 + f64::from(i) * step / edges);
            let there = cost(f);
            if there < best.1 {
                best = (f, there);
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

/// What a rate leaves of a side, where what is far out counts little; edges are those for the rate `near`.
fn events(side: &Side, near: f64, f_hz: f64, sizes: [f64; 2]) -> f64 {
    let all = side.sampled.edges_for(near, 1);
    let whitener = side.sampled.whitener(&all, side.noise);
    let mut left = side.sampled.angles_at(&all);
    for (column, size) in side.sampled.gains(&all, f_hz).iter().zip(sizes) {
        for (angle, value) in left.iter_mut().zip(column) {
            *angle -= size * value;
        }
    }
    whitener.whiten(&mut left);
    let mut before: Option<Vec<f64>> = None;
    for mut steady in side.sampled.steady(&all) {
        whitener.whiten(&mut steady);
        if let Some(before) = &before {
            without(&mut steady, before);
        }
        let steady = unit(steady);
        without(&mut left, &steady);
        before = Some(steady);
    }
    left.iter().map(|w| (w / FAR).powi(2).ln_1p()).sum()
}

/// The best rate near one, to a small part of what shifts the last sample by an edge.
#[must_use]
pub fn sharpened(sides: &[Side], f_hz: f64) -> Option<(f64, Gains)> {
    let edges = edges(sides);
    let mut best = (f_hz, gains(sides, f_hz)?);
    let mut step = 0.2 / edges;
    while step > 2e-3 / edges {
        let around = [1.0 - step, 1.0 + step].map(|factor| best.0 * factor);
        let tried = around
            .into_iter()
            .filter_map(|f_hz| Some((f_hz, gains(sides, f_hz)?)));
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
    let costs = [-1.0, 1.0].map(|way| gains(sides, f_hz * (1.0 + way * shift / edges)));
    let each = costs.map(|gains| gains.map_or(f64::INFINITY, |gains| gains.cost));
    each[0].min(each[1])
}

/// Standard error of the rate: half of what makes events enough for a 95 % interval's edge.
#[must_use]
pub fn rate_error(sides: &[Side], f_hz: f64, sizes: [f64; 2]) -> f64 {
    let edges = edges(sides);
    let cost = |f: f64| {
        let each = sides.iter().map(|side| events(side, f_hz, f, sizes));
        each.sum::<f64>()
    };
    let here = cost(f_hz);
    // Which edge comes first is known no better than the stamps.
    let stamps = |side: &Side| side.noise.stamp_s * side.sampled.rate_hz;
    let mut shift = sides.iter().map(stamps).fold(FINEST, f64::max);
    let worse = |shift: f64| {
        let ways = [-1.0, 1.0].map(|way| cost(f_hz * (1.0 + way * shift / edges)));
        ways[0].min(ways[1]) - here
    };
    while shift < 0.3 * edges && worse(shift) < 4.0 {
        shift *= 1.5;
    }
    0.5 * shift / edges * f_hz
}

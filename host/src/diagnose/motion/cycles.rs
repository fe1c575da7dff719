//! The slips of a recording between its rests, edge by edge, and the speed that they have on the whole.

use std::f64::consts::TAU;

use super::rests::{EDGES_LEAST, SLIPS_LEAST, Slips};
use super::slip::Wave;
use super::slip_fit::{Cycle, Fitted};
use crate::diagnose::run::Recorded;
use crate::sim::Simulation;

/// Slips fitted at the most.
const SLIPS_MOST: usize = 48;

/// The slips of a recording, edge by edge.
#[must_use]
pub fn cycles(one: &Recorded, slips: &Slips) -> Option<Vec<Cycle>> {
    let mut track = one.track.clone();
    if !track.anchored && !track.placed {
        track.starts_at(one.twin.shaft.initial_angle_rad);
    }
    let errors = Simulation::new(&one.twin).ok()?.true_errors();
    let past = |place: i64| {
        let edge = (place + track.origin).rem_euclid(track.edges) as usize;
        errors.get(edge).copied().unwrap_or(0.0)
    };
    let angle = |place: i64| (place + track.origin) as f64 * TAU / track.edges as f64 - past(place);
    let waves = Wave::of(&one.twin, slips.pull_rad_s);
    let first = |place: i64| {
        let theta = angle(place);
        let turned = waves.iter().map(|wave| {
            let phase_rad = (wave.order * theta + wave.phase_rad) * slips.way as f64;
            Wave { phase_rad, ..*wave }
        });
        turned.collect()
    };
    let each = (slips.ends.len() / SLIPS_MOST).max(1);
    let mut cycles = Vec::new();
    for &(from, to) in slips.ends.iter().step_by(each) {
        let passed = (slips.places[to] - slips.places[from]) * slips.way;
        if to - from + 1 < EDGES_LEAST || passed != (to - from) as i64 {
            continue;
        }
        cycles.push(Cycle {
            start_s: slips.times_s[from],
            start_rad: angle(slips.places[from]) * slips.way as f64,
            times_s: (from..=to)
                .map(|i| slips.times_s[i] - slips.times_s[from])
                .collect(),
            ways: (from..=to)
                .map(|i| (angle(slips.places[i]) - angle(slips.places[from])) * slips.way as f64)
                .collect(),
            waves: first(slips.places[from]),
        });
    }
    (cycles.len() >= SLIPS_LEAST).then_some(cycles)
}

/// Speed of the spring's far end and its standard error: breaking away is always at the same stretch.
#[must_use]
pub fn pull(all: &[(&Cycle, Fitted)]) -> Option<(f64, f64)> {
    let points = || {
        all.iter()
            .map(|(cycle, fit)| (cycle.start_s + fit.at[3], cycle.start_rad + fit.at[4]))
    };
    let (time, angle) = (mean(points().map(|p| p.0)), mean(points().map(|p| p.1)));
    let long: f64 = points().map(|p| (p.0 - time).powi(2)).sum();
    let along: f64 = points().map(|p| (p.0 - time) * (p.1 - angle)).sum();
    let speed = along / long;
    let off: f64 = points()
        .map(|p| (p.1 - angle - speed * (p.0 - time)).powi(2))
        .sum();
    let error = (off / (all.len() as f64 - 2.0) / long).sqrt();
    (speed.is_finite() && speed > 0.0 && error.is_finite()).then_some((speed, error))
}

/// Mean of numbers.
#[must_use]
pub fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

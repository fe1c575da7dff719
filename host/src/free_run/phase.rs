//! When a loop takes its samples, where the recording's clock does not tell.
//!
//! Samples at wrong times see the wrong intervals and make torques that were not there. Those do not repeat from turn to turn, so the
//! right times leave the least scatter. One wrong torque spoils the speed from there on, so the scatter looked at is that around the speed
//! nearby: then it grows with the share of wrong samples, steps of a part of an interval find the dip, and halving narrows it down to
//! a tick.

use super::fit::{self, Data};
use super::model::LoopModel;
use super::push::Push;

/// Steps to an interval in the first search, and bounds of their number.
const STEPS_AN_INTERVAL: f64 = 5.0;
const STEPS_LEAST: f64 = 40.0;
const STEPS_MOST: f64 = 400.0;
/// Turns that are looked at.
const TURNS: usize = 5;

/// The best of the sample times tried.
#[derive(Clone, Copy)]
struct Best {
    phase_s: f64,
    scatter: f64,
}

impl Best {
    const NONE: Self = Self {
        phase_s: 0.0,
        scatter: f64::INFINITY,
    };

    fn offer(&mut self, phase_s: f64, scatter: Option<f64>) {
        if let Some(scatter) = scatter.filter(|&scatter| scatter < self.scatter) {
            *self = Self { phase_s, scatter };
        }
    }
}

/// The sample time of a loop, s, 0 up to a sample's length, its gains known within a relative standard deviation. None with less than
/// three turns.
#[must_use]
#[allow(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss
)]
pub fn find(data: Data<'_>, model: &LoopModel, gains_within: f64) -> Option<f64> {
    let most = (TURNS * data.edges as usize).min(data.crossings.len());
    let data = Data {
        crossings: &data.crossings[..most],
        ..data
    };
    let (first, last) = (data.crossings.first()?, data.crossings.last()?);
    let clock = data.clock_hz as f64;
    let interval_s = (last.ticks - first.ticks) as f64 / clock / most as f64;
    let period = 1.0 / model.rate_hz;
    let steps = STEPS_AN_INTERVAL * period / interval_s;
    let steps = steps.clamp(STEPS_LEAST, STEPS_MOST).ceil();
    // Far enough to see two samples at work, and whole lines, whose classes differ.
    let reach = (2.0 * period / interval_s).ceil().clamp(4.0, 1e4) as usize;
    let scatter = |phase_s: f64| {
        let push = Push::Loop(LoopModel { phase_s, ..*model });
        fit::scatter(data, &push, gains_within, reach)
    };
    let mut best = Best::NONE;
    for step in 0..steps as u32 {
        let phase = f64::from(step) / steps * period;
        best.offer(phase, scatter(phase));
    }
    let mut reach = period / steps;
    while reach * clock > 0.5 {
        for part in [-0.75, -0.5, -0.25, 0.25, 0.5, 0.75] {
            let phase = best.phase_s + part * reach;
            best.offer(phase, scatter(phase));
        }
        reach *= 0.5;
    }
    // A loop timed by the capture's own clock samples on whole ticks, and up to a tick above an edge's stamp it has not seen that edge.
    let tick = (best.phase_s * clock).ceil();
    best.scatter = f64::INFINITY;
    for tick in [tick, tick - 1.0, tick + 1.0] {
        best.offer(tick / clock, scatter(tick / clock));
    }
    best.scatter
        .is_finite()
        .then_some(best.phase_s.rem_euclid(period))
}

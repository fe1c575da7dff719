//! What play does to a residual: marks lie further along forward than in reverse, and the twin's torques meet the shaft elsewhere.
//!
//! An edge of a head with hysteresis h shows the shaft h / 2 further along than its mark, so torques that go with the angle push
//! otherwise than without. Against a fine disc that is a small push in proportion to h; where a ripple has few edges a cycle it is not,
//! and the pattern is that of the h which leaves the smoothest motion.

use std::f64::consts::TAU;

use super::seen::Seen;
use super::swing::swing;

/// A little play, rad.
const LITTLE_RAD: f64 = 1e-6;
/// Phase of the fastest torque over an edge's step, from which on play is tried by size.
const COARSE: f64 = 0.5;
/// Phase between two sizes that are tried.
const APART: f64 = 0.4;
/// Times that the range around the best of them is cut by a third.
const CUTS: usize = 9;
/// Most that is tried, steps of the grid.
const MOST_STEPS: f64 = 2.0;

/// Angles of the edges for 1 rad of play on top of what the twin declares.
#[must_use]
pub fn column(seen: &Seen) -> Vec<f64> {
    let order = seen.torques.order();
    let play_rad = if order == 0.0 {
        None
    } else if order * TAU / seen.edges as f64 > COARSE && seen.reverses() {
        Some(*seen.smoothest.get_or_init(|| smoothest(seen, order)))
    } else {
        Some(LITTLE_RAD)
    };
    let moved = play_rad.map(|play_rad| (play_rad, moved(seen, play_rad)));
    let each = (0..seen.len()).map(|at| {
        let pushed = moved.as_ref().map_or(0.0, |(by, moved)| moved[at] / by);
        pushed - seen.side(at)
    });
    each.collect()
}

/// How much further the twin's torques take each edge where there is so much more play, rad.
fn moved(seen: &Seen, play_rad: f64) -> Vec<f64> {
    let mut other = seen.clone();
    other.play_rad += play_rad;
    let there = swing(&other, &other.torques).angles;
    let each = there.iter().zip(&seen.swings);
    each.map(|(there, here)| there - here).collect()
}

/// The play that leaves the smoothest motion, or a little one where none does.
fn smoothest(seen: &Seen, order: f64) -> f64 {
    let step_rad = 2.0 * APART / order;
    let most_rad = MOST_STEPS * TAU / seen.edges as f64;
    let sizes = (1..).map(|i| f64::from(i) * step_rad);
    let tried = sizes.take_while(|play_rad| *play_rad <= most_rad);
    let rough = |play_rad: f64| {
        let moved = moved(seen, play_rad);
        let angles = (0..seen.len())
            .map(|at| seen.angles[at] + play_rad * seen.side(at) - moved[at])
            .collect::<Vec<_>>();
        roughness(seen, &angles)
    };
    let least = (LITTLE_RAD, roughness(seen, &seen.angles));
    let pairs = tried.map(|play_rad| (play_rad, rough(play_rad)));
    let best = pairs.fold(least, |a, b| if b.1 < a.1 { b } else { a }).0;
    if best < step_rad {
        return best;
    }
    let (mut low, mut high) = (best - step_rad, best + step_rad);
    for _ in 0..CUTS {
        let third = (high - low) / 3.0;
        if rough(low + third) < rough(high - third) {
            high -= third;
        } else {
            low += third;
        }
    }
    0.5 * (low + high)
}

/// Mean square of the changes of speed from interval to interval, each over the time that torque noise had for it.
fn roughness(seen: &Seen, angles: &[f64]) -> f64 {
    let after = |at: usize| seen.readings[at].leap.after_s;
    let known = |at: usize| !seen.readings[at].anew && !seen.readings[at].fresh && after(at) > 0.0;
    let speed = |at: usize| (angles[at] - angles[at - 1]) / after(at);
    let pairs = (2..angles.len()).filter(|at| known(*at) && known(at - 1));
    let each = pairs.map(|at| (speed(at) - speed(at - 1)).powi(2) / (after(at) + after(at - 1)));
    each.sum()
}

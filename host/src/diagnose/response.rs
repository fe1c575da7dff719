//! What torques make of the angle along a residual: the response of the twin's shaft, linear about its course.

use super::seen::Seen;
use super::shaft::{AT_REST, Leap, ShaftLaw};

/// Response of the angle to an acceleration, rad/s^2, given at an edge's interval: at its start 0, middle 0.5, end 1.
#[must_use]
pub fn pushed(seen: &Seen, push: &dyn Fn(usize, f64) -> f64) -> Vec<f64> {
    let mut state = AT_REST;
    let strides = seen.strides();
    (0..seen.len())
        .map(|at| {
            if seen.follows(at) {
                state = AT_REST;
            } else if at > 0 {
                state = strides[at].step(state, [push(at, 0.0), push(at, 0.5), push(at, 1.0)]);
            }
            state[0]
        })
        .collect()
}

/// Response to torques that go as cos and sin of a phase, which is given at a share of the interval before an edge.
#[must_use]
pub fn pushed_round(
    seen: &Seen,
    law: &ShaftLaw,
    phase: &dyn Fn(usize, f64) -> f64,
) -> Vec<Vec<f64>> {
    /// Radians of a rhythm that a step may take.
    const STEP: f64 = 0.7;
    let size = 1.0 / law.inertia;
    let (mut cos, mut sin) = (vec![0.0; seen.len()], vec![0.0; seen.len()]);
    let (mut even, mut odd) = (AT_REST, AT_REST);
    let mut last = phase(0, 0.0).sin_cos();
    let strides = seen.strides();
    for at in 1..seen.len() {
        if seen.follows(at) {
            (even, odd) = (AT_REST, AT_REST);
            last = phase(at, 0.0).sin_cos();
            continue;
        }
        let whole = seen.readings[at].leap;
        let steps = ((phase(at, 0.0) - phase(at, -1.0)).abs() / STEP)
            .ceil()
            .clamp(1.0, 200.0);
        let leap = if steps == 1.0 {
            strides[at]
        } else {
            let part = Leap {
                after_s: whole.after_s / steps,
                ..whole
            };
            part.stride()
        };
        for step in 1..=steps as usize {
            let share = |part: f64| (step as f64 + part) / steps - 1.0;
            let half = phase(at, share(-0.5)).sin_cos();
            let here = phase(at, share(0.0)).sin_cos();
            even = leap.step(even, [last.1 * size, half.1 * size, here.1 * size]);
            odd = leap.step(odd, [last.0 * size, half.0 * size, here.0 * size]);
            last = here;
        }
        (cos[at], sin[at]) = (even[0], odd[0]);
    }
    vec![cos, sin]
}

/// Response to a friction, N m at a speed, while the drive is off: what is on balances friction.
#[must_use]
pub fn braked(seen: &Seen, law: &ShaftLaw, friction: &dyn Fn(f64) -> f64) -> Vec<Vec<f64>> {
    vec![pushed(seen, &|at, _| {
        if law.driven(seen.times_s[at]) {
            0.0
        } else {
            -friction(seen.speeds[at]) / law.inertia
        }
    })]
}

//! The bound of one order in closed form, for long recordings: densities of the noise at the order's own frequency.

use super::pass::Pass;

/// Pieces that a recording with changing speed is cut into.
const PIECES: usize = 4000;

/// Expected variance of one order's geometry, rad^2, where nothing else repeats with the turn, or with an unknown torque of the same
/// order. `edges` a turn carry the time stamps' noise; the speeds' changes are slow against the order's frequency.
#[must_use]
pub fn variance(passes: &[Pass], order: f64, edges: usize, ripple: bool) -> f64 {
    // Information on the geometry g, on the ripple's r, and on both, of y = g + h r.
    let (mut g, mut r, mut both) = (0.0, 0.0, (0.0, 0.0));
    for pass in passes {
        let end = pass.time(std::f64::consts::TAU * pass.turns as f64);
        let pieces = if pass.rate == 0.0 { 1 } else { PIECES };
        let length = end / pieces as f64;
        for piece in 0..pieces {
            let speed = pass.speed((piece as f64 + 0.5) * length);
            let information = length / (2.0 * density(pass, speed, order, edges));
            let (re, im) = pass.shaft.response(order * speed);
            g += information;
            r += information * (re * re + im * im);
            both = (both.0 + information * re, both.1 + information * im);
        }
    }
    let lost = if ripple {
        (both.0 * both.0 + both.1 * both.1) / r
    } else {
        0.0
    };
    let left = g - lost;
    if left > 1e-9 * g {
        1.0 / left
    } else {
        f64::INFINITY
    }
}

/// Two-sided density of the angle's noise at an order, rad^2/Hz, as `edges` samples a turn show it: time stamps, and torque noise with
/// what lies above the samples' reach folded down.
fn density(pass: &Pass, speed: f64, order: f64, edges: usize) -> f64 {
    let edges = edges as f64;
    let stamps = (speed * pass.stamp_s).powi(2) * std::f64::consts::TAU / (edges * speed);
    let torque = |order: f64| pass.shaft.angle_density(order * speed);
    stamps + torque(order) + torque(edges - order) + torque(edges + order)
}

//! Side bands against a plain Fourier sum.

extern crate std;
use super::*;
use std::vec::Vec;

const SAMPLES: usize = 4096;
/// Share of the speed that goes in a radian.
const FALL: f64 = 2e-3;
const SIZE: Coefficient = Coefficient {
    re: 50_000_000,
    im: -80_000_000,
};

fn angle(sample: usize) -> f64 {
    core::f64::consts::TAU * sample as f64 / SAMPLES as f64
}

/// What torque of an order makes beside its angle at a steady speed, folded between the ends of the turn.
fn beside(order: usize, friction: f64) -> Vec<f64> {
    let n = order as f64;
    let (re, im) = (f64::from(SIZE.re), f64::from(SIZE.im));
    let wave = |theta: f64| 2.0 * (re * (n * theta).cos() - im * (n * theta).sin());
    let quadrature = |theta: f64| -2.0 * (re * (n * theta).sin() + im * (n * theta).cos());
    let of = |sample| {
        let theta = angle(sample);
        let middle = theta - core::f64::consts::PI;
        let swing = 2.0 * middle * (wave(theta) - wave(0.0));
        FALL * (swing + (3.0 + friction) / n * quadrature(theta))
    };
    (0..SAMPLES).map(of).collect()
}

#[test]
fn side_bands_are_those_of_a_turn_of_falling_speed() {
    for (order, friction) in [(1, 1), (5, 0), (5, 2), (40, 1)] {
        let curve = beside(order, f64::from(friction));
        let known = Known { order, size: SIZE };
        for at in 1..=60 {
            let sum = |turn: fn(f64) -> f64| {
                let parts = curve.iter().enumerate();
                let sum: f64 = parts.map(|(k, x)| x * turn(at as f64 * angle(k))).sum();
                sum / SAMPLES as f64
            };
            let exact = [sum(f64::cos), -sum(f64::sin)];
            let fall_q30 = (FALL * f64::from(1 << 30)) as i64;
            let told = known.beside(at, i64::from(friction) << 16, fall_q30);
            for (told, exact) in [told.re, told.im].into_iter().zip(exact) {
                let off = (f64::from(told) - exact).abs();
                assert!(off < 300.0, "{order} at {at}: {told} {exact}");
            }
        }
    }
}

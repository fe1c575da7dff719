//! Rigs: encoder, speeds, noise and the errors that the engineer knows.

use std::f64::consts::TAU;

use crate::encoder::Encoder;
use crate::random::Dice;
use crate::rig::{NoiseShape, Order, Profile, Rig, Told};

/// Course of the speed in the recordings of a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One recording at one speed.
    Constant,
    /// Two recordings at two speeds.
    TwoSpeeds,
    /// A ramp to some times the speed.
    Ramp,
    /// From one direction into the other.
    Reversal,
    /// The drive goes off.
    RunDown,
    /// A speed loop at two speeds.
    Loops,
}

const LINES: [u32; 13] = [
    60, 100, 125, 200, 250, 360, 500, 512, 600, 1000, 1024, 1250, 2500,
];

/// The rigs of one case, one for each recording: the same but for speed, length and start.
#[must_use]
pub fn rigs(dice: &mut Dice, shape: Shape, fits: impl Fn(Encoder) -> bool) -> Vec<Rig> {
    let encoder = loop {
        let encoder = encoder(dice);
        if fits(encoder) {
            break encoder;
        }
    };
    let step = encoder.step_rad();
    let edges = dice.log_between(15_000.0, 55_000.0);
    let turns = (edges / encoder.edges() as f64).clamp(5.0, 60.0);
    let turns = (turns + dice.between(0.0, 0.9)) * if dice.chance(0.05) { 2.0 } else { 1.0 };
    let turns = turns.min(60.0);
    let ratio = dice.between(2.0, 3.5);
    // No interval below 6 us: a timer's interrupt has to keep up.
    let speed = dice.log_between(4.0, 80.0).min(step / 6e-6 / ratio);
    let way = turns * TAU;
    let clock_hz = dice.pick(&[84_000_000, 72_000_000, 168_000_000, 100_000_000]);
    let inertia = dice.log_between(1e-5, 1e-2);
    let mut damping = speed / dice.log_between(1.0, 30.0);
    let mut profiles = vec![Profile::Constant { speed }];
    let mut share = dice.between(0.05, 0.5);
    let mut coulomb = 0.0;
    let mut longest_s = 3.0 * way / speed;
    match shape {
        Shape::Constant => {}
        Shape::TwoSpeeds => profiles.push(Profile::Constant {
            speed: ratio * speed,
        }),
        Shape::Ramp => {
            let to = ratio * speed;
            let over_s = 0.9 * way / (0.5 * (speed + to));
            let (from, to) = if dice.chance(0.5) {
                (speed, to)
            } else {
                (to, speed)
            };
            profiles = vec![Profile::Ramp { from, to, over_s }];
        }
        Shape::Reversal => {
            let over_s = 1.7 * way / speed;
            profiles = vec![Profile::Ramp {
                from: speed,
                to: -speed,
                over_s,
            }];
        }
        Shape::RunDown => {
            // Viscous friction alone would leave a third of the speed at the end.
            damping = 0.6 * speed / way;
            share = 1.0;
            coulomb = 0.05 * damping * speed * inertia;
            let off_s = 0.1 * way / speed;
            profiles = vec![Profile::RunDown { speed, off_s }];
            longest_s = 1.8 * way / speed;
        }
        Shape::Loops => {
            let hz = dice.log_between(2.0, 20.0);
            let kp_n_m_s = inertia * TAU * hz;
            let ki_n_m = kp_n_m_s * TAU * hz / dice.between(5.0, 10.0);
            let f_hz = (50.0 * hz).min(speed / step / 3.0);
            share = 1.0;
            damping *= 0.1;
            let with = |speed| Profile::Loop {
                speed,
                f_hz,
                kp_n_m_s,
                ki_n_m,
            };
            profiles = vec![with(speed), with(ratio * speed)];
        }
    }
    let viscous = share * damping * inertia;
    let rig = Rig {
        encoder,
        disc_rad: disc(dice, encoder),
        disc_known: true,
        inertia,
        viscous,
        coulomb,
        stiffness: damping * inertia - viscous,
        start_rad: 0.0,
        ripples: ripples(dice, inertia, speed),
        noise_psd: 0.0,
        jitter_s: 0.0,
        noise_known: dice.chance(0.7),
        noise_shape: NoiseShape::White,
        told: Told::Whole,
        clock_hz,
        profile: profiles[0],
        turns,
        longest_s,
    };
    let wander = dice.log_between(2e-4, 5e-3) * speed * inertia;
    let noise_psd = 2.0 * rig.noise_damping(0.0) * wander * wander;
    let shortest = step / profiles.iter().fold(0.0, |most: f64, p| most.max(p.top()));
    let jitter_s = dice.log_between(1e-8, 1e-6).min(0.02 * shortest);
    profiles
        .iter()
        .map(|&profile| Rig {
            profile,
            noise_psd,
            jitter_s,
            start_rad: dice.between(0.0, TAU),
            ..rig.clone()
        })
        .collect()
}

fn encoder(dice: &mut Dice) -> Encoder {
    match dice.unit() {
        u if u < 0.8 => Encoder::Quadrature {
            lines: dice.pick(&LINES),
            index: dice.chance(0.7),
        },
        u if u < 0.88 => Encoder::Hall {
            pole_pairs: dice.whole(2, 5),
        },
        _ => Encoder::Wheel {
            teeth: dice.whole(24, 120),
        },
    }
}

/// Errors known from a calibration: lines, widths, quadrature, a little eccentricity.
fn disc(dice: &mut Dice, encoder: Encoder) -> Vec<f64> {
    let step = encoder.step_rad();
    let lines = step * dice.log_between(0.002, 0.03);
    let widths = [0, 1, 2].map(|_| step * dice.between(-0.05, 0.05));
    let shifts = [
        0.0,
        step * dice.between(-0.05, 0.05),
        step * dice.between(-0.05, 0.05),
    ];
    let (round, phase) = (step * dice.log_between(0.01, 0.5), dice.between(0.0, TAU));
    (0..encoder.edges())
        .map(|k| {
            let class = encoder.class(k);
            let width = if class.rises {
                0.0
            } else {
                widths[class.channel]
            };
            let grid = TAU * k as f64 / encoder.edges() as f64;
            // Cut, so that no edge passes its neighbour.
            lines * dice.normal().clamp(-4.0, 4.0)
                + width
                + shifts[class.channel]
                + round * libm::sin(grid - phase)
        })
        .collect()
}

fn ripples(dice: &mut Dice, inertia: f64, speed: f64) -> Vec<Order> {
    let count = dice.whole(0, 3);
    let base = f64::from(dice.whole(3, 8));
    (1..=count)
        .map(|harmonic| {
            let order = base * f64::from(harmonic);
            let swing = dice.log_between(3e-4, 5e-3);
            Order {
                order,
                phase_rad: dice.between(0.0, TAU),
                torque_n_m: swing * inertia * order * speed * speed,
            }
        })
        .collect()
}

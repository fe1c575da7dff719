//! Physics that is in no catalogue.

use std::f64::consts::TAU;

use super::effects::{non_integer, order_of, run_s, slowest};
use super::rigs::Shape;
use crate::effect::Effect;
use crate::random::Dice;
use crate::rig::Rig;

/// How many there are.
pub const COUNT: u32 = 7;

/// Speeds that show that it is none of the catalogue's.
#[must_use]
pub const fn shape(which: u32) -> Shape {
    match which {
        0 => Shape::Ramp,
        _ => Shape::Constant,
    }
}

/// Physics of a number, with any size.
#[must_use]
pub fn effect(dice: &mut Dice, which: u32, rigs: &[Rig]) -> Effect {
    let rig = &rigs[0];
    let speed = slowest(rigs);
    let long = run_s(rig);
    let edges = rig.encoder.edges() as f64;
    let way = rig.turns * TAU;
    let angle_rad = 0.01 * rig.encoder.step_rad();
    match which {
        0 => Effect::Whirl {
            amplitude_rad: angle_rad,
            phase_rad: dice.between(0.0, TAU),
            critical_rad_s: speed * dice.between(1.3, 2.0),
            damping_ratio: dice.between(0.03, 0.1),
        },
        1 => {
            let f_hz = dice.log_between(20.0 / long, 0.02 * edges * speed / TAU);
            Effect::Chirp {
                f_hz,
                rate_hz_s: f_hz * dice.between(0.5, 1.5) / long,
                torque_n_m: 1e-3 * rig.inertia * speed * TAU * f_hz,
            }
        }
        2 => {
            let order = non_integer(dice, edges * 0.5).max(2.3);
            Effect::OrderChirp {
                order,
                rate_per_rad: order * dice.between(0.5, 1.5) / way,
                torque_n_m: order_of(rig, order, 0.0, speed).torque_n_m,
            }
        }
        3 => {
            let order = non_integer(dice, edges * 0.5).max(2.3);
            let f_hz = dice.between(2.0, 5.0) / long;
            Effect::ModulatedOrder {
                order,
                f_hz,
                rate_hz_s: f_hz * dice.between(5.0, 10.0) / long,
                torque_n_m: order_of(rig, order, 0.0, speed).torque_n_m,
            }
        }
        4 => Effect::BurstNoise {
            angle_rad: speed * rig.stamp_rms_s(),
            share: dice.between(0.05, 0.2),
            rate_hz: dice.between(8.0, 20.0) / long,
            seed: dice.seed(),
        },
        5 => Effect::Telegraph {
            angle_rad,
            rate_hz: dice.between(10.0, 40.0) / long,
            seed: dice.seed(),
        },
        _ => Effect::Creep {
            per_turn_rad: angle_rad,
            snaps: dice.between(0.3, 1.0).max(6.0 / rig.turns),
            seed: dice.seed(),
        },
    }
}

//! Look-alikes: what else would move the edges of one recording as an effect does.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::effect::Effect;
use crate::rig::{Order, Rig};

/// Effects of other mechanisms whose sum, each of any size, comes closest to an effect. Small, so that all answers are linear.
pub(super) fn look_alikes(effect: &Effect, rigs: &[Rig]) -> Vec<Effect> {
    let rig = &rigs[0];
    let speed = rig.profile.start();
    let step = rig.encoder.step_rad();
    let angle = 1e-3 * step;
    let late = [angle / rig.profile.top(); 3];
    let phases = [0.0, FRAC_PI_2];
    let torques = |order: f64| {
        phases.map(|phase_rad| {
            let torque_n_m = 1e-4 * rig.inertia * order * speed * speed;
            Effect::TorqueRipple(Order {
                order,
                phase_rad,
                torque_n_m,
            })
        })
    };
    let runouts = |order: f64| {
        phases.map(|phase_rad| Effect::BearingRunout {
            order,
            phase_rad,
            runout_rad: angle,
        })
    };
    match effect {
        Effect::Eccentricity { .. } => torques(1.0).to_vec(),
        Effect::DiscTilt { .. } => torques(2.0).to_vec(),
        Effect::TorqueRipple(o) => runouts(o.order).to_vec(),
        Effect::GearMesh(o) | Effect::BearingTorque(o) => {
            let f_hz = o.order * speed / TAU;
            let tones = phases.map(|phase_rad| Effect::TorqueTone {
                f_hz,
                phase_rad,
                torque_n_m: 1e-4 * rig.inertia * speed * TAU * f_hz,
            });
            tones.to_vec()
        }
        Effect::TorqueTone { f_hz, .. } => {
            let order = TAU * f_hz / speed;
            torques(order).into_iter().chain(runouts(order)).collect()
        }
        Effect::WidthError { .. } => [0, 1, 2]
            .map(|channel| {
                let mut fall_s = [0.0; 3];
                fall_s[channel] = late[channel];
                Effect::EdgeDelay {
                    rise_s: [0.0; 3],
                    fall_s,
                }
            })
            .to_vec(),
        Effect::EdgeDelay { .. } => [0, 1, 2]
            .map(|channel| {
                let mut rad = [0.0; 3];
                rad[channel] = angle;
                Effect::WidthError { rad }
            })
            .to_vec(),
        Effect::QuadratureError { .. } => vec![Effect::ChannelSkew {
            channel_s: [0.0, late[1], 0.0],
        }],
        Effect::ChannelSkew { .. } => vec![Effect::QuadratureError { rad: angle }],
        _ => Vec::new(),
    }
}

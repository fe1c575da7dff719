//! Effects under a larger pattern, and effects that the recording can't tell from others.

use super::case::{Drawn, add, sized};
use super::effects;
use super::rigs::{Shape, rigs};
use crate::effect::Effect;
use crate::ideal::{DETECTABLE, Ideal};
use crate::random::Dice;

/// What separates look-alikes, as d', stays below this.
const ALIKE: f64 = 1.5;

/// An effect under a pattern of the disc 10 to 100 times larger, that the twin gives or not.
pub(super) fn masked(dice: &mut Dice, drawn: &mut Drawn, number: usize, times: f64) -> Option<()> {
    let known = number.is_multiple_of(2);
    // What is locked to the turn is part of a pattern that the twin does not give.
    let ids: &[&str] = if known {
        &[
            "eccentricity",
            "local_defect",
            "torque_ripple",
            "gear_mesh",
            "edge_delay",
            "threshold_ripple",
        ]
    } else {
        &[
            "torque_ripple",
            "gear_mesh",
            "torque_tone",
            "edge_delay",
            "threshold_ripple",
        ]
    };
    let id = ids[(number / 2) % ids.len()];
    drawn.rigs = rigs(dice, Shape::TwoSpeeds, |encoder| {
        encoder.edges() >= 200 && effects::fits(id, encoder)
    });
    for rig in &mut drawn.rigs {
        rig.disc_known = known;
    }
    add(dice, drawn, id, times.max(5.0))?;
    let rms = Ideal::new(&drawn.rigs).rms(&drawn.effects[0].effect);
    let ratio = dice.log_between(10.0, 100.0);
    let step = drawn.rigs[0].encoder.step_rad();
    // White from edge to edge as far as edges keep their order, the rest in smooth low orders.
    let white = (0.7 * ratio * rms).min(0.04 * step);
    let smooth = ((ratio * rms).powi(2) - white * white).sqrt();
    if smooth > 0.03 {
        return None;
    }
    let orders: Vec<(f64, f64)> = (0..8)
        .map(|_| (dice.normal(), dice.between(0.0, std::f64::consts::TAU)))
        .collect();
    let power: f64 = orders.iter().map(|(a, _)| 0.5 * a * a).sum();
    let scale = smooth / power.sqrt();
    let pattern: Vec<f64> = (0..drawn.rigs[0].encoder.edges())
        .map(|k| {
            let grid = drawn.rigs[0].grid_rad(k);
            let low = orders
                .iter()
                .zip(1..)
                .map(|((a, phase), order)| scale * a * libm::sin(f64::from(order) * grid - phase));
            white * dice.normal().clamp(-4.0, 4.0) + low.sum::<f64>()
        })
        .collect();
    for rig in &mut drawn.rigs {
        rig.disc_rad.clone_from(&pattern);
    }
    drawn.mask = Some(ratio);
    Some(())
}

/// One of two mechanisms that one speed, or one reversal, can't tell apart.
pub(super) fn look_alike(dice: &mut Dice, drawn: &mut Drawn, number: usize) -> Option<()> {
    let pairs: [(&str, &[&str]); 7] = [
        ("eccentricity", &["eccentricity", "torque_ripple"]),
        ("torque_ripple", &["eccentricity", "torque_ripple"]),
        ("disc_tilt", &["disc_tilt", "torque_ripple"]),
        ("torque_tone", &["torque_tone", "gear_mesh", "bearing"]),
        ("gear_mesh", &["torque_tone", "gear_mesh", "bearing"]),
        ("width_error", &["width_error", "edge_delay"]),
        ("edge_delay", &["width_error", "edge_delay"]),
    ];
    let both: [(&str, &[&str]); 3] = [
        ("quadrature_error", &["quadrature_error", "channel_skew"]),
        ("hysteresis", &["hysteresis", "backlash"]),
        ("backlash", &["hysteresis", "backlash"]),
    ];
    let (id, alike) = *pairs.iter().chain(&both).nth(number % 10)?;
    let shape = if alike[0] == "hysteresis" {
        Shape::Reversal
    } else {
        Shape::Constant
    };
    drawn.rigs = rigs(dice, shape, |e| e.edges() >= 200 && effects::fits(id, e));
    // A known ripple pushes a shaft that is off its angle, not a disc that is: at orders where noise is small that tells them apart.
    drawn.rigs[0].ripples.clear();
    let times = dice.pick(&[3.0, 5.0, 10.0]);
    let mut effect = effects::effect(dice, id, &drawn.rigs);
    if let Effect::TorqueRipple(order) = &mut effect {
        order.order = 1.0;
    }
    if let Effect::WidthError { rad } = &mut effect {
        *rad = [rad[0]; 3];
    }
    // Wander tells fixed frequency from fixed order and both from fixed angle: it must be too small for that.
    let order = match &effect {
        Effect::TorqueTone { f_hz, .. } => {
            std::f64::consts::TAU * f_hz / drawn.rigs[0].profile.top()
        }
        Effect::GearMesh(order) => order.order,
        _ => 2.0,
    };
    let rig = &drawn.rigs[0];
    let speed = rig.profile.top();
    let correlation = speed / rig.damping(true);
    let way = std::f64::consts::TAU * rig.turns;
    let phase = rig.wander(speed) * (2.0 * correlation * way).sqrt() * order;
    let allowed = 1.0 / (DETECTABLE * times);
    if shape == Shape::Constant && phase > allowed {
        let share = (allowed / phase).powi(2);
        drawn.rigs.iter_mut().for_each(|rig| rig.noise_psd *= share);
    }
    let sized = sized(&drawn.rigs, &effect, times)?;
    if sized.separation.is_some_and(|apart| apart > ALIKE) {
        return None;
    }
    drawn.effects.push(sized);
    drawn.alike = alike.to_vec();
    Some(())
}

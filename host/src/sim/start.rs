//! Speed and states at time 0 where the equation of motion has terms beyond the plain one.

use nalgebra::Complex;

use super::drive::Knot;
use super::extended::Extended;
use super::plant::Plant;
use super::shaft::sign;
use super::spring::State;
use super::taylor::RippleTerm;
use crate::twin::Twin;

/// Speed at time 0, rad/s, with the states set to go with it: as if profile, ripples and tones had run so for long, to first order in
/// the swing. A shaft at rest starts at rest.
pub(super) fn settled(
    twin: &Twin,
    plant: &Plant,
    first: &Knot,
    ripples: &[RippleTerm],
    extended: &mut Extended,
) -> f64 {
    let angle = twin.shaft.initial_angle_rad;
    let mut speed = plant.profile_speed(twin);
    speed *= 1.0 + extended.effects.share_at_start(speed, angle);
    if let Some(twist) = &mut extended.twist {
        // The far side is accelerated through the spring alone.
        twist.angle = State::at(-first.rate / (twist.square * (1.0 - twist.share)));
    }
    if speed == 0.0 {
        return 0.0;
    }
    let friction = extended.friction;
    let damping = first.damping + friction.slope_at(speed);
    if let Some(spring) = &mut extended.spring {
        if damping < 0.0 {
            let hold = plant.coulomb + friction.stribeck;
            spring.stretch = State::at(sign(speed) * hold / spring.stiffness);
            return 0.0;
        }
        let against = plant.coulomb + friction.at(speed);
        let pull = plant.viscous * speed + sign(speed) * against;
        spring.stretch = State::at(pull / spring.stiffness);
    }
    let at_orders = ripples.iter().map(|ripple| {
        let phase = ripple.order * angle + ripple.phase_rad;
        (ripple.amplitude, ripple.order * speed, phase)
    });
    let tones: Vec<(f64, f64, f64)> = extended
        .tones
        .iter()
        .map(|tone| (tone.amplitude, tone.turning, tone.phase_rad))
        .chain(extended.effects.waves(speed, angle))
        .collect();
    let mut swing = 0.0;
    for (amplitude, turning, phase) in at_orders.chain(tones) {
        let (sin, cos) = libm::sincos(phase);
        swing += swing_of(
            extended,
            damping,
            turning,
            Complex::new(cos, sin) * amplitude,
        );
    }
    speed + swing + plant.start_wander(twin)
}

/// Speed swing that an acceleration, the imaginary part of `push` exp(i turning t), makes at time 0; adds to the states.
fn swing_of(extended: &mut Extended, damping: f64, turning: f64, push: Complex<f64>) -> f64 {
    let ahead = Complex::new(0.0, turning);
    let gain = extended.gain();
    let stiffness = extended
        .spring
        .as_ref()
        .map_or(0.0, |spring| spring.stiffness);
    let mut impedance = ahead + (stiffness / ahead + damping) * gain;
    // The twist for a speed of 1.
    let mut twist_per_speed = Complex::new(0.0, 0.0);
    if let Some(twist) = &extended.twist {
        let pull = ahead * twist.damping + twist.square;
        twist_per_speed = -ahead / (pull * (1.0 - twist.share) - turning * turning);
        impedance -= pull * twist_per_speed * twist.share;
    }
    let speed = push * gain / impedance;
    if let Some(spring) = &mut extended.spring {
        spring.stretch.series[0] -= (speed / ahead).im;
    }
    if let Some(twist) = &mut extended.twist {
        let angle = speed * twist_per_speed;
        twist.angle.series[0] += angle.im;
        twist.speed.series[0] += (angle * ahead).im;
    }
    speed.im
}

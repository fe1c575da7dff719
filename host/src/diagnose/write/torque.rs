//! Sections of what moves the shaft: torques, friction, the drive.

use std::f64::consts::TAU;

use super::rhythm::{Phasor, Span, same_or};
use crate::diagnose::effect::Carrier;
use crate::diagnose::plant::Swing;
use crate::twin::{LoadStep, Ripple, SpeedDrift, TorqueTone, Twin};

/// Torques and friction.
pub fn put_torque(
    twin: &mut Twin,
    carrier: Carrier,
    (size, wave): (f64, Phasor),
    span: &Span,
) -> bool {
    let shaft = &mut twin.shaft;
    match carrier {
        Carrier::Order(order) => put_order(twin, order, wave, span),
        Carrier::Tone(f_hz) => put_tone(twin, f_hz, wave, span),
        Carrier::Window(from_s, until_s) => twin.load_step.push(LoadStep {
            torque_n_m: size,
            from_s: from_s.max(0.0),
            until_s: until_s.is_finite().then_some(until_s),
        }),
        Carrier::Power(0.0) => shaft.coulomb_n_m += size,
        Carrier::Power(1.0) => shaft.viscous_n_m_s += size,
        Carrier::Power(2.0) => shaft.drag_n_m_s2 += size,
        Carrier::Stribeck(speed) if shaft.stribeck_n_m == 0.0 => {
            (shaft.stribeck_n_m, shaft.stribeck_rad_s) = (size, speed);
        }
        _ => return false,
    }
    true
}

/// Phase, torque and relative swing of the speed that a section of torque has.
type Parts<'a> = (&'a mut f64, &'a mut Option<f64>, &'a mut Option<f64>);

/// Adds a torque to that of a section; `turning` is its rate, rad/s.
fn add(wave: Phasor, swing: &Swing, turning: f64, (phase_rad, torque, fraction): Parts<'_>) {
    let mut sum = swing.torque(turning, *torque, *fraction);
    wave.add_to(&mut sum, phase_rad);
    (*torque, *fraction) = swing.sized(turning, sum);
}

/// Torque at an order: more of a section that has that order, else a motor's where it is whole, or a gear's.
fn put_order(twin: &mut Twin, order: f64, wave: Phasor, span: &Span) {
    let swing = Swing::of(twin);
    let same = |there: f64| span.same_order(there, order);
    for one in &mut twin.bearing {
        if one.runout_rad.is_none() && same(one.order) {
            let parts = (
                &mut one.phase_rad,
                &mut one.torque_n_m,
                &mut one.speed_fraction,
            );
            return add(wave, &swing, one.order * swing.nominal, parts);
        }
    }
    let same = |there: &Ripple| same(there.order);
    let gears = order.fract() != 0.0 || twin.gear_mesh.iter().any(same);
    let into = if gears && !twin.ripple.iter().any(same) {
        &mut twin.gear_mesh
    } else {
        &mut twin.ripple
    };
    let new = Ripple {
        order,
        phase_rad: 0.0,
        torque_n_m: None,
        speed_fraction: None,
    };
    let one = same_or(into, same, new);
    let parts = (
        &mut one.phase_rad,
        &mut one.torque_n_m,
        &mut one.speed_fraction,
    );
    add(wave, &swing, one.order * swing.nominal, parts);
}

fn put_tone(twin: &mut Twin, f_hz: f64, wave: Phasor, span: &Span) {
    let swing = Swing::of(twin);
    let new = TorqueTone {
        f_hz,
        phase_rad: 0.0,
        torque_n_m: None,
        speed_fraction: None,
    };
    let same = |there: &TorqueTone| span.same_frequency(there.f_hz, f_hz);
    let one = same_or(&mut twin.torque_tone, same, new);
    let parts = (
        &mut one.phase_rad,
        &mut one.torque_n_m,
        &mut one.speed_fraction,
    );
    add(wave, &swing, TAU * one.f_hz, parts);
}

/// Slow changes of the drive's speed.
pub fn put_drift(twin: &mut Twin, carrier: Carrier, size: f64) -> bool {
    let there = twin.speed_drift;
    let (mut rate, mut settling) = (None, None);
    match (
        carrier,
        there.map_or(Some(0.0), |there| there.fraction_per_s),
    ) {
        (Carrier::Time, Some(before)) => rate = Some(before + size),
        (Carrier::Settling(from_s, tau_s), _) if there.is_none() && from_s <= 0.0 => {
            settling = Some((size, tau_s));
        }
        _ => return false,
    }
    twin.speed_drift = Some(SpeedDrift {
        fraction_per_s: rate,
        fraction: settling.map(|(size, _)| size),
        tau_s: settling.map(|(_, tau_s)| tau_s),
    });
    true
}

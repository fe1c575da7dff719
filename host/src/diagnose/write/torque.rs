//! Sections of what moves the shaft: torques, friction, the drive.

use std::f64::consts::TAU;

use nalgebra::Complex;

use super::rhythm::{Span, add_to, same_or, wave};
use crate::diagnose::diagnosis::Sized;
use crate::diagnose::effect::{Carrier, is_exact};
use crate::diagnose::plant::Swing;
use crate::twin::{LoadStep, Ripple, SpeedDrift, TorqueTone, Twin};

/// Torques and friction.
pub fn put_torque(twin: &mut Twin, cell: &Sized, span: &Span) -> bool {
    let (size, wave) = (cell.sizes[0], wave(&cell.sizes));
    let shaft = &mut twin.shaft;
    match cell.effect.carrier {
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

/// Adds a torque to that of a section; `$turning` is its rate, rad/s.
macro_rules! add {
    ($wave:expr, $swing:expr, $turning:expr, $one:expr) => {
        let mut torque = $swing.torque($turning, $one.torque_n_m, $one.speed_fraction);
        add_to($wave, &mut torque, &mut $one.phase_rad);
        ($one.torque_n_m, $one.speed_fraction) = $swing.sized($turning, torque);
    };
}

/// Torque at an order: more of a section that has that order, else a motor's or an engine's where it is exact, or a gear's.
fn put_order(twin: &mut Twin, order: f64, wave: Complex<f64>, span: &Span) {
    let swing = Swing::of(twin);
    let same = |there: f64| span.same_order(there, order);
    for one in &mut twin.bearing {
        if one.runout_rad.is_none() && same(one.order) {
            add!(wave, swing, one.order * swing.nominal, one);
            return;
        }
    }
    let same = |there: &Ripple| same(there.order);
    let gears = !is_exact(order) || twin.gear_mesh.iter().any(same);
    let into = if gears && !twin.ripple.iter().any(same) {
        &mut twin.gear_mesh
    } else {
        &mut twin.ripple
    };
    let new = Ripple {
        order,
        ..Ripple::default()
    };
    let one = same_or(into, same, new);
    add!(wave, swing, one.order * swing.nominal, one);
}

fn put_tone(twin: &mut Twin, f_hz: f64, wave: Complex<f64>, span: &Span) {
    let swing = Swing::of(twin);
    let new = TorqueTone {
        f_hz,
        ..TorqueTone::default()
    };
    let same = |there: &TorqueTone| span.same_frequency(there.f_hz, f_hz);
    let one = same_or(&mut twin.torque_tone, same, new);
    add!(wave, swing, TAU * one.f_hz, one);
}

/// Slow changes of the drive's speed.
pub fn put_drift(twin: &mut Twin, carrier: Carrier, size: f64) -> bool {
    let there = twin.speed_drift;
    let rate = there.map_or(Some(0.0), |there| there.fraction_per_s);
    let (fraction_per_s, fraction, tau_s) = match carrier {
        Carrier::Time if rate.is_some() => (rate.map(|rate| rate + size), None, None),
        Carrier::Settling(from_s, tau_s) if there.is_none() && from_s <= 0.0 => {
            (None, Some(size), Some(tau_s))
        }
        _ => return false,
    };
    twin.speed_drift = Some(SpeedDrift {
        fraction_per_s,
        fraction,
        tau_s,
    });
    true
}

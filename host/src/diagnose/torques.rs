//! A twin whose torques are torques: what it declares by the swing that it makes at the nominal speed stays when the speed changes.

use std::f64::consts::TAU;

use super::kalman::ShaftNoise;
use super::shaft::ShaftLaw;
use crate::twin::{Noise, Twin};

/// The same twin with every ripple, mesh, bearing and tone as a torque.
#[must_use]
pub fn in_torques(twin: &Twin) -> Twin {
    let mut plain = twin.clone();
    let law = ShaftLaw::of(twin);
    let nominal = twin.drive.nominal_rad_s().abs();
    let damping = law.damping(0.0, 0.0);
    let torque = |turning: f64, torque_n_m: &mut Option<f64>, fraction: &mut Option<f64>| {
        if let (None, Some(swing)) = (*torque_n_m, fraction.take()) {
            *torque_n_m = Some(swing * nominal * turning.hypot(damping) * law.inertia);
        }
    };
    for one in plain.ripple.iter_mut().chain(&mut plain.gear_mesh) {
        torque(
            one.order * nominal,
            &mut one.torque_n_m,
            &mut one.speed_fraction,
        );
    }
    for one in plain
        .bearing
        .iter_mut()
        .filter(|one| one.runout_rad.is_none())
    {
        torque(
            one.order * nominal,
            &mut one.torque_n_m,
            &mut one.speed_fraction,
        );
    }
    for one in &mut plain.torque_tone {
        torque(TAU * one.f_hz, &mut one.torque_n_m, &mut one.speed_fraction);
    }
    plain
}

/// The same with white torque noise and stamps as they were found, `tick_s` being the timer's tick, and the drive as stiff as the law has it.
#[must_use]
pub fn in_noise(twin: &Twin, law: &ShaftLaw, noise: ShaftNoise, tick_s: f64) -> Twin {
    let mut noisy = in_torques(twin);
    let inertia = law.inertia;
    if twin.speed_loop().is_none() {
        let held = match twin.noise {
            Some(Noise::SpeedWander {
                correlation_rad: Some(correlation),
                ..
            }) => {
                twin.drive.nominal_rad_s().abs() / correlation * inertia - twin.shaft.viscous_n_m_s
            }
            _ => twin.shaft.stiffness_n_m_s,
        };
        noisy.shaft.stiffness_n_m_s = (held + noise.forgets_per_s * inertia).max(0.0);
    }
    noisy.noise = Some(Noise::White {
        psd_n2_m2_s: noise.acceleration * inertia * inertia,
        hold_s: None,
    });
    let own2 = noise.stamp_s * noise.stamp_s - tick_s * tick_s / 12.0;
    noisy.timer.jitter_s = own2.max(0.0).sqrt();
    // Its scatter is among the errors of the stamps; what a task held up is left out.
    noisy.capture_latency = None;
    noisy
}

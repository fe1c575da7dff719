//! What a twin has beside disc, shaft, drive, torques, run-out and delays, as patterns with sizes.

use super::basis::Basis;
use crate::twin::Twin;

/// How much further along a twin's marks lie forward than in reverse, rad.
#[must_use]
pub fn play_rad(twin: &Twin) -> f64 {
    twin.hysteresis.map_or(0.0, |h| h.angle_rad) + twin.backlash.map_or(0.0, |b| b.gap_rad)
}

/// Those patterns, each with its sizes; under a speed loop the simulated course has not felt the loads.
#[must_use]
pub fn known(twin: &Twin, looped: bool) -> Vec<(Basis, Vec<f64>)> {
    let mut known: Vec<(Basis, Vec<f64>)> = Vec::new();
    // size sin(x + phase)
    let round = |size: f64, phase: f64| vec![size * phase.sin(), size * phase.cos()];
    // Without a loop the simulated course has felt them.
    for load in twin.load_step.iter().filter(|_| looped) {
        let basis = Basis::Load {
            from_s: load.from_s,
            until_s: load.until_s.unwrap_or(f64::INFINITY),
        };
        known.push((basis, vec![load.torque_n_m]));
    }
    for ripple in &twin.threshold_ripple {
        let basis = Basis::LevelTone {
            f_hz: ripple.f_hz,
            channel: ripple.channel.map(|channel| channel as usize),
        };
        known.push((basis, round(ripple.angle_rad, ripple.phase_rad)));
    }
    for drift in &twin.threshold_drift {
        let basis = Basis::LevelDrift {
            from_s: drift.from_s,
            tau_s: drift.tau_s,
            channel: drift.channel.map(|channel| channel as usize),
        };
        known.push((basis, vec![drift.angle_rad]));
    }
    known.retain(|(_, sizes)| sizes.iter().any(|size| *size != 0.0));
    known
}

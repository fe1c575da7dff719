//! Springs against closed forms.

use super::*;
use crate::twin::{LoadStep, StickSlip, TorsionalResonance};

#[test]
fn a_load_step_sets_two_masses_swinging_as_the_closed_form_says() {
    let mut twin = plain(60.0, 1.0);
    twin.shaft.viscous_n_m_s = 0.0;
    twin.duration = Duration::Seconds(1.0);
    let (share, ratio, f_hz) = (0.3, 0.05, 25.0);
    twin.torsional_resonance = Some(TorsionalResonance {
        f_hz,
        damping_ratio: ratio,
        inertia_share: share,
        load_psd_n2_m2_s: None,
        load_hold_s: None,
    });
    twin.load_step = vec![LoadStep {
        torque_n_m: 2e-3,
        from_s: 0.1,
        until_s: None,
    }];
    // The masses' centre accelerates by T / J; the twist obeys d'' + 2 zeta w d' + w^2 d = -T / J1, and the near side is at the
    // centre less share d.
    let acceleration = 2e-3 / 1e-4;
    let free = TAU * f_hz;
    let damped = free * (1.0_f64 - ratio * ratio).sqrt();
    for event in Simulation::new(&twin).unwrap() {
        let t = event.truth.time_s;
        let s = (t - 0.1).max(0.0);
        let (sin, cos) = (damped * s).sin_cos();
        let left = (-ratio * free * s).exp() * (cos + ratio * free / damped * sin);
        let twist = -acceleration / (1.0 - share) / (free * free) * (1.0 - left);
        let expected = 60.0 * RAD_S * t + 0.5 * acceleration * s * s - share * twist;
        assert!((event.truth.angle_rad - expected).abs() < 1e-11, "at {t} s");
    }
}

#[test]
fn a_ripple_under_a_resonance_has_no_transient() {
    // Order 5 at 4 Hz turns at 20 Hz, close under 25 Hz; the swing is small, so that it is linear.
    let mut twin = plain(240.0, 12.0);
    twin.shaft.viscous_n_m_s = 0.0;
    twin.ripple = vec![Ripple {
        order: 5.0,
        phase_rad: 0.7,
        torque_n_m: Some(1e-6),
        speed_fraction: None,
    }];
    let (share, ratio, f_hz) = (0.3, 1e-6, 25.0);
    twin.torsional_resonance = Some(TorsionalResonance {
        f_hz,
        damping_ratio: ratio,
        inertia_share: share,
        load_psd_n2_m2_s: None,
        load_hold_s: None,
    });
    // Near side's swing over torque: -1 / (J W^2) (w^2 (1 - s) - W^2) / (1 - s) / (w^2 - W^2), undamped.
    let (free, turning) = (TAU * f_hz, TAU * 20.0);
    let (f2, t2) = (free * free, turning * turning);
    let size = 1e-6 / 1e-4 / t2 * (f2 * (1.0 - share) - t2) / (1.0 - share) / (f2 - t2);
    let mut largest: f64 = 0.0;
    let mut swing: f64 = 0.0;
    for event in Simulation::new(&twin).unwrap() {
        let Truth {
            time_s, angle_rad, ..
        } = event.truth;
        let at = |t: f64| -size * (turning * t + 0.7).sin();
        let found = angle_rad - 240.0 * RAD_S * time_s;
        largest = largest.max((found - at(time_s) + at(0.0)).abs());
        swing = swing.max(found.abs());
    }
    assert!(swing > size.abs(), "{swing:e} {size:e}");
    assert!(largest < 1e-3 * size.abs(), "{largest:e} of {size:e}");
}

/// A drive that pulls through a spring at `w` rad/s with a friction that falls with speed.
fn pulled(w: f64) -> Twin {
    let mut twin = plain(w / RAD_S, 0.5);
    twin.shaft.viscous_n_m_s = 1e-5;
    twin.shaft.coulomb_n_m = 2e-3;
    twin.shaft.stribeck_n_m = 2e-3;
    twin.shaft.stribeck_rad_s = 0.05;
    twin.stick_slip = Some(StickSlip {
        stiffness_n_m_rad: 0.1,
    });
    twin
}

#[test]
fn a_slow_shaft_sticks_and_slips_once_each_time_the_spring_is_wound_up() {
    let w = 0.02;
    let twin = pulled(w);
    let events: Vec<Event> = Simulation::new(&twin).unwrap().collect();
    // From slip to slip the spring's pull falls by about twice the difference of static and sliding friction.
    let expected_s = 2.0 * 2e-3 / 0.1 / w;
    let mut slips = Vec::new();
    for pair in events.windows(2) {
        if pair[1].truth.time_s - pair[0].truth.time_s > 0.3 * expected_s {
            // The end of a stick, to within an edge.
            slips.push(pair[1].truth.time_s);
        }
    }
    assert!(slips.len() > 20, "{}", slips.len());
    let periods: Vec<f64> = slips.windows(2).map(|w| w[1] - w[0]).collect();
    let first = periods[3];
    assert!(
        (first / expected_s - 1.0).abs() < 0.2,
        "{first} {expected_s}"
    );
    assert!(
        periods[3..].iter().all(|p| (p / first - 1.0).abs() < 0.03),
        "{periods:?}"
    );
}

#[test]
fn a_fast_one_slides_steadily_as_the_spring_holds_its_friction() {
    let twin = pulled(2.0);
    for event in Simulation::new(&twin).unwrap() {
        let miss = event.truth.angle_rad - 2.0 * event.truth.time_s;
        assert!(miss.abs() < 1e-11, "{miss:e}");
    }
}

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

#[test]
fn noise_behind_the_spring_makes_the_whole_shaft_walk() {
    let mut twin = plain(6000.0, 1.0);
    twin.encoder = Encoder::Hall { pole_pairs: 1 };
    twin.shaft.viscous_n_m_s = 0.0;
    twin.duration = Duration::Seconds(0.5);
    twin.torsional_resonance = Some(TorsionalResonance {
        f_hz: 40.0,
        damping_ratio: 0.5,
        inertia_share: 0.8,
        load_psd_n2_m2_s: Some(1e-9),
        load_hold_s: Some(1e-3),
    });
    // The speed of all of it is a random walk of S / J^2 a second, its angle the integral: variance S / J^2 t^3 / 3.
    let mut square = 0.0;
    for seed in 0..300 {
        twin.seed = seed;
        let last = Simulation::new(&twin).unwrap().last().unwrap().truth;
        let miss = last.angle_rad - 6000.0 * RAD_S * last.time_s;
        square += miss * miss / 300.0;
    }
    let expected = 1e-9 / 1e-8 * 0.5_f64.powi(3) / 3.0;
    // 300 runs give a variance to 8 %.
    assert!(
        (square / expected - 1.0).abs() < 0.3,
        "{square:e} {expected:e}"
    );
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
    // A slip is half a swing of mass and spring, in which the pull falls by twice the difference of static and sliding friction; the
    // drive winds that up again.
    let slip_s = TAU / 2.0 * (1e-4_f64 / 0.1).sqrt();
    let expected_s = 2.0 * 2e-3 / 0.1 / w + slip_s;
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
        (first / expected_s - 1.0).abs() < 0.05,
        "{first} {expected_s}"
    );
    assert!(
        periods[3..].iter().all(|p| (p / first - 1.0).abs() < 0.03),
        "{periods:?}"
    );
}

#[test]
fn a_spring_wound_up_to_within_rounding_of_friction_lets_the_shaft_go() {
    // Noise holds the shaft back now and then just before it breaks away, so that it stands for ever shorter.
    for seed in 0..10 {
        let mut twin = pulled(0.3);
        twin.seed = seed;
        twin.shaft.coulomb_n_m = 4e-3;
        twin.shaft.stribeck_n_m = 4e-4;
        twin.shaft.stribeck_rad_s = 0.2;
        twin.shaft.viscous_n_m_s = 1e-4;
        twin.stick_slip = Some(StickSlip {
            stiffness_n_m_rad: 4e-3,
        });
        twin.noise = Some(twin::Noise::White {
            psd_n2_m2_s: 1e-13,
            hold_s: Some(2e-2),
        });
        twin.duration = Duration::Seconds(300.0);
        let mut run = Simulation::new(&twin).unwrap();
        let mut pieces = 0;
        while !run.done && pieces < 100_000 {
            run.advance();
            pieces += 1;
        }
        assert!(run.done, "seed {seed}: at {} s", run.segment_start_s);
    }
}

#[test]
fn a_fast_one_slides_steadily_as_the_spring_holds_its_friction() {
    let twin = pulled(2.0);
    for event in Simulation::new(&twin).unwrap() {
        let miss = event.truth.angle_rad - 2.0 * event.truth.time_s;
        assert!(miss.abs() < 1e-11, "{miss:e}");
    }
}

#[test]
fn two_masses_with_tone_ripple_drag_and_drift_move_as_in_a_plain_runge_kutta() {
    let (inertia, share, f_hz, ratio) = (2e-4, 0.35, 30.0, 0.04);
    let mut twin = plain(60.0, 2.0);
    twin.duration = Duration::Seconds(1.5);
    twin.drive = Drive::Ramp {
        from_r_min: 0.0,
        to_r_min: 60.0,
        over_s: 1.0,
    };
    twin.shaft = twin::Shaft {
        inertia_kg_m2: inertia,
        viscous_n_m_s: 3e-4,
        coulomb_n_m: 4e-4,
        drag_n_m_s2: 2e-5,
        stiffness_n_m_s: 5e-4,
        initial_angle_rad: 0.7,
        ..twin::Shaft::default()
    };
    twin.ripple = vec![Ripple {
        order: 5.0,
        phase_rad: 1.0,
        torque_n_m: Some(3e-4),
        speed_fraction: None,
    }];
    twin.torque_tone = vec![twin::TorqueTone {
        f_hz: 18.0,
        phase_rad: 2.0,
        torque_n_m: Some(1e-4),
        speed_fraction: None,
    }];
    twin.speed_drift = Some(twin::SpeedDrift {
        fraction_per_s: Some(0.1),
        ..twin::SpeedDrift::default()
    });
    twin.torsional_resonance = Some(TorsionalResonance {
        f_hz,
        damping_ratio: ratio,
        inertia_share: share,
        load_psd_n2_m2_s: None,
        load_hold_s: None,
    });
    let (near, far) = ((1.0 - share) * inertia, share * inertia);
    let free = TAU * f_hz;
    let spring = free * free * near * far / inertia;
    let damper = 2.0 * ratio * free * near * far / inertia;
    // Near angle and speed, far angle and speed.
    let rates = |ramps: bool, t: f64, [a, w, b, v]: [f64; 4]| {
        let (base, base_rate) = if ramps { (60.0 * t, 60.0) } else { (60.0, 0.0) };
        let asked = base * (1.0 + 0.1 * t) * RAD_S;
        let rate = (base_rate * (1.0 + 0.1 * t) + base * 0.1) * RAD_S;
        let drive = inertia * rate + 3e-4 * asked + 4e-4 + 2e-5 * asked * asked;
        let pull = spring * (b - a) + damper * (v - w);
        let torque = drive + 5e-4 * (asked - w) - 3e-4 * w - 4e-4 - 2e-5 * w * w
            + 3e-4 * (5.0 * a + 1.0).sin()
            + 1e-4 * (TAU * 18.0 * t + 2.0).sin();
        [w, (torque + pull) / near, v, -pull / far]
    };
    let twist = -60.0 * RAD_S / (free * free * (1.0 - share));
    let (mut t, mut state) = (0.0, [0.7, 0.0, 0.7 + twist, 0.0]);
    let mut go_to = |end: f64| {
        let steps = ((end - t) / 1e-4_f64).ceil().max(1.0);
        let (h, ramps) = ((end - t) / steps, t < 1.0);
        let along = |s: [f64; 4], d: [f64; 4], h: f64| [0, 1, 2, 3].map(|i| s[i] + h * d[i]);
        for _ in 0..steps as u32 {
            let k1 = rates(ramps, t, state);
            let k2 = rates(ramps, t + 0.5 * h, along(state, k1, 0.5 * h));
            let k3 = rates(ramps, t + 0.5 * h, along(state, k2, 0.5 * h));
            let k4 = rates(ramps, t + h, along(state, k3, h));
            let sum = [0, 1, 2, 3].map(|i| k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
            state = along(state, sum, h / 6.0);
            t += h;
        }
        t = end;
        (state[0], state[1])
    };
    let mut passed_knot = false;
    let (mut slowest, mut events) = (1.0_f64, 0);
    for event in Simulation::new(&twin).unwrap() {
        if event.truth.time_s > 1.0 && !passed_knot {
            go_to(1.0);
            passed_knot = true;
        }
        let (expected, speed) = go_to(event.truth.time_s);
        slowest = slowest.min(speed);
        let miss = event.truth.angle_rad - expected;
        assert!(miss.abs() < 1e-9, "{miss:e} at {} s", event.truth.time_s);
        events += 1;
    }
    assert!(
        passed_knot && slowest > 0.0 && events > 9_000,
        "{events} {slowest}"
    );
}

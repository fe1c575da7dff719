//! Tones, drift and friction against closed forms and a plain Runge-Kutta.

use proptest::prelude::*;

use super::*;
use crate::twin::{Ripple, SpeedDrift, TorqueTone};

#[test]
fn a_tone_swings_the_shaft_by_torque_over_inertia_and_frequency_squared() {
    for r_min in [60.0, 600.0] {
        let mut twin = plain(r_min, 10.0);
        twin.shaft.viscous_n_m_s = 0.0;
        twin.torque_tone = vec![TorqueTone {
            f_hz: 33.0,
            phase_rad: 0.8,
            torque_n_m: Some(2e-3),
            speed_fraction: None,
        }];
        let turning = TAU * 33.0;
        let swing = |t: f64| -2e-3 / 1e-4 / (turning * turning) * (turning * t + 0.8).sin();
        for event in Simulation::new(&twin).unwrap() {
            let t = event.truth.time_s;
            let expected = r_min * RAD_S * t + swing(t) - swing(0.0);
            assert!((event.truth.angle_rad - expected).abs() < 1e-11, "at {t} s");
        }
    }
}

#[test]
fn a_tone_by_the_swing_it_makes_makes_that_swing() {
    let mut twin = plain(60.0, 10.0);
    twin.shaft.stiffness_n_m_s = 5e-2;
    twin.torque_tone = vec![TorqueTone {
        f_hz: 33.0,
        phase_rad: 0.8,
        torque_n_m: None,
        speed_fraction: Some(0.01),
    }];
    let events: Vec<Event> = Simulation::new(&twin).unwrap().collect();
    let speeds = events.windows(2).map(|w| {
        let way = w[1].truth.angle_rad - w[0].truth.angle_rad;
        way / (w[1].truth.time_s - w[0].truth.time_s) / (60.0 * RAD_S)
    });
    let (low, high) = speeds.fold((2.0_f64, 0.0_f64), |(low, high), w| {
        (low.min(w), high.max(w))
    });
    assert!(
        (high - 1.01).abs() < 1e-5 && (low - 0.99).abs() < 1e-5,
        "{low} {high}"
    );
}

#[test]
fn a_gear_s_torque_is_that_of_a_ripple_of_its_order() {
    let ripple = Ripple {
        order: 7.31,
        phase_rad: 0.3,
        torque_n_m: Some(1e-4),
        speed_fraction: None,
    };
    let mut rippled = plain(60.0, 3.0);
    rippled.ripple = vec![ripple];
    let mut geared = plain(60.0, 3.0);
    geared.gear_mesh = vec![Ripple {
        order: ripple.order,
        phase_rad: ripple.phase_rad,
        torque_n_m: ripple.torque_n_m,
        speed_fraction: None,
    }];
    let run = |twin: &Twin| Simulation::new(twin).unwrap();
    assert!(run(&rippled).eq(run(&geared)));
    assert!(!run(&plain(60.0, 3.0)).eq(run(&geared)));
}

#[test]
fn a_drive_s_drift_goes_into_the_speed() {
    let mut linear = plain(60.0, 10.0);
    linear.speed_drift = Some(SpeedDrift {
        fraction_per_s: Some(-0.02),
        ..SpeedDrift::default()
    });
    let mut settling = plain(60.0, 10.0);
    settling.shaft.coulomb_n_m = 1e-3;
    settling.speed_drift = Some(SpeedDrift {
        fraction: Some(0.05),
        tau_s: Some(2.0),
        ..SpeedDrift::default()
    });
    let w = 60.0 * RAD_S;
    let first = |t: f64| w * (t - 0.01 * t * t);
    let second = |t: f64| w * (t + 0.05 * (t - 2.0 * (1.0 - (-t / 2.0).exp())));
    for (twin, way) in [
        (&linear, &first as &dyn Fn(f64) -> f64),
        (&settling, &second),
    ] {
        let mut events = 0;
        for event in Simulation::new(twin).unwrap() {
            let miss = event.truth.angle_rad - way(event.truth.time_s);
            // Torque mode has nothing that pulls rounding back.
            assert!(miss.abs() < 1e-11, "{miss:e} at {} s", event.truth.time_s);
            events += 1;
        }
        assert!(events > 100_000);
    }
}

#[test]
fn a_drag_slows_a_shaft_as_one_over_time() {
    let mut twin = plain(1200.0, 1.0);
    twin.shaft.viscous_n_m_s = 0.0;
    twin.shaft.drag_n_m_s2 = 2e-6;
    twin.drive = Drive::RunDown {
        r_min: 1200.0,
        off_s: 0.25,
    };
    twin.duration = Duration::Seconds(3.0);
    let (w, c) = (1200.0 * RAD_S, 2e-6 / 1e-4);
    for event in Simulation::new(&twin).unwrap() {
        let t = event.truth.time_s;
        let since = (t - 0.25).max(0.0);
        let expected = w * t.min(0.25) + (1.0 + c * w * since).ln() / c;
        assert!((event.truth.angle_rad - expected).abs() < 2e-11, "at {t} s");
    }
}

#[test]
fn all_friction_on_a_driven_ramp_is_balanced_and_a_run_down_is_that_of_a_plain_runge_kutta() {
    let mut twin = plain(60.0, 1.0);
    twin.shaft.coulomb_n_m = 3e-4;
    twin.shaft.drag_n_m_s2 = 5e-5;
    twin.shaft.stribeck_n_m = 4e-4;
    twin.shaft.stribeck_rad_s = 2.0;
    twin.duration = Duration::Seconds(1.5);
    let mut ramp = twin.clone();
    ramp.drive = Drive::Ramp {
        from_r_min: -20.0,
        to_r_min: 60.0,
        over_s: 1.0,
    };
    for event in Simulation::new(&ramp).unwrap() {
        let t = event.truth.time_s;
        let ramped = t.min(1.0);
        let way = -20.0 * ramped + 40.0 * ramped * ramped + 60.0 * (t - ramped);
        // Where speed and friction turn their sign the torque jumps, and rounding decides when.
        assert!(
            (event.truth.angle_rad - way * RAD_S).abs() < 1e-9,
            "at {t} s"
        );
    }
    twin.drive = Drive::RunDown {
        r_min: 60.0,
        off_s: 0.0,
    };
    let acceleration = |w: f64| {
        let stribeck = 4e-4 * (-(w / 2.0) * (w / 2.0)).exp();
        -(1e-4 * w + 3e-4 + 5e-5 * w * w + stribeck) / 1e-4
    };
    let (mut t, mut angle, mut w) = (0.0, 0.0, 60.0 * RAD_S);
    let mut events = 0;
    for event in Simulation::new(&twin).unwrap() {
        let h = (event.truth.time_s - t) / 4.0;
        for _ in 0..4 {
            let a1 = acceleration(w);
            let a2 = acceleration(w + 0.5 * h * a1);
            let a3 = acceleration(w + 0.5 * h * a2);
            let a4 = acceleration(w + h * a3);
            angle += h * (w + h / 6.0 * (a1 + a2 + a3));
            w += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        }
        t = event.truth.time_s;
        if w < 0.1 {
            break;
        }
        assert!((event.truth.angle_rad - angle).abs() < 1e-9, "at {t} s");
        events += 1;
    }
    assert!(events > 2000, "{events}");
}

#[test]
fn a_speed_that_drifts_down_to_zero_stays_there() {
    let mut twin = plain(60.0, 1.0);
    twin.shaft.coulomb_n_m = 1e-3;
    twin.duration = Duration::Seconds(10.0);
    twin.speed_drift = Some(SpeedDrift {
        fraction_per_s: Some(-0.5),
        ..SpeedDrift::default()
    });
    let last = Simulation::new(&twin).unwrap().last().unwrap().truth;
    // Half of 2 s at a turn a second.
    assert!(
        last.angle_rad <= TAU && TAU - last.angle_rad < 1e-3,
        "{last:?}"
    );
    assert!((1.9..=2.0).contains(&last.time_s));
}

proptest! {
    #[test]
    fn any_allowed_rig_with_friction_springs_and_tones_gives_rows_in_order_and_gets_on(
        seed in 0..1000_u64,
        r_min in -3000.0..3000.0_f64,
        inertia in -6.0..0.0_f64,
        coulomb in -6.0..1.0_f64,
        stribeck in -6.0..1.0_f64,
        stribeck_speed in -3.0..3.0_f64,
        drag in -9.0..0.0_f64,
        torque in -6.0..-1.0_f64,
        f_hz in 0.0..3.0_f64,
        share in 0.01..0.99_f64,
        spring in -4.0..2.0_f64,
        kind in 0..4_u8,
        profile in 0..3_u8,
    ) {
        let mut twin = plain(r_min, 2.0);
        twin.seed = seed;
        twin.encoder = Encoder::Hall { pole_pairs: 3 };
        twin.duration = Duration::Seconds(0.2);
        twin.shaft.inertia_kg_m2 = 10_f64.powf(inertia);
        twin.shaft.coulomb_n_m = 10_f64.powf(coulomb);
        twin.shaft.stribeck_n_m = 10_f64.powf(stribeck);
        twin.shaft.stribeck_rad_s = 10_f64.powf(stribeck_speed);
        twin.shaft.drag_n_m_s2 = 10_f64.powf(drag);
        twin.torque_tone = vec![TorqueTone {
            f_hz: 10_f64.powf(f_hz),
            phase_rad: 0.0,
            torque_n_m: Some(10_f64.powf(torque)),
            speed_fraction: None,
        }];
        if kind & 1 != 0 {
            twin.torsional_resonance = Some(twin::TorsionalResonance {
                f_hz: 10_f64.powf(3.0 - f_hz),
                damping_ratio: 0.01,
                inertia_share: share,
                load_psd_n2_m2_s: Some(1e-9),
                load_hold_s: Some(1e-3),
            });
        }
        if kind & 2 != 0 {
            twin.stick_slip = Some(twin::StickSlip { stiffness_n_m_rad: 10_f64.powf(spring) });
        }
        twin.hysteresis = Some(twin::Hysteresis { angle_rad: 0.1, channel: None });
        twin.drive = match profile {
            0 => Drive::Constant { r_min },
            1 => Drive::Ramp { from_r_min: r_min, to_r_min: -r_min, over_s: 0.1 },
            _ => Drive::RunDown { r_min, off_s: 0.01 },
        };
        prop_assume!(twin.check().is_ok());
        let mut last = (0, 0_f64);
        for event in Simulation::new(&twin).unwrap().take(5_000) {
            prop_assert!(event.row.ticks >= last.0 && event.truth.time_s >= last.1);
            prop_assert!(event.truth.time_s <= 0.2);
            last = (event.row.ticks, event.truth.time_s);
        }
    }
}

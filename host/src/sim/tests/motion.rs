//! The motion against closed forms and against itself with finer steps.

use proptest::prelude::*;

use super::*;

/// Largest difference in edge times, as an angle at the fastest speed, between this twin and ten times finer steps.
pub(super) fn largest_angle_difference(twin: &Twin, fastest_r_min: f64) -> f64 {
    let coarse = Simulation::new(twin).unwrap();
    let mut fine = Simulation::with_finer_steps(twin, 10).unwrap();
    let mut largest: f64 = 0.0;
    let mut events = 0;
    for a in coarse {
        let b = fine.next().expect("the finer run has as many events");
        assert_eq!((a.row.levels, a.truth.edge), (b.row.levels, b.truth.edge));
        let by_s = (a.truth.time_s - b.truth.time_s).abs();
        largest = largest.max(by_s * fastest_r_min.abs() * RAD_S);
        events += 1;
    }
    assert_eq!(fine.next(), None);
    assert!(events > 5_000, "only {events} events");
    largest
}

#[test]
fn ten_times_finer_steps_move_no_edge_by_1e_minus_10_rad() {
    for r_min in [15.0, 1500.0] {
        let rippled = Twin {
            drive: Drive::Constant { r_min },
            duration: Duration::Turns(4.0),
            ..Twin::paper()
        };
        let wandering = Twin {
            noise: wander(0.01),
            ..rippled.clone()
        };
        let ramp = Twin {
            drive: Drive::Ramp {
                from_r_min: 0.2 * r_min,
                to_r_min: r_min,
                over_s: 120.0 / r_min,
            },
            ..rippled.clone()
        };
        let mut run_down = Twin {
            drive: Drive::RunDown {
                r_min,
                off_s: 60.0 / r_min,
            },
            duration: Duration::Seconds(600.0 / r_min),
            ..rippled.clone()
        };
        // Comes to rest within the recording.
        run_down.shaft.coulomb_n_m = run_down.shaft.inertia_kg_m2 * r_min * r_min / 4000.0;
        for (name, twin) in [
            ("ripple", rippled),
            ("wander", wandering),
            ("ramp", ramp),
            ("run-down", run_down),
        ] {
            let largest = largest_angle_difference(&twin, r_min);
            assert!(largest <= 1e-10, "{name} at {r_min} r/min: {largest:e} rad");
        }
    }
}

#[test]
fn a_speed_loop_captures_identical_ticks_with_ten_times_finer_steps() {
    for r_min in [15.0, 1500.0] {
        let twin = Twin {
            drive: speed_loop(r_min, 100.0),
            duration: Duration::Turns(4.0),
            ..Twin::paper()
        };
        let rows = |finer| -> Vec<Sample> {
            let simulation = Simulation::with_finer_steps(&twin, finer).unwrap();
            simulation.map(|event| event.row).collect()
        };
        assert!(rows(1) == rows(10), "the ticks differ at {r_min} r/min");
        let largest = largest_angle_difference(&twin, r_min);
        assert!(largest <= 1e-10, "{largest:e} rad at {r_min} r/min");
    }
}

#[test]
fn the_motion_is_that_of_a_plain_runge_kutta_of_the_declared_torques() {
    // From rest, so that the start is known: up to 60 r/min in 2 s, with friction, a stiff drive and ripple.
    let mut twin = plain(60.0, 2.0);
    twin.duration = Duration::Seconds(3.0);
    twin.drive = Drive::Ramp {
        from_r_min: 0.0,
        to_r_min: 60.0,
        over_s: 2.0,
    };
    twin.shaft = twin::Shaft {
        inertia_kg_m2: 2e-4,
        viscous_n_m_s: 3e-4,
        coulomb_n_m: 4e-4,
        stiffness_n_m_s: 5e-4,
        initial_angle_rad: 0.7,
        ..twin::Shaft::default()
    };
    twin.ripple = vec![
        Ripple {
            order: 5.0,
            phase_rad: 1.0,
            torque_n_m: Some(3e-4),
            speed_fraction: None,
        },
        Ripple {
            order: 7.3,
            phase_rad: -2.0,
            torque_n_m: Some(1e-4),
            speed_fraction: None,
        },
    ];
    let acceleration = |ramps: bool, t: f64, angle: f64, w: f64| {
        let rate = if ramps { 30.0 * RAD_S } else { 0.0 };
        let asked = 30.0 * RAD_S * t.min(2.0);
        let drive = 2e-4 * rate + 3e-4 * asked + 4e-4 + 5e-4 * (asked - w);
        let ripple = 3e-4 * (5.0 * angle + 1.0).sin() + 1e-4 * (7.3 * angle - 2.0).sin();
        (drive + ripple - 3e-4 * w - 4e-4) / 2e-4
    };
    let (mut t, mut angle, mut w) = (0.0, 0.7, 0.0);
    let mut go_to = |end: f64| {
        let steps = ((end - t) / 2e-4).ceil().max(1.0);
        let (start, h, ramps) = (t, (end - t) / steps, t < 2.0);
        for i in 0..steps as u32 {
            let now = start + f64::from(i) * h;
            let (v1, a1) = (w, acceleration(ramps, now, angle, w));
            let middle = now + 0.5 * h;
            let v2 = w + 0.5 * h * a1;
            let a2 = acceleration(ramps, middle, angle + 0.5 * h * v1, v2);
            let v3 = w + 0.5 * h * a2;
            let a3 = acceleration(ramps, middle, angle + 0.5 * h * v2, v3);
            let v4 = w + h * a3;
            let a4 = acceleration(ramps, now + h, angle + h * v3, v4);
            angle += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
            w += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        }
        t = end;
        (angle, w)
    };
    let mut passed_knot = false;
    let mut slowest: f64 = 1.0;
    for event in Simulation::new(&twin).unwrap() {
        let Truth {
            time_s, angle_rad, ..
        } = event.truth;
        if time_s > 2.0 && !passed_knot {
            go_to(2.0);
            passed_knot = true;
        }
        let (expected, speed) = go_to(time_s);
        slowest = slowest.min(speed);
        assert!((angle_rad - expected).abs() < 1e-10, "at {time_s} s");
    }
    assert!(
        passed_knot && slowest > 0.0,
        "friction keeps its sign in this check"
    );
}

#[test]
fn a_constant_speed_follows_the_closed_form() {
    let twin = plain(15.0, 12.0);
    let mut events = 0;
    for event in Simulation::new(&twin).unwrap() {
        let expected = event.truth.angle_rad / (15.0 * RAD_S);
        assert!((event.truth.time_s - expected).abs() < 1e-13 * expected.max(1.0));
        assert_eq!(event.row.ticks, (event.truth.time_s * 84e6).floor() as u64);
        events += 1;
    }
    // 12 turns of 10,000 edges and two index rows a turn.
    assert!((120_022..=120_025).contains(&events), "{events}");
}

#[test]
fn a_viscous_run_down_follows_the_closed_form() {
    let off_s = 0.05;
    let mut twin = plain(1500.0, 1.0);
    twin.drive = Drive::RunDown {
        r_min: 1500.0,
        off_s,
    };
    twin.duration = Duration::Seconds(3.0);
    let (w, rate) = (1500.0 * RAD_S, 1.0);
    let mut last = 0.0;
    for event in Simulation::new(&twin).unwrap() {
        let Truth {
            time_s, angle_rad, ..
        } = event.truth;
        let driven = w * time_s.min(off_s);
        let coasting = w / rate * (1.0 - (-rate * (time_s - off_s).max(0.0)).exp());
        assert!(
            (driven + coasting - angle_rad).abs() < 2e-12,
            "at {time_s} s"
        );
        last = time_s;
    }
    assert!(last > 2.99);
}

#[test]
fn coulomb_friction_stops_the_shaft_for_good_where_the_closed_form_says() {
    let mut twin = plain(600.0, 1.0);
    twin.shaft.viscous_n_m_s = 0.0;
    twin.shaft.coulomb_n_m = 2e-3;
    twin.drive = Drive::RunDown {
        r_min: 600.0,
        off_s: 0.0,
    };
    twin.duration = Duration::Seconds(100.0);
    let last = Simulation::new(&twin).unwrap().last().unwrap().truth;
    let (w, deceleration) = (600.0 * RAD_S, 2e-3 / 1e-4);
    let stop_angle = w * w / (2.0 * deceleration);
    assert!(last.angle_rad <= stop_angle && stop_angle - last.angle_rad < TAU / 10_000.0);
    let speed = (2.0 * deceleration * (stop_angle - last.angle_rad)).sqrt();
    assert!((last.time_s - (w - speed) / deceleration).abs() < 1e-9);
}

#[test]
fn a_standing_shaft_stays_stuck_until_the_torque_beats_friction() {
    // Torque mode, no profile torque: only a ripple smaller, then larger than friction.
    let mut twin = plain(0.0, 1.0);
    twin.duration = Duration::Seconds(2.0);
    twin.shaft.coulomb_n_m = 1e-3;
    let ripple = |torque| Ripple {
        order: 3.0,
        phase_rad: 1.5,
        torque_n_m: Some(torque),
        speed_fraction: None,
    };
    twin.ripple = vec![ripple(0.99e-3)];
    assert_eq!(Simulation::new(&twin).unwrap().count(), 0);
    twin.ripple = vec![ripple(1.1e-3)];
    assert!(Simulation::new(&twin).unwrap().count() > 100);
}

#[test]
fn open_loop_steps_settle_with_the_time_constant_of_friction_and_stiffness() {
    let mut twin = plain(60.0, 1.0);
    twin.shaft.stiffness_n_m_s = 9e-4;
    let step = |t_s, r_min| Step { t_s, r_min };
    twin.drive = Drive::Steps(vec![step(0.0, 60.0), step(1.0, -60.0)]);
    twin.duration = Duration::Seconds(2.5);
    // J = 1e-4 and b + stiffness = 1e-3: 0.1 s. The angle is the integral of w = w0 (2 exp(-t / 0.1 s) - 1) from then on.
    let w = 60.0 * RAD_S;
    for event in Simulation::new(&twin).unwrap() {
        let t = (event.truth.time_s - 1.0).max(0.0);
        let expected = w * event.truth.time_s.min(1.0) + w * (0.2 * (1.0 - (-t / 0.1).exp()) - t);
        assert!((event.truth.angle_rad - expected).abs() < 1e-12);
    }
}

proptest! {
    #[test]
    fn any_allowed_rig_gives_rows_in_order_and_gets_on(
        seed in 0..1000_u64,
        r_min in -3000.0..3000.0_f64,
        inertia in -6.0..0.0_f64,
        viscous in -9.0..0.0_f64,
        coulomb in -6.0..1.0_f64,
        torque in -6.0..1.0_f64,
        order in 0.3..40.0_f64,
        psd in -12.0..-2.0_f64,
        profile in 0..4_u8,
    ) {
        let mut twin = plain(r_min, 2.0);
        twin.seed = seed;
        twin.encoder = Encoder::Hall { pole_pairs: 3 };
        twin.duration = Duration::Seconds(0.2);
        twin.shaft.inertia_kg_m2 = 10_f64.powf(inertia);
        twin.shaft.viscous_n_m_s = 10_f64.powf(viscous);
        twin.shaft.coulomb_n_m = 10_f64.powf(coulomb);
        twin.ripple = vec![Ripple {
            order,
            phase_rad: 0.0,
            torque_n_m: Some(10_f64.powf(torque)),
            speed_fraction: None,
        }];
        twin.noise = Some(twin::Noise::White { psd_n2_m2_s: 10_f64.powf(psd), hold_s: Some(1e-3) });
        twin.drive = match profile {
            0 => Drive::Constant { r_min },
            1 => Drive::Ramp { from_r_min: r_min, to_r_min: -r_min, over_s: 0.1 },
            2 => Drive::RunDown { r_min, off_s: 0.01 },
            _ => speed_loop(r_min, 100.0),
        };
        prop_assume!(twin.check().is_ok());
        let mut last = (0, 0_f64);
        for event in Simulation::new(&twin).unwrap().take(20_000) {
            prop_assert!(event.row.ticks >= last.0 && event.truth.time_s >= last.1);
            prop_assert!(event.truth.time_s <= 0.2);
            last = (event.row.ticks, event.truth.time_s);
        }
    }
}

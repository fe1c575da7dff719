use std::f64::consts::TAU;

use quadcal::edge::Sample;

use super::*;
use crate::twin::{self, Harmonic, Per, Position, Ripple, Step};

const RAD_S: f64 = TAU / 60.0;

/// The paper's rig without ripple and errors, at a speed.
fn plain(r_min: f64, turns: f64) -> Twin {
    Twin {
        ripple: Vec::new(),
        errors: twin::Errors::default(),
        drive: Drive::Constant { r_min },
        duration: Duration::Turns(turns),
        ..Twin::paper()
    }
}

fn speed_loop(r_min: f64, bandwidth_hz: f64) -> Drive {
    Drive::SpeedLoop {
        r_min,
        f_hz: 10_000.0,
        bandwidth_hz: Some(bandwidth_hz),
        kp_n_m_s: None,
        ki_n_m: None,
        timeout_s: None,
        limit_n_m: None,
    }
}

fn wander(rms_fraction: f64) -> Option<twin::Noise> {
    Some(twin::Noise::SpeedWander {
        rms_fraction,
        correlation_rad: Some(0.5),
        hold_s: None,
    })
}

/// Largest difference in edge times, as an angle at the edge's own speed, between this twin and ten times finer steps.
fn largest_angle_difference(twin: &Twin, fastest_r_min: f64) -> f64 {
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
    assert!(events > 10_000, "only {events} events");
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
fn a_ramp_through_zero_returns_over_the_same_edges_at_the_same_angles() {
    let mut twin = plain(30.0, 1.0);
    twin.errors = Twin::paper().errors;
    twin.shaft.coulomb_n_m = 1e-3;
    twin.drive = Drive::Ramp {
        from_r_min: 30.0,
        to_r_min: -30.0,
        over_s: 2.0,
    };
    twin.duration = Duration::Seconds(2.0);
    let events: Vec<Event> = Simulation::new(&twin).unwrap().collect();
    let top = events.iter().map(|e| e.truth.angle_rad).fold(0.0, f64::max);
    assert!(
        (top - 30.0 * RAD_S / 2.0).abs() < 2.0 * TAU / 10_000.0,
        "turned back at {top} rad"
    );
    let turn = events.len() / 2;
    for (there, back) in events[..turn].iter().rev().zip(&events[turn..]) {
        assert_eq!(
            (there.truth.edge, there.truth.class),
            (back.truth.edge, back.truth.class)
        );
        assert!((there.truth.angle_rad - back.truth.angle_rad).abs() < 1e-12);
        assert!((there.truth.time_s + back.truth.time_s - 2.0).abs() < 1e-6);
    }
    // Each row goes back to the levels before the change it undoes.
    for i in 1..turn {
        assert_eq!(
            events[turn + i - 1].row.levels,
            events[turn - i - 1].row.levels
        );
    }
}

#[test]
fn edges_happen_at_their_grid_angle_less_their_error() {
    for encoder in [
        Encoder::Quadrature {
            lines: 32,
            index: true,
        },
        Encoder::Hall { pole_pairs: 2 },
        Encoder::Wheel {
            teeth: 60,
            missing: 2,
        },
    ] {
        let mut twin = plain(-60.0, 3.0);
        twin.encoder = encoder;
        twin.errors.position = Some(Position::Normal {
            rms_rad: 1e-3,
            per: Per::Line,
        });
        twin.errors.width_a_rad = 2e-3;
        twin.errors.eccentricity = Some(Harmonic {
            amplitude_rad: 3e-3,
            phase_rad: 0.4,
        });
        let simulation = Simulation::new(&twin).unwrap();
        let errors = simulation.true_errors();
        let step = TAU / f64::from(encoder.grid_edges());
        let mut seen = 0;
        for event in simulation {
            let Some(k) = event.truth.edge else { continue };
            let angle = f64::from(k) * step - errors[k as usize];
            let off = (event.truth.angle_rad - angle) / TAU;
            assert!((off - off.round()).abs() < 1e-14, "{encoder:?} edge {k}");
            seen += 1;
        }
        let expected = 3 * encoder.real_edges();
        assert!(
            seen >= expected - 1 && seen <= expected + 1,
            "{encoder:?}: {seen} edges"
        );
    }
}

#[test]
fn hall_states_follow_each_other_in_the_order_of_the_recorded_motor() {
    let mut twin = plain(60.0, 2.0);
    twin.encoder = Encoder::Hall { pole_pairs: 1 };
    let states: Vec<u8> = Simulation::new(&twin)
        .unwrap()
        .take(6)
        .map(|e| e.row.levels.0)
        .collect();
    // a is bit 0, b bit 1, c bit 2: after edge 0 at angle 0 the levels are 0,1,1.
    assert_eq!(states, [0b010, 0b011, 0b001, 0b101, 0b100, 0b110]);
}

#[test]
fn the_index_is_high_from_half_a_step_before_to_half_a_step_after_edge_0() {
    let twin = plain(15.0, 2.0);
    let step = TAU / 10_000.0;
    let rows: Vec<Event> = Simulation::new(&twin).unwrap().collect();
    let rise = rows
        .iter()
        .position(|e| e.truth.class == Class::IndexRise)
        .unwrap();
    assert!((rows[rise].truth.angle_rad - (TAU - 0.5 * step)).abs() < 1e-12);
    assert_eq!(rows[rise].row.levels, Levels(Levels::Z));
    assert_eq!(rows[rise + 1].truth.edge, Some(0));
    assert_eq!(rows[rise + 1].row.levels, Levels(Levels::Z | Levels::A));
    assert_eq!(rows[rise + 2].truth.class, Class::IndexFall);
    assert!((rows[rise + 2].truth.angle_rad - (TAU + 0.5 * step)).abs() < 1e-12);
}

#[test]
fn the_same_seed_gives_the_same_run_and_noise_leaves_the_disc_alone() {
    let quiet = Twin {
        duration: Duration::Turns(0.5),
        ..Twin::paper()
    };
    let noisy = Twin {
        noise: wander(0.01),
        ..quiet.clone()
    };
    let other = Twin {
        seed: 2,
        ..noisy.clone()
    };
    let run = |twin| Simulation::new(twin).unwrap();
    assert!(run(&noisy).eq(run(&noisy)));
    assert!(!run(&noisy).eq(run(&other)));
    assert_eq!(run(&noisy).true_errors(), run(&quiet).true_errors());
    assert_ne!(run(&noisy).true_errors(), run(&other).true_errors());
}

#[test]
fn lost_edges_leave_gaps_and_glitches_add_pairs_of_rows() {
    let clean = plain(15.0, 1.0);
    let all: Vec<Event> = Simulation::new(&clean).unwrap().collect();
    let mut lossy = clean.clone();
    lossy.faults.lost_edges = vec![500, 10];
    let left: Vec<Event> = Simulation::new(&lossy).unwrap().collect();
    assert_eq!(left.len(), all.len() - 2);
    assert!(
        left.iter().all(|event| all.contains(event)),
        "what is left is as it was"
    );

    let mut glitchy = clean.clone();
    glitchy.faults.glitch_probability = 0.01;
    glitchy.faults.glitch_width_s = 1e-6;
    let rows: Vec<Event> = Simulation::new(&glitchy).unwrap().collect();
    let glitches = rows
        .iter()
        .filter(|e| e.truth.class == Class::Glitch)
        .count();
    // 10,000 edges at 1 %, two rows each; 5 standard deviations is 50 glitches.
    assert!(
        (100..=300).contains(&glitches) && glitches % 2 == 0,
        "{glitches} rows"
    );
    assert_eq!(rows.len(), all.len() + glitches);
    assert!(rows.windows(2).all(|w| w[0].row.ticks <= w[1].row.ticks));
    assert_eq!(
        rows.last().unwrap().row.levels,
        all.last().unwrap().row.levels
    );

    let mut deaf = clean;
    deaf.faults.lost_probability = 1.0;
    assert!(
        Simulation::new(&deaf)
            .unwrap()
            .all(|e| e.truth.edge.is_none())
    );
}

#[test]
fn jitter_has_its_rms_and_time_never_falls() {
    let mut twin = plain(15.0, 1.0);
    twin.timer.jitter_s = 2e-6;
    let (mut sum, mut count, mut last) = (0.0, 0.0, 0);
    for event in Simulation::new(&twin).unwrap() {
        assert!(event.row.ticks >= last);
        last = event.row.ticks;
        let late = (event.row.ticks as f64 + 0.5) / 84e6 - event.truth.time_s;
        sum += late * late;
        count += 1.0;
    }
    // 1e4 samples give the RMS to 0.7 %.
    assert!(((sum / count).sqrt() / 2e-6 - 1.0).abs() < 0.04);
}

#[test]
fn raw_captures_wrap_at_the_registers_width() {
    let mut twin = plain(15.0, 0.1);
    let full: Vec<Sample> = Simulation::new(&twin).unwrap().map(|e| e.row).collect();
    twin.timer.bits = 16;
    twin.timer.raw_captures = true;
    let raw: Vec<Sample> = Simulation::new(&twin).unwrap().map(|e| e.row).collect();
    assert!(full.last().unwrap().ticks > 65_536);
    assert!(
        full.iter()
            .zip(&raw)
            .all(|(f, r)| f.ticks & 0xffff == r.ticks && f.levels == r.levels)
    );
}

#[test]
fn errors_that_reverse_the_order_of_edges_are_refused() {
    let mut twin = plain(15.0, 1.0);
    twin.errors.quadrature_rad = 1.01 * TAU / 10_000.0;
    match Simulation::new(&twin) {
        Err(TwinError::EdgesCross {
            first: 0,
            second: 1,
            ..
        }) => {}
        other => panic!("{:?}", other.map(|_| ())),
    }
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

#[test]
fn an_error_list_is_read_from_csv_and_its_faults_are_placed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("errors.csv");
    let run = |rows: &str| {
        std::fs::write(&path, format!("k,e_rad\n{rows}")).unwrap();
        let mut twin = plain(15.0, 1.0);
        twin.encoder = Encoder::Wheel {
            teeth: 2,
            missing: 0,
        };
        twin.errors.csv = Some("errors.csv".into());
        twin.folder = folder.path().to_owned();
        Simulation::new(&twin).map(|simulation| simulation.true_errors())
    };
    assert_eq!(
        run("1,0.1\n0,-2e-3\n3,0\n2, 0.25\n").unwrap(),
        [-2e-3, 0.1, 0.25, 0.0]
    );
    for (rows, line, says) in [
        ("0,0\n1,x\n", 3, "header k,e_rad"),
        ("0,0\n1,0\n1,0\n", 4, "k = 1 comes a second time"),
        ("0,0\n4,0\n", 3, "k = 4: allowed is 0 to 3"),
        ("0,0\n1,0\n2,0\n", 4, "k = 3 is missing"),
        ("0,nan\n", 2, "e_rad = NaN"),
    ] {
        let shown = run(rows).unwrap_err().to_string();
        assert!(shown.contains(&format!("errors.csv:{line}: ")), "{shown}");
        assert!(shown.contains(says), "{shown}");
    }
}

//! Edges where the disc has them.

use super::*;

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
            gaps: Vec::new(),
        },
    ] {
        let mut twin = plain(-60.0, 3.0);
        twin.encoder = encoder.clone();
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
fn an_error_list_is_read_from_csv_and_its_faults_are_placed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("errors.csv");
    let run = |rows: &str| {
        std::fs::write(&path, format!("k,e_rad\n{rows}")).unwrap();
        let mut twin = plain(15.0, 1.0);
        twin.encoder = Encoder::Wheel {
            teeth: 2,
            missing: 0,
            gaps: Vec::new(),
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

#[test]
fn twins_with_the_same_errors_seed_are_recordings_of_one_disc() {
    let twin = |seed, disc| {
        let mut twin = Twin::paper();
        twin.seed = seed;
        twin.errors.seed = disc;
        twin.noise = wander(1e-3);
        twin.duration = Duration::Turns(0.1);
        Simulation::new(&twin).unwrap()
    };
    let (first, second, other) = (twin(3, Some(9)), twin(4, Some(9)), twin(3, Some(10)));
    assert_eq!(first.true_errors(), second.true_errors());
    assert_ne!(first.true_errors(), other.true_errors());
    let ticks = |simulation: Simulation| -> Vec<u64> { simulation.map(|e| e.row.ticks).collect() };
    assert_ne!(ticks(first), ticks(second));
    // Left out, it is the twin's own.
    assert_eq!(twin(9, None).true_errors(), twin(1, Some(9)).true_errors());
}

#[test]
fn an_exported_table_is_numbered_by_the_class_of_its_edges() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.csv");
    let read = |encoder: Encoder, rows: &str| {
        std::fs::write(
            &path,
            format!("edge,class,error_rad,standard_error_rad\n{rows}"),
        )
        .unwrap();
        let mut twin = plain(15.0, 1.0);
        twin.encoder = encoder;
        twin.errors.csv = Some("table.csv".into());
        twin.folder = folder.path().to_owned();
        true_errors(&twin)
    };
    let hall = || Encoder::Hall { pole_pairs: 1 };
    let rows = "0,A falls,0.1,1\n1,B rises,0.2,1\n2,C falls,0.3,1\n3,A rises,0.4,1\n4,B falls,0.5,1\n5,C rises,0.6,1\n";
    assert_eq!(read(hall(), rows).unwrap(), [0.2, 0.3, 0.4, 0.5, 0.6, 0.1]);
    let other = read(hall(), &rows.replace("C falls", "C rises"));
    let shown = other.unwrap_err().to_string();
    assert!(
        shown.contains("table.csv:4: edge 2 is of class 'C rises'"),
        "{shown}"
    );
    let wheel = |missing| Encoder::Wheel {
        teeth: 3,
        missing,
        gaps: Vec::new(),
    };
    let teeth = "0,tooth,0.1,1\n1,tooth,0.2,1\n";
    assert_eq!(
        read(wheel(1), teeth).unwrap(),
        [0.1, 0.1, 0.2, 0.2, 0.0, 0.0]
    );
    let shown = read(wheel(0), teeth).unwrap_err().to_string();
    assert!(shown.contains("k = 2 is missing"), "{shown}");
}

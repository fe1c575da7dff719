use super::*;
use crate::diagnose::prepare;
use crate::diagnose::track::Track;
use crate::sensor::{PlanError, SensorKind, SensorPlan};
use crate::sim::Simulation;
use crate::twin::{Drive, StickSlip};

/// A rig of 400 edges a turn with a few per cent of width and quadrature error.
fn rig(r_min: f64, turns: f64) -> Twin {
    let text = format!(
        "duration = {{ turns = {turns} }}\n[encoder.quadrature]\nlines = 100\nindex = false\n\
         [errors]\nwidth_a_rad = 4e-4\nwidth_b_rad = -3e-4\nquadrature_rad = 2e-4\n\
         [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 2e-4\nstiffness_n_m_s = 4e-4\n\
         [drive.constant]\nr_min = {r_min}\n[noise.white]\npsd_n2_m2_s = 1e-10\n\
         [timer]\nclock_hz = 84000000\njitter_s = 1e-7\n"
    );
    Twin::parse(&text, "rig").unwrap()
}

fn recorded(truth: &Twin, told: &Twin, seed: u64) -> Recorded {
    let truth = Twin {
        seed,
        ..truth.clone()
    };
    let plan = SensorPlan {
        kind: SensorKind::Quadrature { index_state: None },
        lines: 100,
    };
    let rows = Simulation::new(&truth)
        .unwrap()
        .map(|event| Ok::<_, PlanError>(event.row));
    Recorded {
        file: "rec.csv".to_owned(),
        plan,
        track: Track::of(plan, truth.timer.clock_hz, rows).unwrap(),
        twin: told.clone(),
    }
}

fn value(finding: &MotionFinding, name: &str) -> f64 {
    finding
        .parameters
        .iter()
        .find(|parameter| parameter.0 == name)
        .unwrap()
        .1
}

#[test]
fn a_speed_loop_is_named_with_its_gains_and_its_rate() {
    for seed in 1..=3 {
        let told = rig(240.0, 30.0);
        let mut truth = told.clone();
        truth.shaft.stiffness_n_m_s = 0.0;
        truth.drive = Drive::SpeedLoop {
            r_min: 240.0,
            f_hz: 211.7,
            bandwidth_hz: None,
            kp_n_m_s: Some(2.5e-3),
            ki_n_m: Some(1e-2),
            timeout_s: None,
            limit_n_m: None,
        };
        let recordings = [recorded(&truth, &told, seed)];
        let board = prepare::board(&recordings).unwrap();
        let found = other_motion(&recordings, &board).expect("a loop");
        assert_eq!(found.mechanism, Mechanism::ClosedLoop);
        assert!(
            (value(&found, "kp_n_m_s") / 2.5e-3 - 1.0).abs() < 0.05,
            "{found:?}"
        );
        assert!(
            (value(&found, "f_hz") / 211.7 - 1.0).abs() < 1e-5,
            "{found:?}"
        );
        assert!(found.twins[0].speed_loop().is_some());
    }
}

#[test]
fn stick_slip_is_named_with_its_spring_and_its_friction() {
    for seed in 1..=3 {
        let mut told = rig(12.0, 12.0);
        told.noise = None;
        let speed = told.drive.nominal_rad_s();
        let mut truth = told.clone();
        let stiffness = 1e-4 * (8.0 * speed).powi(2);
        truth.stick_slip = Some(StickSlip {
            stiffness_n_m_rad: stiffness,
        });
        truth.shaft.stiffness_n_m_s = 0.0;
        truth.shaft.viscous_n_m_s = 2e-5;
        told.shaft.viscous_n_m_s = 2e-5;
        truth.shaft.coulomb_n_m = 0.2 * stiffness;
        truth.shaft.stribeck_n_m = 0.2 * stiffness;
        truth.shaft.stribeck_rad_s = 0.5 * speed;
        let recordings = [recorded(&truth, &told, seed)];
        let found = stick_slip::recognised(&recordings).expect("stick-slip");
        assert!(
            (value(&found, "stiffness_n_m_rad") / stiffness - 1.0).abs() < 0.01,
            "{found:?}"
        );
        assert!(
            (value(&found, "stribeck_n_m") / (0.2 * stiffness) - 1.0).abs() < 0.01,
            "{found:?}"
        );
        assert!(
            (value(&found, "stribeck_rad_s") / (0.5 * speed) - 1.0).abs() < 0.1,
            "{found:?}"
        );
        assert!(Simulation::new(&found.twins[0]).is_ok());
    }
}

#[test]
fn a_drive_that_is_as_the_twin_says_has_no_other_motion() {
    for seed in 1..=4 {
        let told = rig(240.0, 30.0);
        let silent = Twin {
            noise: None,
            ..told.clone()
        };
        for told in [&told, &silent] {
            let recordings = [recorded(&rig(240.0, 30.0), told, seed)];
            let board = prepare::board(&recordings).unwrap();
            assert!(other_motion(&recordings, &board).is_none());
        }
    }
}

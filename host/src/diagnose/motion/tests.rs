mod agreement;

use super::*;
use crate::diagnose::prepare;
use crate::diagnose::track::{Mark, Stretch, Track};
use crate::sensor::{PlanError, SensorKind, SensorPlan};
use crate::sim::Simulation;
use crate::twin::{Drive, Noise, StickSlip};

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

/// Some of the loop's samples fall on an edge, and its torque is so quiet that each of them that is taken wrongly shows.
#[test]
fn a_quiet_loop_whose_samples_fall_on_edges_keeps_its_gains() {
    for seed in 1..=2 {
        let mut told = rig(240.0, 30.0);
        told.timer.jitter_s = 1e-6;
        told.noise = Some(Noise::White {
            psd_n2_m2_s: 1e-13,
            hold_s: None,
        });
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
        let (kp, ki) = (value(&found, "kp_n_m_s"), value(&found, "ki_n_m"));
        assert!((kp / 2.5e-3 - 1.0).abs() < 5e-3, "{:?}", found.parameters);
        assert!((ki / 1e-2 - 1.0).abs() < 0.1, "{:?}", found.parameters);
    }
}

/// Edges of a shaft that starts at rest under a push, over the inertia, at a time, way and speed, with a little torque noise while it
/// turns.
fn from_rest(told: &Twin, push: impl Fn(f64, f64, f64) -> f64) -> Recorded {
    let mut one = recorded(told, told, 1);
    let step = std::f64::consts::TAU / one.track.edges as f64;
    let errors = Simulation::new(told).unwrap().true_errors();
    let (mut time, mut way, mut speed, mut place) = (0.0, 0.3 * step, 0.0, 1);
    let mut marks = Vec::new();
    let tick_s = 1e-6;
    // 1e-4 (rad/s^2)^2 s in steps of a tick.
    const NOISE: f64 = 35.0;
    let mut random = 1_u64;
    while marks.len() < 3 * one.track.edges as usize {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        let noise = NOISE * ((random >> 11) as f64 / (1_u64 << 53) as f64 - 0.5);
        let accelerated = if speed > 0.0 {
            push(time, way, speed) + noise
        } else {
            push(time, way, 0.0).max(0.0)
        };
        let next = way + tick_s * (speed + 0.5 * tick_s * accelerated);
        let edge = place as f64 * step - errors[place as usize % errors.len()];
        if next > edge {
            let time_s = time + tick_s * (edge - way) / (next - way);
            marks.push(Mark { time_s, place });
            place += 1;
        }
        (time, way, speed) = (time + tick_s, next, speed + tick_s * accelerated);
    }
    one.track.stretches = vec![Stretch {
        marks,
        direction: 1,
    }];
    one
}

#[test]
fn a_shaft_that_breaks_away_once_shows_spring_and_friction() {
    let mut told = rig(12.0, 5.0);
    told.shaft.viscous_n_m_s = 1.2e-3;
    let (inertia, pull) = (told.shaft.inertia_kg_m2, told.drive.nominal_rad_s());
    let viscous = told.shaft.viscous_n_m_s / inertia;
    let (spring, drop, over) = (60.0, 12.0, 0.5 * pull);
    let recordings = [from_rest(&told, |time, way, speed| {
        let friction = 10.0 + drop * (-(speed / over) * (speed / over)).exp();
        spring * (pull * time - way) - friction - viscous * speed
    })];
    let found = stick_slip::recognised(&recordings).expect("stick-slip").0;
    let near = |name: &str, truth: f64| {
        assert!(
            (value(&found, name) / truth - 1.0).abs() < 0.03,
            "{name} {truth} {found:?}"
        );
    };
    near("stiffness_n_m_rad", spring * inertia);
    near("stribeck_n_m", drop * inertia);
    near("stribeck_rad_s", over);
    let coulomb = value(&found, "coulomb_n_m") / (10.0 * inertia);
    assert!((coulomb - 1.0).abs() < 0.1, "{coulomb}");
    assert!(found.text.contains("breaks away"), "{}", found.text);
}

#[test]
fn a_drive_that_starts_from_rest_without_a_spring_does_not_stick() {
    let told = rig(12.0, 5.0);
    let pull = told.drive.nominal_rad_s();
    let recordings = [from_rest(&told, |time, _, speed| {
        if time < 0.2 {
            0.0
        } else {
            6.0 * (pull - speed)
        }
    })];
    let found = stick_slip::recognised(&recordings);
    assert!(found.is_none(), "{found:?}");
}

/// A shaft that sticks and slips, and the twin without.
fn sticking(noise: Option<Noise>) -> (Twin, Twin) {
    let mut told = rig(12.0, 12.0);
    told.noise = noise;
    told.shaft.viscous_n_m_s = 2e-5;
    let speed = told.drive.nominal_rad_s();
    let stiffness = 1e-4 * (8.0 * speed).powi(2);
    let mut truth = told.clone();
    truth.stick_slip = Some(StickSlip {
        stiffness_n_m_rad: stiffness,
    });
    truth.shaft.stiffness_n_m_s = 0.0;
    truth.shaft.coulomb_n_m = 0.2 * stiffness;
    truth.shaft.stribeck_n_m = 0.2 * stiffness;
    truth.shaft.stribeck_rad_s = 0.5 * speed;
    (truth, told)
}

#[test]
fn stick_slip_is_named_with_its_spring_and_its_friction() {
    for seed in 1..=3 {
        let (truth, told) = sticking(None);
        let speed = told.drive.nominal_rad_s();
        let stiffness = truth.stick_slip.unwrap().stiffness_n_m_rad;
        let recordings = [recorded(&truth, &told, seed)];
        let found = stick_slip::recognised(&recordings).expect("stick-slip").0;
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

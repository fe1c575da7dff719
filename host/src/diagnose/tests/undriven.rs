//! Torques beside a drive of which the twins say nothing.

use super::{against, board_beside, said, twin};
use crate::diagnose::effect::{Carrier, Effect, Site};
use crate::diagnose::model::Model;

/// Inertia of the rigs, kg m^2.
const INERTIA: f64 = 1e-3;

/// A rig whose drive holds the shaft by so much over the inertia, 1/s, with a torque of some rad/s^2, and its sensor alone.
fn rig(lines: u32, points: &[(f64, f64)], held: f64, order: f64, push: f64) -> [String; 2] {
    let sensor = format!(
        "[encoder.quadrature]\nlines = {lines}\nindex = true\n\n[timer]\nclock_hz = 84000000\n"
    );
    let points = points
        .iter()
        .map(|(t_s, r_min)| format!("{{ t_s = {t_s}, r_min = {r_min} }}"));
    let points: Vec<String> = points.collect();
    let rig = format!(
        "seed = 31\nduration = {{ turns = 31 }}\n\n{sensor}jitter_s = 3e-8\n\n[shaft]\ninertia_kg_m2 = {INERTIA}\nviscous_n_m_s = {}\n\n\
        [errors]\nseed = 3\nposition = {{ normal = {{ rms_rad = 3e-5, per = \"edge\" }} }}\n\n[drive.profile]\npoints = [{}]\n\n\
        [noise.white]\npsd_n2_m2_s = 2e-8\nhold_s = 1e-4\n\n[[ripple]]\norder = {order}\nphase_rad = 0.3\ntorque_n_m = {}\n",
        held * INERTIA,
        points.join(", "),
        push * INERTIA
    );
    [rig, format!("duration = {{ turns = 1 }}\n\n{sensor}")]
}

#[test]
fn an_unbalance_is_told_from_a_disc_that_nobody_knows_and_its_size_is_as_sure_as_the_drive() {
    let points = [(0.0, 60.0), (5.0, 60.0), (6.0, 150.0), (14.0, 150.0)];
    let [real, given] = rig(100, &points, 4.0, 1.0, 2.0);
    let answer = against(&real, &given);
    assert_eq!(said(&answer), ["torque at order 1, constant"]);
    let parameters = &answer.diagnosis.findings[0].parameters;
    let [low, high] = parameters["torque_n_m"].ci95.unwrap();
    // The twin gives no inertia: the torque is that of 1 kg m^2.
    assert!(low < 2.0 && 2.0 < high && high < 3.0, "{low} {high}");
    let [low, high] = parameters["phase_rad"].ci95.unwrap();
    assert!(low < 0.3 && 0.3 < high && high - low > 0.2, "{low} {high}");
}

#[test]
fn how_stiffly_a_drive_holds_is_as_likely_beside_torques_and_their_phases_go_by_it() {
    let points = [(0.0, 300.0), (2.0, 300.0), (3.0, 900.0), (5.0, 900.0)];
    let [real, given] = rig(64, &points, 8.0, 0.387, 4.0);
    let mut board = board_beside(&twin(&real), &twin(&given));
    let mut model = Model::default();
    model.add(&[Effect::new(Site::Torque, Carrier::Order(0.387))], 0);
    let phase = |board: &crate::diagnose::model::Board| {
        let fit = board.fit(&model);
        let mut numbers = board.unsure_of_hold(&fit).numbers(0).into_iter();
        let phase = numbers.find(|number| number.name == "phase_rad").unwrap();
        (phase.value, phase.error.unwrap())
    };
    assert_eq!(board.benches[0].found.hold.stiffness, 0.0);
    let (loose, sure) = phase(&board);
    assert!((loose - 0.3).abs() > 2.0 * sure, "{loose} {sure}");
    assert!(board.hold_at_last(&model));
    let stiffness = board.benches[0].found.hold.stiffness;
    assert!((2.0..20.0).contains(&stiffness), "{stiffness}");
    let (held, unsure) = phase(&board);
    assert!((held - 0.3).abs() < 2.0 * unsure, "{held} {unsure}");
    assert!((held - 0.3).abs() < (loose - 0.3).abs(), "{held} {loose}");
}

#[test]
fn a_torque_is_as_unsure_as_a_standard_error_of_the_stiffness_makes_it_also_where_none_is_likeliest()
 {
    let points = [(0.0, 300.0), (2.0, 300.0), (3.0, 900.0), (5.0, 900.0)];
    let [real, given] = rig(64, &points, 0.1, 0.387, 4.0);
    let mut board = board_beside(&twin(&real), &twin(&given));
    let mut model = Model::default();
    model.add(&[Effect::new(Site::Torque, Carrier::Order(0.387))], 0);
    board.benches[0].found.hold.open = 20.0;
    let fit = board.fit(&model);
    let error = |fit: &crate::diagnose::model::Fit| {
        let mut numbers = fit.numbers(0).into_iter();
        let torque = numbers.find(|number| number.name == "torque_n_m").unwrap();
        torque.error.unwrap()
    };
    let wider = error(&board.unsure_of_hold(&fit)) / error(&fit);
    assert!(wider > 1.05, "{wider}");
}

#[test]
fn what_a_drive_makes_up_for_that_nobody_declared_is_said_to_be_open() {
    let points = [(0.0, 300.0), (1.0, 300.0), (2.0, 600.0), (4.0, 600.0)];
    let [real, thin] = rig(64, &points, 8.0, 3.0, 0.1);
    let open = |given: &str| {
        let answer = against(&real, given);
        let mut each = answer.not_identifiable.into_iter();
        each.any(|text| text.starts_with("friction, loads and inertia"))
    };
    assert!(open(&thin));
    assert!(!open(&real));
}

/// A rig whose load swings behind a coupling at 120 Hz, kept up by noise alone, with what else it has, and a twin of its sensor, disc and noise.
fn coupled(seed: u32, more: &str) -> [String; 2] {
    let known = "[encoder.quadrature]\nlines = 64\nindex = true\n\n[timer]\nclock_hz = 84000000\njitter_s = 2e-8\n\n\
        [errors]\nseed = 3\nposition = { normal = { rms_rad = 3e-5, per = \"edge\" } }\n\n[noise.white]\npsd_n2_m2_s = 3e-7\n";
    let rig = format!(
        "seed = {seed}\nduration = {{ turns = 40 }}\n\n{known}hold_s = 5e-5\n\n[shaft]\ninertia_kg_m2 = {INERTIA}\nviscous_n_m_s = 0.01\n\n\
        [drive.constant]\nr_min = 300\n\n[torsional_resonance]\nf_hz = 120\ndamping_ratio = 0.02\ninertia_share = 0.5\n\n{more}"
    );
    let given =
        format!("duration = {{ turns = 1 }}\n\n[shaft]\ninertia_kg_m2 = {INERTIA}\n\n{known}");
    [rig, given]
}

#[test]
fn a_coupling_that_noise_keeps_ringing_is_no_sweep_and_hides_no_tone() {
    let [real, given] = coupled(5, "");
    let answer = against(&real, &given);
    // Some of the noise may be left over, but no effect is made of it.
    let cells = answer.cells.iter().flatten().count();
    assert_eq!(cells, 0, "{:?}", said(&answer));
    let ringing = answer.learned_ringing.unwrap();
    assert!((ringing.f_hz / 120.0 - 1.0).abs() < 0.15, "{ringing:?}");
    assert!(ringing.damping_ratio < 0.15, "{ringing:?}");
    let hum = "[[torque_tone]]\nf_hz = 122\ntorque_n_m = 0.02\nphase_rad = 0.4\n";
    let [real, given] = coupled(6, hum);
    let answer = against(&real, &given);
    let orders = answer.diagnosis.findings.iter();
    let told: Vec<f64> = orders
        .flat_map(|one| one.place.frequencies_hz.clone())
        .collect();
    assert_eq!(told.len(), 1, "{:?}", said(&answer));
    assert!((told[0] - 122.0).abs() < 0.05, "{told:?}");
    assert!(answer.learned_ringing.is_some());
}

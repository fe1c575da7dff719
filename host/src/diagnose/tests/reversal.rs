//! Shafts that turn round.

use std::f64::consts::TAU;

use super::super::basis::Basis;
use super::super::board::Board;
use super::super::diagnosis::Verdict;
use super::super::one_channel::{Undecided, turned};
use super::super::prepare;
use super::super::run::diagnose;
use super::super::search::search;
use super::{left, recorded, twin};
use crate::mechanism::Mechanism;

/// A ripple that holds the shaft for a while where it turns round, between the edges of a sensor.
fn held(seed: u32, encoder: &str) -> String {
    format!(
        "duration = {{ turns = 40 }}\nseed = {seed}\n{encoder}\n[shaft]\ninertia_kg_m2 = 4.7e-3\n\
         viscous_n_m_s = 1.9e-2\nstiffness_n_m_s = 3e-2\ninitial_angle_rad = 2.84\n\
         [drive.ramp]\nfrom_r_min = 130\nto_r_min = -130\nover_s = 33\n\
         [[ripple]]\norder = 6\ntorque_n_m = 1.6e-3\nphase_rad = 3.9\n\
         [[ripple]]\norder = 18\ntorque_n_m = 2.4e-2\nphase_rad = 4.6\n\
         [noise.white]\npsd_n2_m2_s = 1.2e-7\n[timer]\nclock_hz = 84000000\njitter_s = 2e-7\n"
    )
}

const FINE: &str = "[encoder.quadrature]\nlines = 500\nindex = false";
const HALL: &str = "[encoder.hall]\npole_pairs = 3";
const WHEEL: &str = "[encoder.wheel]\nteeth = 90";
const UNEVEN: &str = "[errors.position.normal]\nrms_rad = 4e-4\n";

/// Size of the play that a board shows, and its standard error, rad.
fn play(board: &Board) -> [f64; 2] {
    let model = board.fit(board.columns(Basis::Direction)).unwrap();
    [model.sizes[0], model.covariance[(0, 0)].sqrt()]
}

#[test]
fn a_shaft_that_a_ripple_sends_to_and_fro_leaves_noise() {
    for seed in [1, 2, 3] {
        let rig = twin(&held(seed, FINE).replace("torque_n_m = 2.4e-2", "torque_n_m = 0.12"));
        let reversals = recorded(&rig, &rig).track.stretches.len();
        assert!(reversals > 4, "{reversals}");
        let (mean, most) = left(&rig, &rig);
        assert!(
            (mean - 1.0).abs() < 0.05 && most < 6.0,
            "{seed}: {mean} {most}"
        );
    }
}

#[test]
fn play_shows_by_its_size_where_a_ripple_sends_the_shaft_to_and_fro() {
    for seed in [1, 2] {
        let told = twin(&held(seed, FINE));
        let mut truth = told.clone();
        let h = 4e-3;
        truth.hysteresis = twin(&format!(
            "{}[hysteresis]\nangle_rad = {h}\n",
            held(seed, FINE)
        ))
        .hysteresis;
        let board = prepare::board(&[recorded(&truth, &told)]).unwrap();
        let [size, error] = play(&board);
        assert!(
            (size - h).abs() < 4.0 * error && error < 0.15 * h,
            "{seed}: {size} +- {error}"
        );
        let (mean, most) = left(&truth, &truth);
        assert!(
            (mean - 1.0).abs() < 0.05 && most < 6.0,
            "{seed}: {mean} {most}"
        );
    }
}

/// By more than a step of the grid, so that the ripple meets the shaft at quite another phase in reverse.
#[test]
fn play_of_more_than_a_step_is_fitted_by_its_size() {
    let h = 1.2 * TAU / 18.0;
    let told = twin(&held(4, HALL));
    let truth = twin(&format!("{}[hysteresis]\nangle_rad = {h}\n", held(4, HALL)));
    let board = prepare::board(&[recorded(&truth, &told)]).unwrap();
    let [size, _] = play(&board);
    assert!((size / h - 1.0).abs() < 0.05, "{size} {h}");
}

/// At six to seven standard errors.
#[test]
fn a_play_that_hardly_shows_is_named_and_none_is_not() {
    let plain = "duration = { turns = 40 }\nseed = 7\n[encoder.quadrature]\nlines = 250\nindex = false\n\
                 [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 2e-4\nstiffness_n_m_s = 4e-4\n\
                 [drive.ramp]\nfrom_r_min = 240\nto_r_min = -240\nover_s = 17\n\
                 [noise.white]\npsd_n2_m2_s = 1e-12\n[timer]\nclock_hz = 84000000\njitter_s = 1e-7\n";
    let told = twin(plain);
    let mut none = prepare::board(&[recorded(&told, &told)]).unwrap();
    let [_, error] = play(&none);
    assert!(search(&mut none).unwrap().found.is_empty());
    let truth = twin(&format!(
        "{plain}[hysteresis]\nangle_rad = {}\n",
        8.0 * error
    ));
    let mut board = prepare::board(&[recorded(&truth, &told)]).unwrap();
    let [size, error] = play(&board);
    assert!(
        size / error > 5.0 && size / error < 11.0,
        "{size} +- {error}"
    );
    let found = search(&mut board).unwrap().found;
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].hypothesis.mechanism, Mechanism::Hysteresis);
}

#[test]
fn one_channel_shows_where_it_turned_round_by_its_discs_unevenness() {
    let plain =
        |seed| held(seed, WHEEL).replace("torque_n_m = 2.4e-2", "torque_n_m = 2.4e-3") + UNEVEN;
    for seed in [1, 2, 3] {
        let rig = twin(&plain(seed));
        let one = recorded(&rig, &rig);
        assert!(!one.track.reverses());
        let track = turned(one.track.clone(), &rig).unwrap();
        assert_eq!(track.stretches.len(), 2);
        let [forward, reverse] = [&track.stretches[0], &track.stretches[1]];
        assert_eq!((forward.direction, reverse.direction), (1, -1));
        assert_eq!(forward.marks.last().unwrap().place, reverse.marks[0].place);
        let (mean, most) = left(&rig, &rig);
        assert!(
            (mean - 1.0).abs() < 0.06 && most < 6.0,
            "{seed}: {mean} {most}"
        );
        let h = 0.7 * TAU / 180.0;
        let truth = twin(&format!("{}[hysteresis]\nangle_rad = {h}\n", plain(seed)));
        let [size, error] = play(&prepare::board(&[recorded(&truth, &rig)]).unwrap());
        assert!(
            (size - h).abs() < 4.0 * error && error < 0.15 * h,
            "{seed}: {size} +- {error}"
        );
    }
}

#[test]
fn edges_that_one_channel_may_have_passed_to_and_fro_are_left_out() {
    for seed in [1, 2, 3] {
        let rig = twin(&(held(seed, WHEEL) + UNEVEN));
        let one = recorded(&rig, &rig);
        let track = turned(one.track.clone(), &rig).unwrap();
        let kept: usize = track.stretches.iter().map(|s| s.marks.len()).sum();
        let all = one.track.stretches[0].marks.len();
        assert!(kept < all && kept > all * 9 / 10, "{kept} of {all}");
        let (mean, most) = left(&rig, &rig);
        assert!(
            (mean - 1.0).abs() < 0.06 && most < 6.0,
            "{seed}: {mean} {most}"
        );
    }
}

#[test]
fn an_even_disc_with_one_channel_does_not_show_where_it_turned_round() {
    let even = twin(&held(1, WHEEL));
    let one = recorded(&even, &even);
    assert_eq!(
        turned(one.track.clone(), &even).unwrap_err(),
        Undecided::Alike
    );
    assert!(prepare::board(std::slice::from_ref(&one)).is_err());
    let mut pulses = one.track;
    pulses.classes = 1;
    assert_eq!(turned(pulses, &even).unwrap_err(), Undecided::OneFlank);
}

/// Dry friction that turns with the shaft, while the twin's goes one way.
#[test]
fn friction_of_a_shaft_that_goes_to_and_fro_is_no_more_than_noise() {
    let rubs = |seed| {
        held(seed, FINE)
            .replace("torque_n_m = 2.4e-2", "torque_n_m = 0.12")
            .replace("viscous_n_m_s", "coulomb_n_m = 2e-2\nviscous_n_m_s")
    };
    for seed in [1, 3] {
        let rig = twin(&rubs(seed));
        let (mean, _) = left(&rig, &rig);
        assert!((mean - 1.0).abs() < 0.03, "{seed}: {mean}");
    }
}

/// A disc whose lines, some times over, are more than a decoder counts.
#[test]
fn a_shaft_with_a_fine_disc_that_turns_round_explains_its_own_recording() {
    for lines in [500, 1250, 5000] {
        let rig = twin(&format!(
            "seed = 3\nduration = {{ turns = 6 }}\n[encoder.quadrature]\nlines = {lines}\nindex = true\n\
             [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 1e-4\nstiffness_n_m_s = 2e-3\ncoulomb_n_m = 1e-3\n\
             [drive.ramp]\nfrom_r_min = 200\nto_r_min = -200\nover_s = 3\n\
             [timer]\nclock_hz = 84000000\njitter_s = 2e-8\n"
        ));
        let said = diagnose(&[recorded(&rig, &rig)], &mut |_, _| {});
        let said = said.unwrap().diagnosis;
        assert_eq!(
            said.verdict,
            Verdict::Complete,
            "{lines}: {:?}",
            said.findings
        );
    }
}

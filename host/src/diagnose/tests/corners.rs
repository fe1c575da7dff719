//! Corners of the speed of drives that nobody declared.

use super::{board_beside, board_of, edges, twin};
use crate::diagnose::model::{Board, Model, Wander};
use crate::diagnose::noise::Tails;

/// An axis that goes to and fro by 10 turns, and what its twin knows of it.
const AXIS: &str = "seed = 3\nduration = { seconds = 2.7 }\n\n[encoder.quadrature]\nlines = 32\nindex = true\n\n[shaft]\ninertia_kg_m2 = 1e-4\n\
    stiffness_n_m_s = 0.02\n\n[drive.profile]\npoints = [{ t_s = 0, r_min = 0 }, { t_s = 0.25, r_min = 600 }, { t_s = 1, r_min = 600 }, \
    { t_s = 1.25, r_min = 0 }, { t_s = 1.35, r_min = 0 }, { t_s = 1.6, r_min = -600 }, { t_s = 2.35, r_min = -600 }, \
    { t_s = 2.6, r_min = 0 }]\n\n[noise.white]\npsd_n2_m2_s = 1e-11\n\n[timer]\nclock_hz = 84000000\njitter_s = 2e-8\n";
const THIN: &str = "[encoder.quadrature]\nlines = 32\nindex = true\n\n[shaft]\ninertia_kg_m2 = 1e-4\n\n[timer]\nclock_hz = 84000000\n";

/// How much the acceleration jumps about an instant, rad/s^2.
fn jump(board: &Board, about_s: f64) -> f64 {
    let corners = board.benches[0].found.corners.iter();
    let near = corners.filter(|corner| (corner.time_s - about_s).abs() < 0.01);
    near.map(|corner| corner.jump).sum()
}

#[test]
fn a_profile_s_corners_are_found_at_their_instants_with_their_sizes() {
    let board = board_beside(&twin(AXIS), &twin(THIN));
    // 600 r/min in a quarter of a second; the drive takes 5 ms to follow.
    for (about_s, sign) in [(0.25, -1.0), (1.0, -1.0), (1.6, 1.0), (2.35, 1.0)] {
        let jump = jump(&board, about_s) * sign;
        assert!((200.0..280.0).contains(&jump), "{about_s} {jump}");
    }
    // What makes the shaft's own noise is 1e-3 (rad/s^2)^2 s; with the corners in it, it was a thousand times as dense.
    assert!(board.noise.torque < 1e-2, "{:?}", board.noise);
}

#[test]
fn a_ripple_of_a_steady_shaft_is_no_corner() {
    let steady = AXIS.replace(
        &AXIS[AXIS.find("[drive").unwrap()..AXIS.find("[noise").unwrap()],
        "[drive.constant]\nr_min = 60\n\n[[ripple]]\norder = 5\ntorque_n_m = 2e-3\n\n",
    );
    let steady = steady.replace("2.7", "9");
    let board = board_beside(&twin(&steady), &twin(THIN));
    assert_eq!(board.benches[0].found.corners, []);
}

#[test]
fn a_corner_that_a_model_makes_superfluous_is_taken_off() {
    let mut board = board_beside(&twin(AXIS), &twin(THIN));
    let found = board.benches[0].found.corners.clone();
    let mut more = found.clone();
    more.push(crate::diagnose::corners::Corner {
        time_s: 0.61,
        jump: 3.0,
        kick: 0.0,
    });
    board.benches[0].bend(more);
    assert!(board.find_corners(&Model::default()));
    assert_eq!(jump(&board, 0.61), 0.0);
    assert!(jump(&board, 1.6) > 200.0);
}

#[test]
fn what_corners_leave_of_an_unknown_drive_stays_in_noise_that_wanders() {
    let board = board_beside(&twin(AXIS), &twin(THIN));
    let none = Model::default();
    let any = board.in_any_noise(Tails::Normal, Wander::Lasting);
    let (mut any, ..) = any.at_its_noise(&none);
    // It begins in a ramp, and each corner leaves another one: with a drift that fades the noise was a thousand times as dense.
    assert!(any.noise.torque < 1e-2, "{:?}", any.noise);
    // The same once corners are looked for again, as of other edges, where the noise beside those before had no drift.
    any.noise.drift *= 1e-9;
    any.set_noise(any.noise);
    any.benches[0].bend(Vec::new());
    assert!(any.find_corners(&none));
    assert!(any.noise.torque < 1e-2, "{:?}", any.noise);
    assert!(jump(&any, 1.6) > 200.0);
}

/// A short axis: it turns round after less than three turns, and rests for a tenth of a second there.
const SHORT: &str = "seed = 4\nduration = { seconds = 6 }\n\n[encoder.quadrature]\nlines = 125\nindex = true\n\n[shaft]\ninertia_kg_m2 = 1e-4\n\
    stiffness_n_m_s = 0.02\n\n[drive.profile]\npoints = [{ t_s = 0, r_min = 0 }, { t_s = 0.3, r_min = 120 }, { t_s = 1.1, r_min = 120 }, \
    { t_s = 1.4, r_min = 0 }, { t_s = 1.5, r_min = 0 }, { t_s = 1.8, r_min = -120 }, { t_s = 2.6, r_min = -120 }, { t_s = 2.9, r_min = 0 }, \
    { t_s = 3, r_min = 0 }, { t_s = 3.3, r_min = 120 }, { t_s = 4.1, r_min = 120 }, { t_s = 4.4, r_min = 0 }, { t_s = 4.5, r_min = 0 }, \
    { t_s = 4.8, r_min = -120 }, { t_s = 5.6, r_min = -120 }, { t_s = 5.9, r_min = 0 }]\n\n[noise.white]\npsd_n2_m2_s = 1e-11\n\n[timer]\n\
    clock_hz = 84000000\njitter_s = 2e-8\n";

/// The board of the short axis beside what is known of it.
fn short() -> Board {
    board_beside(&twin(SHORT), &twin(&THIN.replace("32", "125")))
}

#[test]
fn the_noise_near_standstills_is_no_more_than_elsewhere_where_nothing_pushes() {
    let board = short();
    assert!(board.noise.unseen < 1e-3, "{:?}", board.noise);
    let rests = crate::diagnose::disc::rests(&board, &Model::default());
    let white = board.benches[0].white(&rests[0]);
    let slow = |(white, speed): (&f64, &f64)| (speed.abs() < 4.0).then_some(white * white);
    let each = white.iter().zip(&board.benches[0].course.speed);
    let squares: Vec<f64> = each.filter_map(slow).collect();
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    assert!((0.5..2.0).contains(&mean), "{mean} of {}", squares.len());
}

#[test]
fn how_stiffly_a_servo_holds_the_shaft_shows_in_its_noise() {
    let board = short();
    // 0.02 N m s over the inertia; its torque noise is 1e-3 (rad/s^2)^2 s.
    let stiffness = board.benches[0].found.hold.stiffness;
    assert!((120.0..320.0).contains(&stiffness), "{stiffness}");
    let torque = board.noise.torque;
    assert!((6e-4..1.6e-3).contains(&torque), "{torque}");
}

#[test]
fn how_stiffly_a_servo_holds_the_shaft_does_not_depend_on_what_was_taken_for_it_before() {
    let mut board = short();
    let hold = &mut board.benches[0].found.hold;
    (hold.stiffness, hold.forgets) = (1500.0, 1500.0);
    board.hold_by_noise(&Model::default());
    let stiffness = board.benches[0].found.hold.stiffness;
    assert!((120.0..320.0).contains(&stiffness), "{stiffness}");
}

#[test]
fn a_stop_that_one_edge_shows_is_a_corner_and_a_stamp_that_is_far_out_is_none() {
    let (rig, given) = (twin(SHORT), twin(&THIN.replace("32", "125")));
    let mut edges = edges(&rig);
    let at = edges.time_s.partition_point(|time_s| *time_s < 0.7);
    // A hundred deviations of the others.
    edges.time_s[at] += 2e-6;
    let board = board_of(&edges, &given);
    let corners = board.benches[0].found.corners.iter();
    let there: Vec<_> = corners
        .filter(|corner| (corner.time_s - 0.7).abs() < 0.1)
        .collect();
    assert!(there.is_empty(), "{there:?}");
    for stop_s in [1.45, 2.95, 4.45] {
        let corners = board.benches[0].found.corners.iter();
        let near = corners.filter(|corner| (corner.time_s - stop_s).abs() < 0.1);
        assert!(near.count() > 0, "{stop_s}");
    }
}

#[test]
fn edges_that_come_late_by_class_are_no_shaft_that_is_held() {
    let rig = "seed = 4\nduration = { turns = 400 }\n\n[encoder.hall]\npole_pairs = 2\n\n[shaft]\ninertia_kg_m2 = 1e-5\n\n[drive.profile]\n\
        points = [{ t_s = 0, r_min = 600 }, { t_s = 10, r_min = 3600 }]\n\n[edge_delay]\na = { rise_s = 270e-6, fall_s = 0 }\nb = { rise_s = 270e-6, fall_s = 0 }\nc = { rise_s = 270e-6, fall_s = 0 }\n\n\
        [timer]\nclock_hz = 30000\n";
    let sensor =
        "duration = { turns = 1 }\n[encoder.hall]\npole_pairs = 2\n[timer]\nclock_hz = 30000\n";
    let board = board_beside(&twin(rig), &twin(sensor));
    assert!(board.undriven);
    assert_eq!(board.benches[0].found.hold.stiffness, 0.0);
}

#[test]
fn corners_are_looked_for_again_once_it_is_known_how_stiffly_the_drive_holds() {
    let sensor = "seed = 5\nduration = { turns = 60 }\n\n[encoder.hall]\npole_pairs = 5\n\n[[ripple]]\norder = 14\nphase_rad = 1.4\n\
        torque_n_m = 7.5e-3\n\n[timer]\nclock_hz = 72000000\njitter_s = 2.7e-7\n\n[noise.white]\npsd_n2_m2_s = 5.9e-10\n\n\
        [shaft]\ninertia_kg_m2 = 7e-4\nviscous_n_m_s = 1.6e-3\n";
    let rig = format!(
        "{sensor}stiffness_n_m_s = 8e-3\n\n[drive.profile]\npoints = [{{ t_s = 0, r_min = 182 }}, {{ t_s = 2.2, r_min = 182 }}, \
        {{ t_s = 5.6, r_min = 70 }}, {{ t_s = 9.2, r_min = 70 }}, {{ t_s = 17.9, r_min = -142 }}, {{ t_s = 27.8, r_min = -142 }}, \
        {{ t_s = 30.2, r_min = 156 }}, {{ t_s = 40, r_min = 156 }}]\n"
    );
    let board = board_beside(&twin(&rig), &twin(sensor));
    let rests = crate::diagnose::disc::rests(&board, &Model::default());
    let white = board.benches[0].white(&rests[0]);
    let most = white
        .iter()
        .fold(0.0_f64, |most, white| most.max(white.abs()));
    assert!(
        most < 8.0,
        "{most} beside {:?}",
        board.benches[0].found.corners
    );
}

//! Corners of the speed of drives that nobody declared.

use super::{board_beside, twin};
use crate::diagnose::model::{Board, Model};

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
    more.push(crate::diagnose::plant::Corner {
        time_s: 0.61,
        jump: 3.0,
        kick: 0.0,
    });
    board.benches[0].bend(more);
    assert!(board.settle_corners(&Model::default()));
    assert_eq!(jump(&board, 0.61), 0.0);
    assert!(jump(&board, 1.6) > 200.0);
}

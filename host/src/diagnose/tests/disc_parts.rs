//! Several errors of one disc at once, and run-out beside errors that are known.

use super::{STEADY, left, recorded, twin};
use crate::diagnose::basis::Basis;
use crate::diagnose::board::Board;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::prepare;
use crate::diagnose::search::{BEYOND, search};
use crate::diagnose::weigh::weigh;
use crate::mechanism::Mechanism;
use crate::twin::Twin;

const THREE: &str = "[errors.eccentricity]\namplitude_rad = 1e-3\nphase_rad = 0.4\n\
                     [errors.tilt]\namplitude_rad = 4e-4\nphase_rad = 2\n\
                     [[local_defect]]\nangle_rad = 3\nwidth_rad = 0.15\nerror_rad = 3e-4\n";

fn board(truth: &Twin, told: &Twin) -> Board {
    prepare::board(&[recorded(truth, told)]).unwrap()
}

#[test]
fn an_axis_off_the_centre_a_tilt_and_a_defect_at_once_are_no_pattern_of_every_edge() {
    let mut board = board(&twin(&format!("{STEADY}{THREE}")), &twin(STEADY));
    let searched = search(&mut board).unwrap();
    let mut named: Vec<Mechanism> = searched
        .found
        .iter()
        .map(|found| found.hypothesis.mechanism)
        .collect();
    named.sort_unstable();
    let mut three = [
        Mechanism::Eccentricity,
        Mechanism::DiscTilt,
        Mechanism::LocalDefect,
    ];
    three.sort_unstable();
    assert_eq!(named, three);
    assert!(searched.pattern.is_none());
}

#[test]
fn errors_of_every_edge_stay_a_pattern_beside_a_disc_off_its_centre_and_make_no_defect() {
    let lines = format!(
        "{STEADY}[errors.eccentricity]\namplitude_rad = 1e-3\n[errors.position.normal]\nrms_rad = 1e-4\n"
    );
    let mut board = board(&twin(&lines), &twin(STEADY));
    let searched = search(&mut board).unwrap();
    let named: Vec<Mechanism> = searched
        .found
        .iter()
        .map(|found| found.hypothesis.mechanism)
        .collect();
    assert!(named.contains(&Mechanism::Eccentricity), "{named:?}");
    assert!(!named.contains(&Mechanism::LocalDefect), "{named:?}");
    let rms_rad = searched.pattern.unwrap().rms_rad;
    assert!((rms_rad / 1e-4 - 1.0).abs() < 0.15, "{rms_rad}");
}

/// A grid whose marks are known to lie a little off it is no measure for what goes by the shaft.
#[test]
fn run_out_of_a_bearing_goes_by_the_shafts_own_angle() {
    let lines = format!("{STEADY}[errors.position.normal]\nrms_rad = 3e-3\n");
    let told = twin(&lines);
    let order = 1.37;
    let truth = twin(&format!(
        "{lines}[[bearing]]\norder = {order}\nrunout_rad = 2e-3\nphase_rad = 1\n"
    ));
    let (mean, most) = left(&truth, &truth);
    assert!((mean - 1.0).abs() < 0.1 && most < 6.0, "{mean} {most}");
    let board = board(&truth, &told);
    let model = board.fit(board.nuisances()).unwrap();
    let score = |basis: Basis| {
        let hypothesis = Hypothesis::by(basis);
        assert_eq!(hypothesis.mechanism, Mechanism::Bearing);
        let columns = hypothesis.columns(&board);
        weigh(&board, &model, hypothesis, columns).unwrap().score
    };
    let (own, grid) = (
        score(Basis::Lagged { order }),
        score(Basis::Round { order }),
    );
    assert!(own > grid + BEYOND && own > 500.0, "{own} {grid}");
}

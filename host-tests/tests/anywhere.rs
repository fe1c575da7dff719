//! Calibration at any speed: two speeds, a ramp, one speed, on seeds that nothing was tuned to. `--bin anywhere` sweeps many.
#![allow(clippy::cast_precision_loss, missing_docs)]

use quadcal_host_tests::accuracy::{distance, rms};
use quadcal_host_tests::anywhere::{ByOrder, GivenGains, Judged, Rig, RunDown, Scenario};
use quadcal_host_tests::bound::{LockedTorque, bound, usual_points};

const SEEDS: std::ops::Range<u64> = 9_000..9_024;

fn judged(rig: Rig) -> Vec<Judged> {
    SEEDS
        .map(|seed| {
            let run = rig.run(seed).unwrap();
            let calibration = rig.calibrate(&run, seed, GivenGains::EXACT).unwrap();
            Judged::of(&calibration, &run)
        })
        .collect()
}

/// RMS over the runs of what is left, over that of the encoder and over the bound. Order 1 alone is nearly all of it, so that
/// of 24 runs the latter is known to some 15 %.
fn left(rig: Rig, torque: LockedTorque) -> [f64; 2] {
    let ideal = bound(rig, torque, usual_points(rig.scenario)).rms();
    let judged = judged(rig);
    let over = |pick: fn(&Judged) -> f64| rms(&judged.iter().map(pick).collect::<Vec<_>>());
    let covered = judged.iter().map(|run| run.covered).sum::<f64>() / judged.len() as f64;
    assert!((0.88..0.995).contains(&covered), "{covered}");
    [
        over(|run| run.left) / over(|run| run.raw),
        over(|run| run.left) / ideal,
    ]
}

#[test]
fn two_speeds_leave_one_percent_and_little_more_than_the_bound() {
    let rig = Rig {
        scenario: Scenario::TwoSpeeds,
        lines: 2500,
    };
    let [of_raw, of_bound] = left(rig, LockedTorque::Every);
    assert!(of_raw < 0.01 && of_bound < 1.35, "{of_raw} {of_bound}");
}

#[test]
fn a_ramp_leaves_two_percent_and_little_more_than_the_bound() {
    let rig = Rig {
        scenario: Scenario::Ramp,
        lines: 2500,
    };
    let [of_raw, of_bound] = left(rig, LockedTorque::Cogging);
    assert!(of_raw < 0.02 && of_bound < 1.5, "{of_raw} {of_bound}");
}

#[test]
fn one_speed_leaves_little_more_than_the_bound() {
    let rig = Rig {
        scenario: Scenario::OneSpeed,
        lines: 2500,
    };
    let [_, of_bound] = left(rig, LockedTorque::None);
    assert!(of_bound < 1.35, "{of_bound}");
}

/// With cogging too, whose side bands at the orders beside it are no geometry.
#[test]
fn one_speed_makes_no_order_worse() {
    for scenario in [Scenario::OneSpeed, Scenario::OneSpeedCogging] {
        let rig = Rig {
            scenario,
            lines: 2500,
        };
        let mut by_order = ByOrder::default();
        for seed in SEEDS {
            let run = rig.run(seed).unwrap();
            let calibration = rig.calibrate(&run, seed, GivenGains::EXACT).unwrap();
            by_order.add(&calibration, &run);
        }
        let worst = by_order.worst().unwrap();
        assert!(worst.ratio < 1.02, "{scenario:?}: {worst:?}");
    }
}

/// Cogging of a coarse disc's size at a motor's orders: some stand out, others do not and are doubted with them.
#[test]
fn a_coarse_disc_at_one_speed_says_what_cogging_leaves() {
    let rig = Rig {
        scenario: Scenario::OneSpeedCogging,
        lines: 60,
    };
    let judged = judged(rig);
    let over = |pick: fn(&Judged) -> f64| rms(&judged.iter().map(pick).collect::<Vec<_>>());
    let stated = over(|run| run.left) / over(|run| run.standard_error);
    assert!((0.75..1.15).contains(&stated), "{stated}");
}

#[test]
fn coarse_discs_are_learned_at_two_speeds_too() {
    for lines in [60, 360] {
        let rig = Rig {
            scenario: Scenario::TwoSpeeds,
            lines,
        };
        let [of_raw, _] = left(rig, LockedTorque::Every);
        assert!(of_raw < 0.01, "{lines}: {of_raw}");
    }
}

/// RMS over the runs of what is left, over the bound and over what a polynomial fit leaves; the stated error over what is left; and
/// how many torques are told that are not there.
fn left_of_run_down(of: RunDown) -> ([f64; 3], usize) {
    let (mut judged, mut bounds, mut peers) = (Vec::new(), Vec::new(), Vec::new());
    let mut false_torques = 0;
    for seed in SEEDS {
        let run = of.run(seed).unwrap();
        let calibration = of.calibrate(&run).unwrap();
        judged.push(Judged::of(&calibration, &run));
        bounds.push(of.bound(&run));
        peers.push(distance(&of.polynomial(&run), &run.truth));
        let torques = calibration.solution.torque_orders().iter();
        let known = of.torque_orders();
        false_torques += torques.filter(|t| !known.contains(&t.order)).count();
    }
    let over = |pick: fn(&Judged) -> f64| rms(&judged.iter().map(pick).collect::<Vec<_>>());
    let left = over(|run| run.left);
    let stated = over(|run| run.standard_error) / left;
    (
        [left / rms(&bounds), left / rms(&peers), stated],
        false_torques,
    )
}

#[test]
fn one_run_down_tells_the_disc_as_a_polynomial_does() {
    for of in [RunDown::Once, RunDown::Drag] {
        let ([of_bound, of_polynomial, stated], false_torques) = left_of_run_down(of);
        assert!(of_bound < 1.15, "{of:?}: {of_bound}");
        assert!(of_polynomial < 1.2, "{of:?}: {of_polynomial}");
        assert!((0.8..1.25).contains(&stated), "{of:?}: {stated}");
        assert_eq!(false_torques, 0, "{of:?}");
    }
}

#[test]
fn friction_is_no_torque_of_the_shaft() {
    let ([of_bound, of_polynomial, stated], false_torques) = left_of_run_down(RunDown::Twice);
    assert!(of_bound < 1.5, "{of_bound}");
    assert!(of_polynomial < 0.8, "{of_polynomial}");
    assert!((0.8..1.25).contains(&stated), "{stated}");
    assert_eq!(false_torques, 0);
}

/// A polynomial takes the torque for the disc. What is stated covers a damping of the shaft that little torque does not tell.
#[test]
fn torque_of_a_run_down_is_told_from_the_disc() {
    for (of, of_bound_most, of_polynomial_most, stated_most) in [
        (RunDown::TorqueOnce, 1.5, 0.001, 5.0),
        (RunDown::Cogging, 1.2, 0.03, 3.0),
    ] {
        let ([of_bound, of_polynomial, stated], false_torques) = left_of_run_down(of);
        assert!(of_bound < of_bound_most, "{of:?}: {of_bound}");
        assert!(
            of_polynomial < of_polynomial_most,
            "{of:?}: {of_polynomial}"
        );
        assert!((0.8..stated_most).contains(&stated), "{of:?}: {stated}");
        assert_eq!(false_torques, 0, "{of:?}");
    }
}

//! Intervals against the truth.

use quadcal_host::diagnose::diagnosis::Verdict;
use quadcal_host::mechanism::Mechanism;
use serde_json::json;

use super::super::score::Score;
use super::super::truth::Truth;
use super::{answer, finding, missing, truth};

/// Whether the intervals of a right finding hold the truth.
fn held(
    truth: &Truth,
    mechanism: Mechanism,
    parameters: &[(&str, f64, [f64; 2])],
) -> Vec<Option<bool>> {
    let answer = answer(Verdict::Explained, vec![finding(mechanism, parameters)]);
    let score = Score::of("case", truth, &answer);
    assert!(score.right, "{:?}", score.wrong());
    score.parameters.iter().map(|p| p.holds).collect()
}

#[test]
fn phases_are_circular_and_a_negative_amplitude_turns_one() {
    let wave = json!({"order": 3.0, "phase_rad": 0.1, "torque_n_m": 2.0});
    let truth = truth("one", json!([missing("torque_ripple", wave)]));
    let held = |torque: f64, phase: f64| {
        held(
            &truth,
            Mechanism::TorqueRipple,
            &[
                ("phase_rad", phase, [phase - 0.2, phase + 0.2]),
                ("torque_n_m", torque, [torque - 0.1, torque + 0.1]),
            ],
        )
    };
    let tau = std::f64::consts::TAU;
    assert_eq!(held(2.0, 0.0), [Some(true), Some(true)]);
    assert_eq!(held(2.0, tau - 0.05), [Some(true), Some(true)]);
    assert_eq!(held(-2.05, 0.1 - tau / 2.0), [Some(true), Some(true)]);
    assert_eq!(held(-2.0, 0.1), [Some(false), Some(true)]);
    assert_eq!(held(2.2, 0.4), [Some(false), Some(false)]);
}

#[test]
fn names_that_differ_are_converted() {
    let delays = json!({
        "a.rise_s": 3e-6, "b.rise_s": 3e-6, "c.rise_s": 3e-6, "a.fall_s": 1e-6, "b.fall_s": 2e-6, "c.fall_s": 0.0,
    });
    let delay = truth("one", json!([missing("edge_delay", delays)]));
    let near = |value: f64| [value - 1e-8, value + 1e-8];
    let found = [
        ("a.rise_less_fall_s", 2e-6, near(2e-6)),
        ("b.rise_less_fall_s", 2e-6, near(2e-6)),
        ("rise_less_fall_s", 2e-6, near(2e-6)),
    ];
    let all = held(&delay, Mechanism::EdgeDelay, &found);
    assert_eq!(all, [Some(true), Some(false), Some(true)]);

    let skew = json!({"a_s": 5e-7, "b_s": 0.0, "c_s": 0.0});
    let skew = truth("one", json!([missing("channel_skew", skew)]));
    let found = [
        ("b_less_a_s", -5e-7, near(-5e-7)),
        ("b_s", 0.0, near(-5e-7)),
    ];
    let all = held(&skew, Mechanism::ChannelSkew, &found);
    assert_eq!(all, [Some(true), None]);

    let jitter = missing("timestamp_jitter", json!({"jitter_s": 4e-7}));
    let jitter = truth("one", json!([jitter]));
    let found = [("jitter_s", 5e-7, near(5e-7))];
    let all = held(&jitter, Mechanism::TimestampJitter, &found);
    assert_eq!(all, [Some(true)], "the whole of it: 3e-7 and 4e-7");

    let mut play = missing("backlash", json!({"gap_rad": 1e-3}));
    play["same_physics"] = json!(["hysteresis"]);
    let play = truth("one", json!([play]));
    let found = [("angle_rad", 1e-3, [0.9e-3, 1.1e-3])];
    assert_eq!(held(&play, Mechanism::Hysteresis, &found), [Some(true)]);
}

#[test]
fn stick_slip_is_not_compared() {
    let slip = json!({"stiffness_n_m_rad": 1.0});
    let slip = truth("one", json!([missing("stick_slip", slip)]));
    let found = [("stiffness_n_m_rad", 1.0, [0.9, 1.1])];
    assert_eq!(held(&slip, Mechanism::StickSlip, &found), [None]);
}

#[test]
fn a_phase_counts_only_where_it_is_of_the_same() {
    let mut mesh = missing("gear_mesh", json!({"order": 6.6, "phase_rad": 1.0}));
    mesh["same_physics"] = json!(["bearing", "torque_ripple"]);
    let mesh = truth("one", json!([mesh]));
    let found = [("order", 6.6, [6.5, 6.7]), ("phase_rad", 4.1, [4.0, 4.2])];
    let by = |mechanism| held(&mesh, mechanism, &found);
    assert_eq!(by(Mechanism::Bearing), [Some(true), None]);
    assert_eq!(by(Mechanism::GearMesh), [Some(true), Some(false)]);
    assert_eq!(by(Mechanism::TorqueRipple), [Some(true), Some(false)]);
}

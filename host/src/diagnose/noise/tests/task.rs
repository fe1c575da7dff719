//! Tasks that hold captures up, at many rates and of short busy times.

use super::*;
use crate::mechanism::Mechanism;

/// Rate in Hz, busy time in s.
const TASKS: [(f64, f64); 5] = [
    (57.31, 3e-5),
    (213.7, 1e-5),
    (1000.03, 4e-6),
    (3301.9, 2e-5),
    (7907.1, 8e-6),
];

fn text((f_hz, busy_s): (f64, f64), seed: u64) -> String {
    let phase_s = 0.037 * seed as f64 % 1.0 / f_hz;
    format!("[capture_latency]\ntask_hz = {f_hz}\nbusy_s = {busy_s:e}\nphase_s = {phase_s:e}")
}

#[test]
fn a_task_is_found_with_its_rate_and_busy_time() {
    let (mut off, mut count) = (0.0, 0.0);
    for task in TASKS {
        for seed in 21..=24 {
            let found = found(seed, &text(task, seed), 0.0);
            assert_eq!(found.len(), 1, "{task:?} {seed}: {found:?}");
            assert_eq!(found[0].mechanism, Mechanism::CaptureLatency);
            near(
                &found[0],
                &[("task_hz", task.0, 1e-6), ("busy_s", task.1, 0.1)],
            );
            for (name, truth) in [("task_hz", task.0), ("busy_s", task.1)] {
                let parameter = found[0].parameters.iter().find(|p| p.name == name);
                let parameter = parameter.unwrap();
                off += ((parameter.value - truth) / parameter.standard_error).powi(2);
                count += 1.0;
            }
        }
    }
    // Standard errors are what values are off by: 40 squares have a mean of 1, give or take 0.22.
    assert!((0.3..2.0).contains(&(off / count)), "{}", off / count);
}

#[test]
fn edges_too_late_at_any_time_are_no_task() {
    for seed in 31..=34 {
        let board = prepare::board(&rig(seed, "", "", 0.0)).expect("a board");
        let mut model = Model::none(&board);
        let mut random = seed;
        for left in &mut model.left {
            for left in left.iter_mut() {
                random = random
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                if random >> 33 < 1 << 23 {
                    *left -= 20.0;
                }
            }
        }
        let found = super::super::find_task(&board, &model.left);
        assert!(
            found.is_none(),
            "{seed}: {:?}",
            found.map(|task| task.finding)
        );
    }
}

#[test]
fn tones_stay_what_they_are() {
    for (more, mechanism) in [
        (
            "[[torque_tone]]\nf_hz = 61.3\ntorque_n_m = 2e-4",
            Mechanism::TorqueTone,
        ),
        (
            "[[threshold_ripple]]\nf_hz = 47.3\nangle_rad = 4e-5",
            Mechanism::ThresholdRipple,
        ),
    ] {
        for seed in SEEDS {
            let rig = rig(seed, "", more, 0.0);
            let found = diagnose(&rig, &mut |_, _| ()).expect("a diagnosis");
            let findings = found.diagnosis.findings.iter();
            let names: Vec<Mechanism> = findings.map(|f| f.mechanism).collect();
            assert_eq!(names, [mechanism], "{more} {seed}");
        }
    }
}

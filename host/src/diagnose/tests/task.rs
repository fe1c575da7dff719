//! A task that holds captures up, where the twin lacks it, has another, or has one that the recording lacks.

use super::super::diagnosis::{Diagnosis, Verdict};
use super::super::run::diagnose;
use super::{recorded, twin};
use crate::mechanism::Mechanism;

const F_HZ: f64 = 1336.2;
const BUSY_S: f64 = 2.9e-5;
const PHASE_S: f64 = 6.2e-4;
const EVEN: &str = "constant = { r_min = 540 }";
const ROUND: &str = "steps = [{ t_s = 0, r_min = 540 }, { t_s = 1.5, r_min = -540 }]";

fn rig(drive: &str) -> String {
    format!(
        "seed = 7\nduration = {{ seconds = 3 }}\n[encoder.quadrature]\nlines = 250\nindex = true\n\
         [errors]\nposition = {{ uniform = {{ amplitude_rad = 3e-4 }} }}\n\
         [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 1e-4\nstiffness_n_m_s = 4.9e-3\ncoulomb_n_m = 1e-3\n\
         [drive]\n{drive}\n[noise.white]\npsd_n2_m2_s = 1e-11\n\
         [timer]\nclock_hz = 84000000\njitter_s = 2e-7\n"
    )
}

fn task(busy_s: f64) -> String {
    format!("[capture_latency]\ntask_hz = {F_HZ}\nbusy_s = {busy_s}\nphase_s = {PHASE_S}\n")
}

fn of(drive: &str, truth: &str, told: &str) -> Diagnosis {
    let with = |more: &str| twin(&(rig(drive) + more));
    let one = recorded(&with(truth), &with(told));
    diagnose(&[one], &mut |_, _| {}).unwrap().diagnosis
}

/// Also of a shaft that turns round, and where the twin has a task of the same rate that blocks for another time.
#[test]
fn a_task_is_found_with_its_numbers() {
    let cases = [
        (EVEN, String::new()),
        (EVEN, task(2e-5)),
        (ROUND, String::new()),
        (ROUND, task(4e-5)),
    ];
    for (drive, told) in cases {
        let said = of(drive, &task(BUSY_S), &told);
        assert_eq!(said.verdict, Verdict::Explained, "{:?}", said.findings);
        let [one] = &said.findings[..] else {
            panic!("{:?}", said.findings);
        };
        assert_eq!(one.mechanism, Mechanism::CaptureLatency);
        for (name, value) in [("task_hz", F_HZ), ("busy_s", BUSY_S), ("phase_s", PHASE_S)] {
            let found = &one.parameters[name];
            let [low, high] = found.ci95.unwrap();
            // Four standard errors.
            let off = 4.0 * (high - low) / 3.92;
            assert!((found.value - value).abs() < off, "{name}: {found:?}");
        }
    }
}

/// Captures that all come at once are none of a twin whose task holds one in thirty up.
#[test]
fn a_task_that_the_recording_lacks_is_said() {
    for drive in [EVEN, ROUND] {
        let said = of(drive, "", &task(BUSY_S));
        assert_eq!(said.verdict, Verdict::Explained, "{:?}", said.findings);
        let [one] = &said.findings[..] else {
            panic!("{:?}", said.findings);
        };
        assert_eq!(one.mechanism, Mechanism::CaptureLatency);
        assert!(one.parameters["busy_s"].value == 0.0, "{one:?}");
        assert!(
            said.summary
                .starts_with("The twin has what the recording lacks"),
            "{}",
            said.summary
        );
        let there = of(drive, &task(BUSY_S), &task(BUSY_S));
        assert_eq!(there.verdict, Verdict::Complete, "{:?}", there.findings);
    }
}

//! Shafts that a speed loop drives and nothing else disturbs: whatever the loop saw is in the recording.

use super::super::diagnosis::{Diagnosis, Verdict};
use super::super::run::diagnose;
use super::{recorded, twin};
use crate::mechanism::Mechanism;

/// Its stamps are off by a jitter, s.
fn rig(seed: u64, jitter_s: f64, more: &str) -> String {
    let r_min = [287.0, 300.0, 451.0, 120.0][seed as usize % 4];
    format!(
        "seed = {seed}\nduration = {{ turns = 30 }}\n[encoder.quadrature]\nlines = 500\nindex = true\n\
         [errors]\nseed = 7\nposition = {{ normal = {{ rms_rad = 1e-4 }} }}\nwidth_a_rad = 2e-4\nquadrature_rad = 2e-4\n\
         [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 1e-4\n\
         [drive.speed_loop]\nr_min = {r_min}\nf_hz = 5000\nbandwidth_hz = 10\n\
         [[ripple]]\norder = 5\ntorque_n_m = 2e-4\n{more}\
         [timer]\nclock_hz = 84000000\njitter_s = {jitter_s:e}\n"
    )
}

fn diagnosed(seed: u64, jitter_s: f64, missing: &str) -> Diagnosis {
    let truth = twin(&rig(seed, jitter_s, missing));
    let one = recorded(&truth, &twin(&rig(seed, jitter_s, "")));
    diagnose(&[one], &mut |_, _| {}).unwrap().diagnosis
}

#[test]
fn nothing_is_missing_though_samples_fall_on_edges() {
    for jitter_s in [0.0, 5e-8] {
        for seed in 1..=4 {
            let said = diagnosed(seed, jitter_s, "");
            assert_eq!(
                said.verdict,
                Verdict::Complete,
                "{seed} {jitter_s}: {:?}",
                said.findings
            );
        }
    }
}

#[test]
fn a_ripple_far_below_what_the_loop_does_is_found_alone() {
    const TORQUE: f64 = 2e-6;
    for seed in 1..=3 {
        let missing = format!("[[ripple]]\norder = 7\ntorque_n_m = {TORQUE:e}\n");
        let said = diagnosed(seed, 5e-8, &missing);
        let [one] = said.findings.as_slice() else {
            panic!("{seed}: {:?}", said.findings);
        };
        assert_eq!(one.mechanism, Mechanism::TorqueRipple);
        let torque = one.parameters["torque_n_m"].value;
        assert!((torque / TORQUE - 1.0).abs() < 0.1, "{seed}: {torque}");
    }
}

//! Run-downs, on which a twin with another friction is slow somewhere else.

use super::{recorded, twin};
use crate::diagnose::run::diagnose;
use crate::mechanism::Mechanism;

fn rig(coulomb_n_m: f64) -> String {
    format!(
        "seed = 5\nduration = {{ turns = 400 }}\n[encoder.quadrature]\nlines = 500\nindex = true\n\
         [shaft]\ninertia_kg_m2 = 2.3e-5\nviscous_n_m_s = 1.5e-5\ncoulomb_n_m = {coulomb_n_m:e}\n\
         [drive.run_down]\nr_min = 360\noff_s = 0.1\n\
         [[ripple]]\norder = 6\ntorque_n_m = 2.5e-4\n[[ripple]]\norder = 18\ntorque_n_m = 1.5e-3\n\
         [noise.white]\npsd_n2_m2_s = 4e-13\n[timer]\nclock_hz = 100000000\njitter_s = 7e-8\n"
    )
}

/// The shaft swings to and fro before it rests, sooner with more friction: edges there are in one comparison and not in the other.
#[test]
fn the_twin_with_more_friction_in_it_is_simulated_as_far_as_both_go() {
    for more in [3.2e-5, 9.2e-5, 1.72e-4] {
        let given = twin(&rig(2.8e-5));
        let recorded = recorded(&twin(&rig(2.8e-5 + more)), &given);
        let said = diagnose(&[recorded], &mut |_, _| {}).unwrap().diagnosis;
        let [finding] = said.findings.as_slice() else {
            panic!("{:?}", said.summary);
        };
        assert_eq!(finding.mechanism, Mechanism::Friction);
        let coulomb = finding.parameters["coulomb_n_m"].value;
        assert!((coulomb / more - 1.0).abs() < 0.05, "{coulomb} {more}");
        let (after, floor) = (said.fit.rms_after_rad, said.fit.floor_rad);
        let (after, floor) = (after.unwrap(), floor.unwrap());
        assert!(after < 1.5 * floor, "{after} {floor}");
    }
}

/// A run-down of 200 turns and more, so that a twin that lacks a friction is soon tens of radians elsewhere.
fn long(seed: u64, friction: &str) -> String {
    format!(
        "seed = {seed}\nduration = {{ seconds = 8 }}\n[encoder.quadrature]\nlines = 500\nindex = true\n\
         [errors]\nseed = 3\nposition = {{ normal = {{ rms_rad = 1e-4 }} }}\nwidth_a_rad = 2e-4\n\
         [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 2e-5\nstiffness_n_m_s = 1e-3\n{friction}\
         [drive.run_down]\nr_min = 1500\noff_s = 1\n\
         [noise.white]\npsd_n2_m2_s = 1e-10\n[timer]\nclock_hz = 84000000\njitter_s = 5e-8\n"
    )
}

#[test]
fn friction_that_changes_the_whole_course_is_found_term_by_term() {
    let (dry, air) = (("coulomb_n_m", 4e-4), ("drag_n_m_s2", 4e-7));
    for terms in [&[dry][..], &[air], &[dry, air]] {
        for seed in 1..=3 {
            let friction: String = terms
                .iter()
                .map(|(name, size)| format!("{name} = {size:e}\n"))
                .collect();
            let recorded = recorded(&twin(&long(seed, &friction)), &twin(&long(seed, "")));
            let said = diagnose(&[recorded], &mut |_, _| {}).unwrap().diagnosis;
            assert_eq!(said.findings.len(), terms.len(), "{:?}", said.findings);
            for (name, size) in terms {
                let mut own = said.findings.iter();
                let own = own.find_map(|one| one.parameters.get(*name)).unwrap();
                let [low, high] = own.ci95.unwrap();
                // The fifth of a thousandth of a normal error is 2.3 times as far off.
                let off = (own.value - size).abs();
                assert!(off < 0.9 * (high - low), "{seed}: {own:?} for {size}");
            }
            let fit = &said.fit;
            let (after, floor) = (fit.rms_after_rad.unwrap(), fit.floor_rad.unwrap());
            // Torque noise wanders along a run-down: its RMS has few degrees of freedom.
            assert!(after < 3.0 * floor, "{after} {floor}");
        }
    }
}

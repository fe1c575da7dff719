//! What all edges of a class have, on a disc that the twin does not know.

use std::collections::BTreeSet;

use super::super::run::{Recorded, diagnose};
use super::{recorded, twin};
use crate::mechanism::Mechanism;

const DISC: &str = "position = { uniform = { amplitude_rad = 2e-4 } }\nquadrature_rad = 4e-4\n\
                    width_a_rad = 5e-4\nwidth_b_rad = 4.5e-4\neccentricity = { amplitude_rad = 4e-4, phase_rad = 1.1 }\n";

fn rig(r_min: f64, index: bool) -> String {
    format!(
        "duration = {{ turns = 20 }}\n[encoder.quadrature]\nlines = 500\nindex = {index}\n\
         [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 1e-4\nstiffness_n_m_s = 2e-3\n\
         [drive.constant]\nr_min = {r_min}\n[noise.white]\npsd_n2_m2_s = 1e-12\n\
         [timer]\nclock_hz = 84000000\njitter_s = 2e-8\n"
    )
}

fn one(seed: u64, disc_seed: u64, r_min: f64, index: bool) -> Recorded {
    let rig = rig(r_min, index);
    let disc = format!("[errors]\nseed = {disc_seed}\n{DISC}");
    recorded(&twin(&format!("seed = {seed}\n{rig}{disc}")), &twin(&rig))
}

fn named(rig: &[Recorded]) -> BTreeSet<Mechanism> {
    let all = diagnose(rig, &mut |_, _| {}).unwrap().diagnosis;
    all.findings.iter().map(|one| one.mechanism).collect()
}

const TRUTH: [Mechanism; 3] = [
    Mechanism::LineError,
    Mechanism::WidthError,
    Mechanism::QuadratureError,
];

#[test]
fn angles_at_one_speed_are_taken_for_no_delays_beside_an_unknown_disc() {
    for seed in [101, 103, 106] {
        let rig = [one(seed, seed, 200.0, true)];
        assert_eq!(named(&rig), BTreeSet::from(TRUTH), "seed {seed}");
    }
}

#[test]
fn what_comes_once_a_line_is_no_tone() {
    let rig = [one(21, 77, 150.0, false), one(22, 77, 600.0, false)];
    assert_eq!(named(&rig), BTreeSet::from(TRUTH));
}

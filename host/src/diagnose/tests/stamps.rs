//! What stamps do by themselves: rounding, and classes whose edges spread further.

use super::super::diagnosis::{Diagnosis, Verdict};
use super::super::run::diagnose;
use super::{recorded, twin};
use crate::mechanism::Mechanism;

fn rig(seed: u64, clock_hz: u64, r_min: f64, noise: &str) -> String {
    format!(
        "seed = {seed}\nduration = {{ turns = 30 }}\n[encoder.quadrature]\nlines = 250\nindex = true\n\
         [errors]\nseed = 7\nposition = {{ normal = {{ rms_rad = 1e-4 }} }}\nwidth_a_rad = 2e-4\n\
         [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 1e-4\nstiffness_n_m_s = 1e-3\n\
         [drive.constant]\nr_min = {r_min}\n{noise}[timer]\nclock_hz = {clock_hz}\njitter_s = 0\n"
    )
}

/// Nothing scatters the edges, so that rounding keeps step with them.
#[test]
fn rounding_that_nothing_scatters_is_no_finding() {
    for (clock_hz, r_min) in [
        (1_000_000, 240.0),
        (1_000_000, 317.3),
        (10_000_000, 60.0),
        (500_000, 97.1),
    ] {
        for seed in 1..=2 {
            let rig = twin(&rig(seed, clock_hz, r_min, ""));
            let said = diagnose(&[recorded(&rig, &rig)], &mut |_, _| {})
                .unwrap()
                .diagnosis;
            assert_eq!(
                said.verdict,
                Verdict::Complete,
                "{clock_hz} {r_min}: {:?}",
                said.findings
            );
        }
    }
}

/// Normal numbers of a seed (G. Box, M. Muller, Annals of Mathematical Statistics 29, 1958).
fn normal(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut uniform = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        ((state >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    };
    move || (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos()
}

/// What is said where one class of edges spreads by so much more, s.
fn spreading(seed: u64, class: i64, by_s: f64) -> Diagnosis {
    const NOISE: &str = "[noise.white]\npsd_n2_m2_s = 1e-12\n";
    let rig = twin(&rig(seed, 84_000_000, 300.0, NOISE));
    let mut one = recorded(&rig, &rig);
    let mut normal = normal(seed);
    let stretches = one.track.stretches.iter_mut();
    for mark in stretches.flat_map(|stretch| &mut stretch.marks) {
        if mark.place.rem_euclid(4) == class {
            mark.time_s += by_s * normal();
        }
    }
    diagnose(&[one], &mut |_, _| {}).unwrap().diagnosis
}

#[test]
fn a_class_whose_stamps_spread_further_is_told_with_its_edges_and_how_far() {
    for (class, name) in ["A rise", "B rise", "A fall", "B fall"]
        .into_iter()
        .enumerate()
    {
        let said = spreading(class as u64 + 1, class as i64, 5e-7);
        assert_eq!(said.verdict, Verdict::Unknown, "{:?}", said.findings);
        let one = &said.findings[0];
        assert_eq!(one.mechanism, Mechanism::Unknown);
        assert_eq!(one.place.edge_classes, [name]);
        assert!(one.parameters["times_as_wide"].value > 5.0, "{one:?}");
    }
}

/// What one writes first: a shaft and a speed. In round numbers all edges come at one phase of the clock.
#[test]
fn a_twin_of_next_to_nothing_explains_its_own_recording() {
    for more in ["", "viscous_n_m_s = 1e-4\n"] {
        for r_min in [600.0, 300.0, 123.4] {
            let rig = twin(&format!(
                "seed = 4\nduration = {{ turns = 20 }}\n[encoder.quadrature]\nlines = 100\nindex = true\n\
                 [shaft]\ninertia_kg_m2 = 1e-4\n{more}[drive.constant]\nr_min = {r_min}\n\
                 [timer]\nclock_hz = 84000000\n"
            ));
            let said = diagnose(&[recorded(&rig, &rig)], &mut |_, _| {});
            let said = said.unwrap().diagnosis;
            assert_eq!(
                said.verdict,
                Verdict::Complete,
                "{r_min}: {:?}",
                said.findings
            );
        }
    }
}

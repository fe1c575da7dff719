//! A disc of which the twin knows nothing, beside everything else: the first recordings of any rig.

use std::collections::BTreeSet;

use super::super::run::{Recorded, diagnose};
use super::{recorded, twin};
use crate::mechanism::Mechanism;

const RIG: &str = "duration = { turns = 14 }\n[encoder.quadrature]\nlines = 512\nindex = false\n\
                   [shaft]\ninertia_kg_m2 = 2.4e-4\nviscous_n_m_s = 8e-4\nstiffness_n_m_s = 1.6e-3\ninitial_angle_rad = 1.3\n\
                   [timer]\nclock_hz = 84000000\njitter_s = 2e-8\n";
/// An eighth of a pitch for each edge by itself, and a third of a pitch that all round the disc have together.
const DISC: &str = "[errors]\nseed = 77\n[errors.position.normal]\nrms_rad = 4e-4\n\
                    [errors.eccentricity]\namplitude_rad = 1e-3\nphase_rad = 0.7\n\
                    [errors.tilt]\namplitude_rad = 1.4e-3\nphase_rad = 2.0\n";
/// What the twin says of the shaft's noise.
const DECLARED: &str = "[noise.white]\npsd_n2_m2_s = 6.5e-11\n";

/// What a diagnosis of two speeds names, beside what a disc may be named by.
fn named(disc: &str, missing: &str, told_noise: &str) -> (bool, BTreeSet<Mechanism>) {
    let rig: Vec<Recorded> = [(1, 114.0), (2, 301.0)]
        .into_iter()
        .map(|(seed, r_min)| {
            let speed = format!("[drive.constant]\nr_min = {r_min}\n");
            let truth = format!("seed = {seed}\n{RIG}{speed}{DECLARED}{disc}{missing}");
            recorded(&twin(&truth), &twin(&format!("{RIG}{speed}{told_noise}")))
        })
        .collect();
    let found = diagnose(&rig, &mut |_, _| {}).unwrap().diagnosis.findings;
    let mut named: BTreeSet<Mechanism> = found.iter().map(|one| one.mechanism).collect();
    let disc = named.remove(&Mechanism::LineError);
    for part in [
        Mechanism::WidthError,
        Mechanism::QuadratureError,
        Mechanism::Eccentricity,
        Mechanism::DiscTilt,
    ] {
        named.remove(&part);
    }
    (disc, named)
}

#[test]
fn an_unknown_disc_makes_no_torque_no_tone_and_no_defect() {
    for noise in [DECLARED, ""] {
        assert_eq!(named(DISC, "", noise), (true, BTreeSet::new()), "{noise:?}");
    }
}

#[test]
fn a_mesh_a_hundredth_of_the_disc_is_found_under_it() {
    let mesh = "[[gear_mesh]]\norder = 5.744\ntorque_n_m = 3e-4\nphase_rad = 1.0\n";
    let mesh_alone = BTreeSet::from([Mechanism::GearMesh]);
    for noise in [DECLARED, ""] {
        assert_eq!(
            named(DISC, mesh, noise),
            (true, mesh_alone.clone()),
            "{noise:?}"
        );
    }
}

/// Of a motor's few edges each errs by itself: some stand out, and one order of few is most of it.
#[test]
fn a_coarse_disc_of_which_every_edge_errs_has_no_defects_and_no_waves() {
    for seed in 1..=6 {
        let rig: Vec<Recorded> = [(11, 120.0), (12, 600.0)]
            .into_iter()
            .map(|(noise, r_min)| {
                let told = format!(
                    "seed = {noise}\nduration = {{ turns = 40 }}\n[encoder.hall]\npole_pairs = 4\n\
                     [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 1e-4\nstiffness_n_m_s = 1e-3\n\
                     initial_angle_rad = 1.0\n[drive.constant]\nr_min = {r_min}\n\
                     [noise.white]\npsd_n2_m2_s = 1e-12\n[timer]\nclock_hz = 84000000\njitter_s = 2e-7\n"
                );
                let disc = format!("[errors]\nseed = {seed}\n[errors.position.normal]\nrms_rad = 4e-3\n");
                recorded(&twin(&format!("{told}{disc}")), &twin(&told))
            })
            .collect();
        let found = diagnose(&rig, &mut |_, _| {}).unwrap().diagnosis.findings;
        let named: Vec<Mechanism> = found.iter().map(|one| one.mechanism).collect();
        let needless = [
            Mechanism::LocalDefect,
            Mechanism::Eccentricity,
            Mechanism::DiscTilt,
        ];
        assert!(
            named.contains(&Mechanism::LineError),
            "seed {seed}: {named:?}"
        );
        assert!(
            !named.iter().any(|one| needless.contains(one)),
            "seed {seed}: {named:?}"
        );
    }
}

//! The speed changes slowly, or a load comes and goes, and other effects beside.

use super::super::diagnosis::{Diagnosis, Verdict};
use super::super::run::diagnose;
use super::{recorded, twin};
use crate::mechanism::Mechanism;

/// It starts at its index.
const RIG: &str = "duration = { turns = 25 }\n[encoder.quadrature]\nlines = 250\nindex = true\n\
                   [errors]\nseed = 77\nposition = { uniform = { amplitude_rad = 2e-4 } }\n\
                   [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 1e-4\nstiffness_n_m_s = 2e-3\n\
                   [drive.constant]\nr_min = 300\n[noise.white]\npsd_n2_m2_s = 1e-12\n\
                   [timer]\nclock_hz = 84000000\njitter_s = 2e-8\n";

fn diagnosed(seed: u64, missing: &str) -> Diagnosis {
    let truth = twin(&format!("seed = {seed}\n{RIG}{missing}"));
    let one = recorded(&truth, &twin(RIG));
    diagnose(&[one], &mut |_, _| {}).unwrap().diagnosis
}

/// Half of a parameter's 95 % interval that it may be off by at the most: the fifth of a thousandth.
const WIDE: f64 = 2.0;

fn holds(diagnosis: &Diagnosis, mechanism: Mechanism, name: &str, truth: f64) {
    let found = diagnosis.findings.iter();
    let found = found.filter(|one| one.mechanism == mechanism);
    let [one] = found.collect::<Vec<_>>()[..] else {
        panic!("{mechanism:?} once: {:?}", diagnosis.findings);
    };
    let own = &one.parameters[name];
    let [low, high] = own.ci95.unwrap();
    let half = 0.5 * (high - low);
    assert!(
        (own.value - truth).abs() < WIDE * half && half < 0.1 * truth.abs(),
        "{name} = {own:?}, {truth}"
    );
}

fn explained(diagnosis: &Diagnosis, findings: usize) {
    assert_eq!(
        diagnosis.verdict,
        Verdict::Explained,
        "{:?}",
        diagnosis.findings
    );
    assert_eq!(
        diagnosis.findings.len(),
        findings,
        "{:?}",
        diagnosis.findings
    );
    let fit = &diagnosis.fit;
    let (after, floor) = (fit.rms_after_rad.unwrap(), fit.floor_rad.unwrap());
    assert!(after < 1.3 * floor, "{after} {floor}");
}

#[test]
fn a_drift_of_the_speed_is_followed_though_it_grows_large() {
    for (seed, rate) in [(1, 0.003), (2, 0.01), (3, -0.02), (4, 0.01)] {
        let all = diagnosed(seed, &format!("[speed_drift]\nfraction_per_s = {rate}\n"));
        explained(&all, 1);
        holds(&all, Mechanism::SpeedDrift, "fraction_per_s", rate);
    }
}

#[test]
fn a_drift_that_settles_is_told_with_its_time_constant() {
    for (seed, fraction, tau_s) in [(5, 0.01, 0.5), (6, 0.03, 2.0), (7, -0.01, 1.0)] {
        let drift = format!("[speed_drift]\nfraction = {fraction}\ntau_s = {tau_s}\n");
        let all = diagnosed(seed, &drift);
        explained(&all, 1);
        holds(&all, Mechanism::SpeedDrift, "fraction", fraction);
        holds(&all, Mechanism::SpeedDrift, "tau_s", tau_s);
    }
}

#[test]
fn a_load_that_slows_the_shaft_hides_no_tone_and_no_ripple() {
    let beside = "[[load_step]]\ntorque_n_m = -2e-3\nfrom_s = 1.5\nuntil_s = 2.5\n\
                  [[ripple]]\norder = 6\nphase_rad = 0.9\ntorque_n_m = 8e-4\n\
                  [[torque_tone]]\nf_hz = 37.3\nphase_rad = 0.4\ntorque_n_m = 1e-3\n\
                  [[threshold_ripple]]\nf_hz = 83\nangle_rad = 2e-4\n";
    for seed in [8, 9] {
        let all = diagnosed(seed, beside);
        explained(&all, 4);
        holds(&all, Mechanism::LoadStep, "torque_n_m", -2e-3);
        holds(&all, Mechanism::LoadStep, "until_s", 2.5);
        holds(&all, Mechanism::TorqueRipple, "torque_n_m", 8e-4);
        holds(&all, Mechanism::TorqueTone, "f_hz", 37.3);
        holds(&all, Mechanism::TorqueTone, "torque_n_m", 1e-3);
        holds(&all, Mechanism::ThresholdRipple, "angle_rad", 2e-4);
    }
}

#[test]
fn a_level_that_drifts_on_one_channel_is_found_there_and_known_there() {
    for (seed, channel) in [(1, "A"), (2, "B")] {
        let small = channel.to_lowercase();
        let drift = format!(
            "[[threshold_drift]]\nangle_rad = 3e-4\ntau_s = 0.8\nfrom_s = 1\nchannel = \"{small}\"\n"
        );
        let said = diagnosed(seed, &drift);
        explained(&said, 1);
        holds(&said, Mechanism::ThresholdDrift, "angle_rad", 3e-4);
        assert_eq!(said.findings[0].place.channels, [channel]);

        let told = twin(&format!("{RIG}{drift}"));
        let one = recorded(&twin(&format!("seed = {seed}\n{RIG}{drift}")), &told);
        let said = diagnose(&[one], &mut |_, _| {}).unwrap().diagnosis;
        assert_eq!(said.verdict, Verdict::Complete, "{:?}", said.findings);
    }
}

/// A speed step passes elsewhere in time and angle where the speed is another by two parts in a hundred: that is not linear, whether the
/// twin has no drift, half of it, twice as much, or the other way.
#[test]
fn a_drift_is_found_where_the_speed_steps() {
    let steps = "[drive]\nsteps = [{ t_s = 0, r_min = 300 }, { t_s = 1.4, r_min = 600 }]\n";
    let rig = RIG.replace("[drive.constant]\nr_min = 300\n", steps);
    let drift = |fraction: f64| format!("[speed_drift]\nfraction = {fraction}\ntau_s = 1.0\n");
    for (seed, told) in [(21, 0.0), (22, 0.01), (23, 0.04), (24, -0.02)] {
        let truth = twin(&format!("seed = {seed}\n{rig}{}", drift(0.02)));
        let told = twin(&format!("{rig}{}", drift(told)));
        let said = diagnose(&[recorded(&truth, &told)], &mut |_, _| {}).unwrap();
        explained(&said.diagnosis, 1);
        for (name, value) in [("fraction", 0.02), ("tau_s", 1.0)] {
            let own = &said.diagnosis.findings[0].parameters[name];
            assert!((own.value / value - 1.0).abs() < 0.01, "{name} {own:?}");
        }
    }
}

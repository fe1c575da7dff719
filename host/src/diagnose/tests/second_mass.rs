//! A part of the inertia is behind a spring, and the twin says so.

use super::super::diagnosis::{Diagnosis, Verdict};
use super::super::run::diagnose;
use super::{recorded, twin};
use crate::mechanism::Mechanism;

const RIG: &str = "duration = { seconds = 1.6 }\n[encoder.quadrature]\nlines = 500\nindex = true\n\
                   [errors]\nseed = 77\nposition = { uniform = { amplitude_rad = 2e-4 } }\n\
                   [shaft]\ninertia_kg_m2 = 1e-4\nviscous_n_m_s = 1e-4\nstiffness_n_m_s = 4.9e-3\n\
                   [timer]\nclock_hz = 84000000\njitter_s = 2e-8\n";
const CONSTANT: &str = "[drive.constant]\nr_min = 300\n";
const RAMP: &str = "[drive.ramp]\nfrom_r_min = 300\nto_r_min = -300\nover_s = 1.6\n";
const TURNS_ROUND: &str =
    "[drive]\nsteps = [{ t_s = 0, r_min = 300 }, { t_s = 0.9, r_min = -300 }]\n";
const MODE: &str = "[torsional_resonance]\nf_hz = 120\ndamping_ratio = 0.02\ninertia_share = 0.3\n";
const LOAD: &str = "load_psd_n2_m2_s = 1e-11\n";
const TORQUE: &str = "[noise.white]\npsd_n2_m2_s = 1e-12\n";

fn of(truth: &str, told: &str) -> Diagnosis {
    let one = recorded(&twin(truth), &twin(told));
    diagnose(&[one], &mut |_, _| {}).unwrap().diagnosis
}

/// A step of the speed makes it ring, noise on either side shakes it: all of that the twin knows.
#[test]
fn nothing_is_missing_however_it_is_shaken() {
    for (seed, drive) in [(1, CONSTANT), (2, RAMP), (3, TURNS_ROUND)] {
        for noise in ["", LOAD, &format!("{LOAD}{TORQUE}"), TORQUE] {
            let rig = format!("seed = {seed}\n{RIG}{drive}{MODE}{noise}");
            let said = of(&rig, &rig);
            assert_eq!(
                said.verdict,
                Verdict::Complete,
                "{rig}: {:?}",
                said.findings
            );
        }
    }
}

/// Where a ripple passes the mode it makes many times as much of the angle as of a stiff shaft's.
#[test]
fn a_ripple_that_it_answers_has_its_own_size() {
    let rig = format!("seed = 4\n{RIG}{RAMP}{MODE}{TORQUE}");
    let truth = format!("{rig}[[ripple]]\norder = 23\nphase_rad = 0.4\ntorque_n_m = 2e-4\n");
    let said = of(&truth, &rig);
    assert_eq!(said.verdict, Verdict::Explained, "{:?}", said.findings);
    let [one] = &said.findings[..] else {
        panic!("{:?}", said.findings);
    };
    assert!(matches!(one.mechanism, Mechanism::TorqueRipple), "{one:?}");
    let size = &one.parameters["torque_n_m"];
    let [low, high] = size.ci95.unwrap();
    assert!(low < 2e-4 && 2e-4 < high, "{size:?}");
    assert!(high - low < 2e-5, "{size:?}");
}

/// Declared a tenth too high, it is named where it is.
#[test]
fn another_mode_than_the_twins_is_named() {
    let rig = |f_hz: &str| {
        let mode = MODE.replace("120", f_hz);
        format!("seed = 5\n{RIG}{CONSTANT}{TORQUE}{mode}")
    };
    let said = of(&rig("120"), &rig("132"));
    let [one] = &said.findings[..] else {
        panic!("{:?}", said.findings);
    };
    assert_eq!(one.mechanism, Mechanism::TorsionalResonance);
    let f_hz = &one.parameters["f_hz"];
    assert!((f_hz.value - 120.0).abs() < 2.0, "{f_hz:?}");
}

/// The load shakes it too, or alone: that is in the numbers, also where the twin has the mode and no load that shakes it.
#[test]
fn what_shakes_the_far_side_is_named_with_the_mode() {
    let longer = RIG.replace("seconds = 1.6", "seconds = 8");
    let stronger = LOAD.replace("1e-11", "2e-10");
    let mode = MODE.replace("120", "70");
    for (seed, load, psd, told) in [
        (6, LOAD, 1e-11, ""),
        (7, stronger.as_str(), 2e-10, ""),
        (8, LOAD, 1e-11, mode.as_str()),
    ] {
        let rig = format!(
            "seed = {seed}\n{longer}{CONSTANT}{}",
            TORQUE.replace("12", "11")
        );
        let said = of(&format!("{rig}{mode}{load}"), &format!("{rig}{told}"));
        let [one] = &said.findings[..] else {
            panic!("{:?}", said.findings);
        };
        assert_eq!(one.mechanism, Mechanism::TorsionalResonance);
        for (name, value) in [("f_hz", 70.0), ("load_psd_n2_m2_s", psd)] {
            let own = &one.parameters[name];
            let [low, high] = own.ci95.unwrap();
            let half = 0.5 * (high - low);
            assert!((own.value - value).abs() < 2.0 * half, "{name} {own:?}");
            assert!(half < 0.5 * value, "{name} {own:?}");
        }
    }
}

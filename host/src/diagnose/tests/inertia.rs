//! An inertia in a wrong unit is refused, and a shaft that goes far otherwise for another reason is not.

use super::{STEADY, recorded, twin};
use crate::diagnose::run::DiagnoseError;
use crate::diagnose::{inertia, prepare};

fn refused(truth: &str, told: &str) -> Option<String> {
    let rig = [recorded(&twin(truth), &twin(told))];
    let board = prepare::board(&rig).unwrap();
    match inertia::checked(&rig, &board) {
        Err(DiagnoseError::OtherRig { why, .. }) => Some(why),
        other => {
            other.unwrap();
            None
        }
    }
}

#[test]
fn an_inertia_in_a_wrong_unit_is_refused_with_the_one_that_the_shaft_shows() {
    let disc = "[errors.position.normal]\nrms_rad = 3e-4\n";
    for (unit, more) in [("1", ""), ("1000", ""), ("1e-7", ""), ("1", disc)] {
        let told = STEADY.replace("inertia_kg_m2 = 1e-4", &format!("inertia_kg_m2 = {unit}"));
        let why = refused(&format!("{STEADY}{more}"), &told).unwrap_or_else(|| panic!("{unit}"));
        let shows = why.split("about ").nth(1).unwrap();
        let shows: f64 = shows.split(' ').next().unwrap().parse().unwrap();
        assert!((0.5e-4..2e-4).contains(&shows), "{unit}: {why}");
    }
}

#[test]
fn a_twin_without_a_torque_or_an_error_a_thousand_times_its_noise_is_not_refused() {
    for more in [
        "[[gear_mesh]]\norder = 7.3\ntorque_n_m = 2e-2\n",
        "[[ripple]]\norder = 4\ntorque_n_m = 2e-2\n[[ripple]]\norder = 12\ntorque_n_m = 2e-2\n",
        "[[torque_tone]]\nf_hz = 23.4\ntorque_n_m = 1e-2\n[[torque_tone]]\nf_hz = 71\ntorque_n_m = 1e-2\n",
        "[errors.eccentricity]\namplitude_rad = 2e-2\n",
        "[errors.position.normal]\nrms_rad = 5e-3\n",
        "[[load_step]]\nfrom_s = 3\ntorque_n_m = 1e-3\n",
    ] {
        assert_eq!(refused(&format!("{STEADY}{more}"), STEADY), None, "{more}");
    }
    let jitter = STEADY.replace("jitter_s = 1e-7", "jitter_s = 4e-6");
    assert_eq!(refused(&jitter, STEADY), None);
}

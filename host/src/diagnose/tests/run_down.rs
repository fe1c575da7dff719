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

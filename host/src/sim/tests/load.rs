//! Loads against closed forms.

use super::*;
use crate::twin::LoadStep;

fn load(torque_n_m: f64, from_s: f64, until_s: Option<f64>) -> LoadStep {
    LoadStep {
        torque_n_m,
        from_s,
        until_s,
    }
}

/// 60 r/min held with a time constant of 0.1 s.
fn held(loads: Vec<LoadStep>) -> Twin {
    let mut twin = plain(60.0, 1.0);
    twin.shaft.stiffness_n_m_s = 9e-4;
    twin.duration = Duration::Seconds(2.5);
    twin.load_step = loads;
    twin
}

#[test]
fn a_shaft_gives_way_to_loads_that_overlap_and_comes_back_after_them() {
    let twin = held(vec![
        load(-2e-3, 1.0, Some(1.4)),
        load(5e-4, 1.2, None),
        load(-1e-3, 0.0, Some(0.3)),
    ]);
    // Each torque alone makes the speed torque / (b + stiffness) in the end, so much is b + stiffness.
    let yielded = |torque: f64, since: f64| {
        let s = since.max(0.0);
        torque / 1e-3 * (s - 0.1 * (1.0 - (-s / 0.1).exp()))
    };
    let mut last = 0.0;
    for event in Simulation::new(&twin).unwrap() {
        let t = event.truth.time_s;
        let expected = 60.0 * RAD_S * t + yielded(-2e-3, t - 1.0) - yielded(-2e-3, t - 1.4)
            + yielded(5e-4, t - 1.2)
            + yielded(-1e-3, t)
            - yielded(-1e-3, t - 0.3);
        assert!((event.truth.angle_rad - expected).abs() < 1e-11, "at {t} s");
        last = t;
    }
    assert!(last > 2.49);
}

#[test]
fn a_load_turns_a_shaft_that_stands_and_friction_holds_it_against_a_smaller_one() {
    let mut twin = plain(0.0, 1.0);
    twin.duration = Duration::Seconds(1.0);
    twin.shaft.coulomb_n_m = 1e-3;
    twin.load_step = vec![load(0.99e-3, 0.1, None)];
    assert_eq!(Simulation::new(&twin).unwrap().count(), 0);
    twin.load_step[0].torque_n_m = -1.5e-3;
    let last = Simulation::new(&twin).unwrap().last().unwrap().truth;
    assert!(last.angle_rad < -1.0, "{last:?}");
}

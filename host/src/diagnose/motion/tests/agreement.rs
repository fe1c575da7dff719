//! How well what was found agrees with its recording.

use super::*;
use crate::diagnose::run::diagnose;

#[test]
fn slips_leave_noise_once_they_are_in_the_twin() {
    for seed in 1..=3 {
        let noise = Noise::White {
            psd_n2_m2_s: 1e-13,
            hold_s: None,
        };
        let (truth, told) = sticking(Some(noise));
        let found = diagnose(&[recorded(&truth, &told, seed)], &mut |_, _| ()).unwrap();
        let fit = found.diagnosis.fit;
        let (before, after) = (fit.rms_before_rad.unwrap(), fit.rms_after_rad.unwrap());
        let floor = fit.floor_rad.unwrap();
        assert!(after < 0.01 * before, "{seed}: {fit:?}");
        assert!((0.5..2.0).contains(&(after / floor)), "{seed}: {fit:?}");
        let held = fit.held_out;
        assert!(held.rms_after_rad.unwrap() < 2.0 * floor, "{seed}: {fit:?}");
        assert!(held.reducible_removed.unwrap() > 0.99, "{seed}: {fit:?}");
        assert!(fit.whiteness_p_before.unwrap() < 1e-6, "{seed}: {fit:?}");
        assert!(fit.whiteness_p.unwrap() > 1e-3, "{seed}: {fit:?}");
        assert!(fit.slow.rms_before_rad.is_none());
        assert!(!found.shown.findings[0].before.is_empty());
        assert!(!found.shown.recordings[0].after.is_empty());
    }
}

#[test]
fn a_loop_is_judged_on_the_turns_that_it_was_not_fitted_on() {
    let told = rig(240.0, 40.0);
    let mut truth = told.clone();
    truth.shaft.stiffness_n_m_s = 0.0;
    truth.drive = Drive::SpeedLoop {
        r_min: 240.0,
        f_hz: 211.7,
        bandwidth_hz: None,
        kp_n_m_s: Some(2.5e-3),
        ki_n_m: Some(1e-2),
        timeout_s: None,
        limit_n_m: None,
    };
    let found = diagnose(&[recorded(&truth, &told, 1)], &mut |_, _| ()).unwrap();
    let fit = found.diagnosis.fit;
    let edges = fit.edge_to_edge;
    assert!(edges.rms_before_rad > edges.rms_after_rad, "{fit:?}");
    assert!(fit.held_out.reducible_removed.unwrap() > 0.9, "{fit:?}");
    assert!(fit.whiteness_p_before.unwrap() < 1e-6, "{fit:?}");
    let evidence = &found.diagnosis.findings[0].evidence;
    assert!(evidence.held_out_rms_ratio.unwrap() < 1.0, "{evidence:?}");
}

//! How well what was found agrees with its recording.

use super::*;
use crate::diagnose::diagnosis::{Finding, Verdict};
use crate::diagnose::run::{DiagnoseError, diagnose};
use crate::twin::Duration;

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

fn noisy(psd_n2_m2_s: f64) -> Option<Noise> {
    Some(Noise::White {
        psd_n2_m2_s,
        hold_s: None,
    })
}

fn verdict(recording: Recorded) -> (Verdict, Vec<Finding>) {
    let said = diagnose(&[recording], &mut |_, _| ()).unwrap().diagnosis;
    (said.verdict, said.findings)
}

#[test]
fn a_twin_that_sticks_is_complete_against_other_runs_of_itself() {
    for (friction, psd) in [(1.0, 1e-11), (0.6, 1e-12), (1.7, 1e-13)] {
        let (mut truth, _) = sticking(noisy(psd));
        truth.shaft.stribeck_n_m *= friction;
        truth.shaft.coulomb_n_m *= friction;
        for seed in 1..=2 {
            let (verdict, findings) = verdict(recorded(&truth, &truth, seed));
            assert_eq!(
                verdict,
                Verdict::Complete,
                "{friction} {seed}: {findings:?}"
            );
        }
    }
}

#[test]
fn a_twin_of_another_friction_is_found_out_and_the_mended_one_is_complete() {
    for (factor, seed) in [(0.7, 1), (1.05, 2)] {
        let (told, _) = sticking(noisy(1e-12));
        let mut truth = told.clone();
        truth.shaft.stribeck_n_m *= factor;
        truth.shaft.coulomb_n_m *= factor;
        let recording = recorded(&truth, &told, seed);
        let found = diagnose(std::slice::from_ref(&recording), &mut |_, _| ()).unwrap();
        assert_eq!(found.diagnosis.verdict, Verdict::Explained, "{factor}");
        let finding = &found.diagnosis.findings[0];
        assert_eq!(finding.mechanism, Mechanism::StickSlip);
        let [low, high] = finding.parameters["stribeck_n_m"].ci95.unwrap();
        let off = 0.5 * (low + high) - truth.shaft.stribeck_n_m;
        assert!(off.abs() < high - low, "{factor}: {off} of {low} to {high}");
        assert!(finding.evidence.delta_bic > 50.0, "{finding:?}");
        let mended = found.twins[0].clone();
        let same = Recorded {
            twin: mended.clone(),
            ..recording
        };
        assert_eq!(verdict(same).0, Verdict::Complete, "{factor}");
        let fresh = recorded(&mended, &mended, 40 + seed);
        assert_eq!(verdict(fresh).0, Verdict::Complete, "{factor}");
    }
}

#[test]
fn the_twin_of_a_diagnosis_sticks_and_is_complete() {
    for seed in 1..=2 {
        let (mut truth, told) = sticking(noisy(1e-12));
        // Friction falls faster, so that a shaft may nearly turn on evenly.
        truth.shaft.stribeck_rad_s *= 0.8;
        let recording = recorded(&truth, &told, seed);
        let found = diagnose(std::slice::from_ref(&recording), &mut |_, _| ()).unwrap();
        let said = &found.diagnosis;
        assert_eq!(said.verdict, Verdict::Explained, "{seed}: {said:?}");
        let mended = found.twins[0].clone();
        let same = Recorded {
            twin: mended.clone(),
            ..recording
        };
        assert_eq!(verdict(same).0, Verdict::Complete);
        assert_eq!(
            verdict(recorded(&mended, &mended, 70 + seed)).0,
            Verdict::Complete
        );
    }
}

#[test]
fn few_slips_say_nothing_and_say_so() {
    let (told, _) = sticking(noisy(1e-12));
    let mut truth = told.clone();
    truth.shaft.stribeck_n_m *= 1.5;
    for (turns, truth) in [(0.05, &told), (0.2, &told), (0.2, &truth)] {
        let short = Twin {
            duration: Duration::Turns(turns),
            ..truth.clone()
        };
        let recording = recorded(&short, &told, 1);
        let said = diagnose(&[recording], &mut |_, _| ());
        let error = said.map(|said| said.diagnosis).unwrap_err();
        assert!(matches!(error, DiagnoseError::FewSlips { .. }), "{error}");
        assert!(error.to_string().contains("record 6 or more"), "{error}");
    }
}

#[test]
fn what_turns_evenly_is_no_run_of_a_twin_that_sticks() {
    let (told, even) = sticking(noisy(1e-11));
    let (verdict, findings) = verdict(recorded(&even, &told, 1));
    assert_ne!(verdict, Verdict::Complete);
    let sticks = findings
        .iter()
        .find(|f| f.mechanism == Mechanism::StickSlip);
    let text = &sticks.expect("what differs").text;
    assert!(text.contains("turns on evenly"), "{text}");
}

#[test]
fn a_verdict_agrees_with_what_is_left_without_any_noise() {
    let (truth, told) = sticking(None);
    for seed in 1..=3 {
        let said = diagnose(&[recorded(&truth, &told, seed)], &mut |_, _| ()).unwrap();
        let (fit, verdict) = (said.diagnosis.fit, said.diagnosis.verdict);
        assert_eq!(verdict, Verdict::Explained, "{fit:?}");
        assert!(fit.whiteness_p.unwrap() > 1e-6, "{fit:?}");
        let (after, floor) = (fit.rms_after_rad.unwrap(), fit.floor_rad.unwrap());
        assert!(after < 2.0 * floor, "{fit:?}");
    }
}

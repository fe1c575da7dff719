//! Tasks that hold captures up, at many rates and of short busy times.

use super::*;
use crate::diagnose::diagnosis::Verdict;
use crate::diagnose::run::Diagnosed;
use crate::mechanism::Mechanism;

/// Rate in Hz, busy time in s.
const TASKS: [(f64, f64); 5] = [
    (57.31, 3e-5),
    (213.7, 1e-5),
    (1000.03, 4e-6),
    (3301.9, 2e-5),
    (7907.1, 8e-6),
];

fn text((f_hz, busy_s): (f64, f64), seed: u64) -> String {
    let phase_s = 0.037 * seed as f64 % 1.0 / f_hz;
    format!("[capture_latency]\ntask_hz = {f_hz}\nbusy_s = {busy_s:e}\nphase_s = {phase_s:e}")
}

#[test]
fn a_task_is_found_with_its_rate_and_busy_time() {
    let (mut off, mut count) = (0.0, 0.0);
    for task in TASKS {
        for seed in 21..=24 {
            let found = found(seed, &text(task, seed), 0.0);
            assert_eq!(found.len(), 1, "{task:?} {seed}: {found:?}");
            assert_eq!(found[0].mechanism, Mechanism::CaptureLatency);
            near(
                &found[0],
                &[("task_hz", task.0, 1e-6), ("busy_s", task.1, 0.1)],
            );
            for (name, truth) in [("task_hz", task.0), ("busy_s", task.1)] {
                let parameter = found[0].parameters.iter().find(|p| p.name == name);
                let parameter = parameter.unwrap();
                off += ((parameter.value - truth) / parameter.standard_error).powi(2);
                count += 1.0;
            }
        }
    }
    // Standard errors are what values are off by: 40 squares have a mean of 1, give or take 0.22.
    assert!((0.3..2.0).contains(&(off / count)), "{}", off / count);
}

#[test]
fn edges_too_late_at_any_time_are_no_task() {
    for seed in 31..=34 {
        let board = prepare::board(&rig(seed, "", "", 0.0)).expect("a board");
        let mut model = Model::none(&board);
        let mut random = seed;
        for left in &mut model.left {
            for left in left.iter_mut() {
                random = random
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                if random >> 33 < 1 << 23 {
                    *left -= 20.0;
                }
            }
        }
        let found = super::super::find_task(&board, &model.left);
        assert!(
            found.is_none(),
            "{seed}: {:?}",
            found.map(|task| task.finding)
        );
    }
}

#[test]
fn tones_stay_what_they_are() {
    for (more, mechanism) in [
        (
            "[[torque_tone]]\nf_hz = 61.3\ntorque_n_m = 2e-4",
            Mechanism::TorqueTone,
        ),
        (
            "[[threshold_ripple]]\nf_hz = 47.3\nangle_rad = 4e-5",
            Mechanism::ThresholdRipple,
        ),
    ] {
        for seed in SEEDS {
            let rig = rig(seed, "", more, 0.0);
            let found = diagnose(&rig, &mut |_, _| ()).expect("a diagnosis");
            let findings = found.diagnosis.findings.iter();
            let names: Vec<Mechanism> = findings.map(|f| f.mechanism).collect();
            assert_eq!(names, [mechanism], "{more} {seed}");
        }
    }
}

/// The same recordings with other twins.
fn against(rig: &[Recorded], twins: &[Twin]) -> Diagnosed {
    let each = rig.iter().zip(twins).map(|(one, twin)| Recorded {
        twin: twin.clone(),
        ..one.clone()
    });
    let rig: Vec<Recorded> = each.collect();
    diagnose(&rig, &mut |_, _| ()).expect("a diagnosis")
}

/// Recordings of twins with another seed, clocks that differ by parts in a million and the task at another time, against them.
fn again(twins: &[Twin], seed: u64) -> Diagnosed {
    let each = twins.iter().map(|twin| {
        let mut real = Twin {
            seed,
            ..twin.clone()
        };
        if let Some(latency) = &mut real.capture_latency {
            latency.task_hz = latency.task_hz.map(|f_hz| f_hz * (1.0 + 4e-5));
            latency.phase_s = latency.task_hz.map(|f_hz| 0.37 / f_hz);
        }
        let plan = SensorPlan {
            kind: SensorKind::Quadrature { index_state: None },
            lines: 100,
        };
        let rows = Simulation::new(&real).expect("it runs");
        let rows = rows.map(|event| Ok::<_, PlanError>(event.row));
        Recorded {
            file: "again.csv".into(),
            plan,
            track: Track::of(plan, real.timer.clock_hz, rows).expect("it decodes"),
            twin: twin.clone(),
        }
    });
    let rig: Vec<Recorded> = each.collect();
    diagnose(&rig, &mut |_, _| ()).expect("a diagnosis")
}

#[test]
fn with_a_task_the_fit_is_noise_on_held_out_turns_too_and_its_twins_are_complete() {
    for (seed, task) in (41..).zip(TASKS) {
        let rig = rig(seed, "", &text(task, seed), 0.0);
        let found = diagnose(&rig, &mut |_, _| ()).expect("a diagnosis");
        let names: Vec<Mechanism> = (found.diagnosis.findings.iter())
            .map(|f| f.mechanism)
            .collect();
        assert_eq!(names, [Mechanism::CaptureLatency], "{task:?}");
        let fit = &found.diagnosis.fit;
        let band = fit.edge_to_edge;
        let [before, after, floor] =
            [band.rms_before_rad, band.rms_after_rad, band.floor_rad].map(Option::unwrap);
        assert!(before > 1.2 * after, "{task:?}: {band:?}");
        assert!((after / floor - 1.0).abs() < 0.05, "{task:?}: {band:?}");
        // Nearly all of it is the shaft's wander, which differs a little by which edges are left out.
        let whole = [fit.rms_before_rad, fit.rms_after_rad].map(Option::unwrap);
        assert!(whole[1] < 1.01 * whole[0], "{task:?}: {fit:?}");
        let whiteness = [fit.whiteness_p_before, fit.whiteness_p].map(Option::unwrap);
        assert!(whiteness[1] > 0.01, "{task:?}: {whiteness:?}");
        let finding = &found.diagnosis.findings[0];
        let held_out = finding.evidence.held_out_rms_ratio.unwrap();
        assert!(held_out < 0.9, "{task:?}: {held_out}");
        assert!((finding.place.frequencies_hz[0] / task.0 - 1.0).abs() < 1e-5);
        // What is drawn is late within the busy time without it, and nowhere with it.
        let plot = &found.shown.findings[0];
        let most = |line: &[(f64, f64)]| line.iter().map(|p| p.1).fold(0.0, f64::max);
        let busy_us = 1e6 * task.1;
        assert!(most(&plot.before) > 0.6 * busy_us, "{task:?}: {plot:?}");
        let square = |line: &[(f64, f64)]| line.iter().map(|p| p.1 * p.1).sum::<f64>();
        assert!(square(&plot.after) < 0.1 * square(&plot.before), "{task:?}");
        for (what, known) in [
            ("same", against(&rig, &found.twins)),
            ("fresh", again(&found.twins, seed + 100)),
        ] {
            let diagnosis = &known.diagnosis;
            assert_eq!(
                diagnosis.verdict,
                Verdict::Complete,
                "{task:?} {what}: {diagnosis:?}"
            );
        }
    }
}

#[test]
fn a_task_that_is_another_than_the_twins_is_told_as_it_is() {
    for (seed, wrong) in (51..).zip([(213.7, 2e-5), (213.7, 4e-6), (427.4, 1e-5), (150.0, 1e-5)]) {
        let task = (213.7, 1e-5);
        let rig = rig(seed, "", &text(task, seed), 0.0);
        let twins: Vec<Twin> = rig
            .iter()
            .map(|one| {
                let mut twin = one.twin.clone();
                twin.capture_latency = Some(crate::twin::CaptureLatency {
                    task_hz: Some(wrong.0),
                    busy_s: Some(wrong.1),
                    ..Default::default()
                });
                twin
            })
            .collect();
        let found = against(&rig, &twins).diagnosis.findings;
        assert_eq!(found.len(), 1, "{wrong:?}: {found:?}");
        assert_eq!(found[0].mechanism, Mechanism::CaptureLatency);
        let value = |name: &str| found[0].parameters[name].value;
        assert!((value("task_hz") / task.0 - 1.0).abs() < 1e-5, "{wrong:?}");
        assert!((value("busy_s") / task.1 - 1.0).abs() < 0.1, "{wrong:?}");
        assert!(found[0].text.contains("the twin's"), "{}", found[0].text);
    }
}

#[test]
fn a_latency_that_the_twin_declares_is_no_finding() {
    for seed in SEEDS {
        let late = "[capture_latency]\nmean_s = 3e-7";
        assert_eq!(found_beside(seed, late), Vec::new(), "seed {seed}");
    }
}

/// What the noise lacks in recordings of twins that declare it.
fn found_beside(seed: u64, known: &str) -> Vec<NoiseFinding> {
    let board = prepare::board(&rig(seed, known, "", 0.0)).expect("a board");
    noise_findings(&board, &Model::none(&board))
}

//! What the core says of a table before it is solved for, against what the table then comes to.

use quadcal::estimate::{Advice, DriveKnowledge, Estimator, Goal, Outlook, Progress};
use quadcal::units::RAD_PER_TURN32;
use quadcal_host::buffers::HeapBuffers;
use quadcal_host::calibrate::{self, CalibrateOptions};
use quadcal_host::sim::Simulation;
use quadcal_host::survey::Survey;
use quadcal_host::twin::{Duration, Noise};
use quadcal_host_tests::accuracy::{distance, rms, table_rad};
use quadcal_host_tests::anywhere::{self, Recorded, Rig, Scenario};

/// Learns from recordings until `stop`, given turns taken and outlook, says so; returns both, with the table's error.
fn learn(
    rig: Rig,
    drive: DriveKnowledge,
    recordings: &[Recorded],
    truth: &[f64],
    mut stop: impl FnMut(u32, Option<Outlook>) -> bool,
) -> (u32, Option<Outlook>, f64) {
    let options = CalibrateOptions {
        lines: Some(rig.lines),
        drive,
        ..CalibrateOptions::default()
    };
    let mut estimator = None;
    'recordings: for recorded in recordings {
        let rows = || recorded.rows.iter().copied();
        let survey = Survey::of(recorded.header.clone(), rows().map(Ok)).unwrap();
        let plan = calibrate::plan(&survey, &options).unwrap();
        let estimator = estimator.get_or_insert_with(|| {
            let shape = plan.shape().unwrap();
            let buffers = HeapBuffers::new(shape.edges() as usize);
            let estimator = Estimator::new(shape, plan.anchor(), buffers).unwrap();
            estimator.with_knowledge(drive)
        });
        let mut decoder = plan.decoder().unwrap();
        for row in rows() {
            if let Progress::TurnTaken(turns) = estimator.push(&decoder.push(row))
                && stop(turns, estimator.outlook())
            {
                break 'recordings;
            }
        }
        estimator.interrupt();
    }
    let mut estimator = estimator.unwrap();
    let (turns, outlook) = (estimator.totals().turns, estimator.outlook());
    let table = table_rad(&estimator.solve().unwrap());
    (turns, outlook, distance(&table, truth))
}

fn rad(error: u32) -> f64 {
    f64::from(error) * RAD_PER_TURN32
}

/// RMS over seeds of the outlook and of the error, after so many turns.
fn outlook_and_error(scenario: Scenario, turns: u32, seeds: std::ops::Range<u64>) -> (f64, f64) {
    let rig = Rig {
        scenario,
        lines: 60,
    };
    let (outlooks, errors): (Vec<f64>, Vec<f64>) = seeds
        .map(|seed| {
            let run = rig.run(seed).unwrap();
            let (taken, outlook, error) = learn(
                rig,
                rig.knowledge(),
                &run.recordings,
                &run.truth,
                |taken, _| taken == turns,
            );
            assert_eq!(taken, turns);
            (rad(outlook.unwrap().error), error)
        })
        .unzip();
    (rms(&outlooks), rms(&errors))
}

#[test]
fn the_error_to_expect_is_what_the_table_comes_to() {
    for (scenario, turns, seeds) in [
        (Scenario::OneSpeed, 6, 300..340),
        (Scenario::OneSpeed, 11, 300..340),
        (Scenario::TwoSpeeds, 17, 300..325),
        (Scenario::TwoSpeeds, 22, 300..325),
        // A ramp's swings change from turn to turn, which looks like more noise than there is.
        (Scenario::Ramp, 57, 300..315),
    ] {
        let (outlook, error) = outlook_and_error(scenario, turns, seeds);
        let ratio = outlook / error;
        println!(
            "{} after {turns}: expects {outlook:.2e}, is {error:.2e}",
            scenario.name()
        );
        let most = if scenario == Scenario::Ramp {
            2.0
        } else {
            1.35
        };
        assert!(
            (0.85..most).contains(&ratio),
            "{scenario:?} {turns}: {ratio}"
        );
    }
}

#[test]
fn where_noise_drowns_the_low_orders_no_more_is_left_than_there_is() {
    // Any order may be torque, and there is no eccentricity: the low orders are left alone.
    let rig = Rig {
        scenario: Scenario::OneSpeed,
        lines: 2500,
    };
    let ratios: Vec<f64> = (500..506)
        .map(|seed| {
            let mut twin = rig.twins(seed).swap_remove(0);
            (twin.errors.eccentricity, twin.errors.tilt) = (None, None);
            let simulation = Simulation::new(&twin).unwrap();
            let truth = simulation.true_errors();
            let recorded = anywhere::record(simulation);
            let any_torque = DriveKnowledge::default();
            let (_, outlook, error) = learn(rig, any_torque, &[recorded], &truth, |_, _| false);
            rad(outlook.unwrap().error) / error
        })
        .collect();
    println!("{ratios:.2?}");
    assert!(
        ratios.iter().all(|ratio| (0.7..1.6).contains(ratio)),
        "{ratios:?}"
    );
}

#[test]
fn learning_ends_when_the_goal_is_met_and_then_it_is() {
    let rig = Rig {
        scenario: Scenario::OneSpeed,
        lines: 60,
    };
    let goal = 2.4e-4;
    let aim = Goal {
        error: (goal / RAD_PER_TURN32) as u32,
    };
    let (mut errors, mut ends) = (Vec::new(), Vec::new());
    for seed in 400..440 {
        let run = rig.run(seed).unwrap();
        let (turns, outlook, error) = learn(
            rig,
            rig.knowledge(),
            &run.recordings,
            &run.truth,
            |_, outlook| outlook.is_some_and(|outlook| outlook.advice(aim) == Advice::GoalMet),
        );
        assert!(outlook.unwrap().error <= aim.error, "seed {seed}");
        ends.push(turns);
        errors.push(error);
    }
    println!("{:?} turns, {:.2e} rad", ends, rms(&errors));
    assert!(ends.iter().all(|turns| (6..=12).contains(turns)));
    assert!(ends.iter().any(|turns| *turns != ends[0]));
    assert!(rms(&errors) < 1.25 * goal, "{:.2e}", rms(&errors));
}

#[test]
fn a_coarse_timer_leaves_nothing_to_gain_and_a_fine_one_does() {
    let rig = Rig {
        scenario: Scenario::OneSpeed,
        lines: 60,
    };
    let advice = |clock_hz: u64| {
        let mut twin = rig.twins(7).swap_remove(0);
        twin.timer.clock_hz = clock_hz;
        twin.duration = Duration::Turns(42.0);
        if let Some(Noise::SpeedWander { rms_fraction, .. }) = &mut twin.noise {
            *rms_fraction /= 30.0;
        }
        let simulation = Simulation::new(&twin).unwrap();
        let truth = simulation.true_errors();
        let recorded = anywhere::record(simulation);
        let mut end = None;
        learn(
            rig,
            rig.knowledge(),
            &[recorded],
            &truth,
            |turns, outlook| {
                let advice = outlook.map(|outlook| outlook.advice(Goal::default()));
                let ended = advice.is_some_and(|advice| advice != Advice::GoOn);
                if ended {
                    end = Some((turns, advice.unwrap()));
                }
                ended
            },
        );
        end
    };
    let (turns, why) = advice(10_000).unwrap();
    assert_eq!(why, Advice::NoFurtherGain);
    assert!((6..20).contains(&turns), "{turns}");
    assert_eq!(advice(84_000_000), None);
}

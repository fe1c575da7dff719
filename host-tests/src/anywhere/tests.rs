use quadcal::step::{Flags, Outcome};
use quadcal_host::calibrate::{self, CalibrateOptions};
use quadcal_host::survey::Survey;

use super::*;
use crate::accuracy::rms;

fn rig(scenario: Scenario) -> Rig {
    Rig {
        scenario,
        lines: 60,
    }
}

#[test]
fn every_recording_holds_its_turns_and_the_core_numbers_the_edges_alike() {
    for scenario in Scenario::ALL {
        // Sixty lines at 15 r/min come too rarely for a loop of 100 Hz.
        let lines = if scenario == Scenario::SpeedLoop {
            2500
        } else {
            60
        };
        let run = Rig { scenario, lines }.run(5).unwrap();
        let edges = run.truth.len();
        assert_eq!(edges, 4 * lines as usize);
        for recorded in &run.recordings {
            let replay = || recorded.rows.iter().copied().map(Ok);
            let survey = Survey::of(recorded.header.clone(), replay()).unwrap();
            let options = CalibrateOptions {
                lines: Some(lines),
                ..CalibrateOptions::default()
            };
            let plan = calibrate::plan(&survey, &options).unwrap();
            let mut decoder = plan.decoder().unwrap();
            let mut times = Vec::new();
            for row in &recorded.rows {
                if let Outcome::Step(step) = decoder.push(*row)
                    && step.flags.contains(Flags::REFERENCED)
                    && (step.edge == 0 || !times.is_empty())
                {
                    assert_eq!(step.edge as usize, times.len() % edges);
                    times.push(step.ticks);
                }
            }
            assert!(times == recorded.times, "{scenario:?}");
            let turns = (times.len() - 1) / edges;
            let expected = if scenario == Scenario::Ramp { 60 } else { 12 };
            assert_eq!(turns, expected, "{scenario:?}");
        }
    }
}

#[test]
fn recordings_of_a_rig_share_the_disc_and_not_the_noise() {
    let twins = rig(Scenario::TwoSpeeds).twins(4);
    let errors = |twin: &Twin| Simulation::new(twin).unwrap().true_errors();
    assert_eq!(errors(&twins[0]), errors(&twins[1]));
    assert_ne!(twins[0].seed, twins[1].seed);
    let other = rig(Scenario::TwoSpeeds).twins(5);
    assert_ne!(errors(&twins[0]), errors(&other[0]));
    assert!(other.iter().all(|o| twins.iter().all(|t| t.seed != o.seed)));
}

/// RMS deviation, as a part of the speed `r_min`, of the speeds over each sixth of a radian, of a disc without errors.
fn wander(scenario: Scenario, part: usize, seeds: std::ops::Range<u64>) -> f64 {
    let powers: Vec<f64> = seeds
        .flat_map(|seed| {
            let mut twin = rig(scenario).twins(seed).swap_remove(part);
            twin.errors = quadcal_host::twin::Errors::default();
            twin.ripple.clear();
            twin.duration = Duration::Turns(6.0);
            let nominal = twin.drive.nominal_rad_s();
            let recorded = record(Simulation::new(&twin).unwrap());
            let span = 6;
            let turned = TAU * span as f64 / 240.0;
            let speeds: Vec<f64> = recorded
                .times
                .windows(span + 1)
                .step_by(span)
                .map(|w| turned * CLOCK_HZ as f64 / (w[span] - w[0]) as f64 / nominal - 1.0)
                .collect();
            speeds
        })
        .collect();
    rms(&powers)
}

#[test]
fn the_shaft_wanders_a_thousandth_at_the_slow_speed_and_accordingly_less_at_the_fast_one() {
    // Over the angle x = 0.157 rad a speed that forgets over L = 0.5 rad is averaged to 2 (L/x)^2 (x/L - 1 + exp(-x/L)) of its
    // power, 0.904; over L = 20 rad to nothing less.
    let slow = wander(Scenario::OneSpeed, 0, 0..20);
    assert!(
        (slow / (1e-3 * 0.904_f64.sqrt()) - 1.0).abs() < 0.1,
        "{slow:e}"
    );
    let fast = wander(Scenario::TwoSpeeds, 1, 0..60);
    assert!((fast / 2.5e-5 - 1.0).abs() < 0.25, "{fast:e}");
}

#[test]
fn cogging_swings_the_slow_speed_by_one_per_cent_at_each_of_its_orders() {
    let mut twin = rig(Scenario::OneSpeedCogging).twins(1).swap_remove(0);
    twin.noise = None;
    twin.errors = quadcal_host::twin::Errors::default();
    let nominal = twin.drive.nominal_rad_s();
    let recorded = record(Simulation::new(&twin).unwrap());
    // The third turn, from its index on.
    let turn = &recorded.times[480..=720];
    let mean = (turn[240] - turn[0]) as f64 / 240.0;
    for (order, _) in COGGING {
        let (mut re, mut im) = (0.0, 0.0);
        for k in 0..240 {
            let late = (turn[k] - turn[0]) as f64 - mean * k as f64;
            let (s, c) = (order * TAU * k as f64 / 240.0).sin_cos();
            re += late * c / 120.0;
            im += late * s / 120.0;
        }
        let swing = re.hypot(im) / CLOCK_HZ as f64 * nominal * order;
        assert!((swing / 0.01 - 1.0).abs() < 0.06, "order {order}: {swing}");
    }
}

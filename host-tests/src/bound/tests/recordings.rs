//! The ideal estimator on the simulator's recordings: that these have the noise which the bound is for.

use quadcal_host::sim::Simulation;
use quadcal_host::twin::Noise;

use super::*;

/// Mean squared error of the ideal estimator on recordings of the simulator, over the bound's.
///
/// Sixty lines with errors as small as those of 2500: an error's product with what the speed is off its nominal is left out by the
/// linear model, though not by physics.
fn on_recordings(scenario: Scenario, every: bool, seeds: std::ops::Range<u64>) -> f64 {
    let problem = problem(scenario, 60, 240, every);
    let gls = Gls::new(problem.clone()).unwrap();
    let expected: f64 = gls.variances().iter().sum();
    let runs = (seeds.end - seeds.start) as f64;
    let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    let mut power = 0.0;
    for seed in seeds {
        let small = Rig {
            scenario,
            lines: 2500,
        }
        .twins(seed);
        let mut truth = Vec::new();
        let mut deviations = Vec::new();
        let twins = Rig {
            scenario,
            lines: 60,
        }
        .twins(seed);
        for ((mut twin, small), pass) in twins.into_iter().zip(small).zip(&problem.passes) {
            twin.errors = small.errors;
            // Steps of noise ten times longer are still short against a step of this disc.
            let Some(Noise::SpeedWander {
                hold_s: Some(hold_s),
                ..
            }) = &mut twin.noise
            else {
                unreachable!("open-loop rigs wander");
            };
            *hold_s *= 10.0;
            let simulation = Simulation::new(&twin).unwrap();
            truth = simulation.true_errors();
            // The estimator solves no order at half the edges: it is taken off.
            let alternating = (0..240).map(|k| sign(k) * truth[k]).sum::<f64>() / 240.0;
            let times = anywhere::record(simulation).times;
            let edges = times.iter().take(240 * pass.turns).enumerate();
            let deviation = edges.map(|(i, ticks)| {
                let time = (ticks - times[0]) as f64 / anywhere::CLOCK_HZ as f64;
                let nominal = pass.from_rad_s * time + 0.5 * pass.rate * time * time;
                TAU * i as f64 / 240.0 - nominal - sign(i) * alternating
            });
            deviations.push(deviation.collect());
        }
        for (i, [a, b]) in gls.estimate(&deviations).into_iter().enumerate() {
            let (mut re, mut im) = (0.0, 0.0);
            for (k, e) in truth.iter().enumerate() {
                let (sin, cos) = (TAU * ((i + 1) * k) as f64 / 240.0).sin_cos();
                re += e * cos / 120.0;
                im += e * sin / 120.0;
            }
            power += ((a - re).powi(2) + (b - im).powi(2)) / 2.0 / runs;
        }
    }
    power / expected
}

#[test]
fn the_estimator_reaches_the_bound_on_recordings_of_the_simulator() {
    // Order 1 makes most of it, with two numbers a run: the limits are 2.5 standard errors.
    for (scenario, every, seeds, limit) in [
        (Scenario::OneSpeed, false, 0..40, 0.4),
        (Scenario::TwoSpeeds, true, 0..40, 0.4),
        (Scenario::Ramp, true, 0..12, 0.73),
    ] {
        let ratio = on_recordings(scenario, every, seeds);

        assert!((ratio - 1.0).abs() < limit, "{scenario:?}: {ratio}");
    }
}

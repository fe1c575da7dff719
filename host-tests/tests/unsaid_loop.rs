//! A speed loop that nobody spoke of shows as a broad hump of low orders; a shaft that runs freely, disturbed or not, never does. On
//! seeds that nothing was tuned to.
#![allow(missing_docs)]

use quadcal_host::calibrate::{CalibrateOptions, learn, plan};
use quadcal_host::findings::{Findings, LoopSuspicion};
use quadcal_host::sim::Simulation;
use quadcal_host::survey::Survey;
use quadcal_host::twin::{Drive, Noise, Twin};
use quadcal_host_tests::anywhere::{Disturbance, Disturbed, Rig, Scenario, noise_density, record};

/// What is said of one recording by itself, of which nothing is declared.
fn suspicion(twin: &Twin) -> Option<LoopSuspicion> {
    let recorded = record(Simulation::new(twin).unwrap());
    let options = CalibrateOptions::default();
    let rows = || recorded.rows.iter().copied().map(Ok);
    let survey = Survey::of(recorded.header.clone(), rows()).unwrap();
    let plan = plan(&survey, &options).unwrap();
    Findings::of(&learn(survey, plan, rows(), &options).unwrap()).loop_suspicion
}

fn free_runs(lines: u32, seed: u64) -> Vec<Twin> {
    let disturbed = Disturbance::ALL.map(|by| Disturbed { by, lines }.twins(seed));
    let free = Scenario::ALL
        .into_iter()
        .filter(|s| *s != Scenario::SpeedLoop);
    let plain = free.map(|scenario| Rig { scenario, lines }.twins(seed));
    let mut twins: Vec<Twin> = disturbed.into_iter().chain(plain).flatten().collect();
    let quiet = twins.iter().cloned().map(|mut twin| {
        twin.noise = None;
        twin
    });
    let jittered = twins.iter().cloned().map(|mut twin| {
        twin.timer.jitter_s = 2e-7;
        twin
    });
    let more: Vec<Twin> = quiet.chain(jittered).collect();
    twins.extend(more);
    twins
}

#[test]
fn no_free_run_is_suspected() {
    for (lines, seeds) in [(60, 9_500..9_506), (360, 9_500..9_502)] {
        for seed in seeds {
            for (n, twin) in free_runs(lines, seed).iter().enumerate() {
                assert_eq!(suspicion(twin), None, "{lines} lines, seed {seed}, run {n}");
            }
        }
    }
}

#[test]
fn a_loop_that_nobody_spoke_of_is_suspected() {
    for (lines, r_min, hz) in [
        (60, 60.0, 10.0),
        (360, 60.0, 30.0),
        (360, 200.0, 100.0),
        (2500, 15.0, 100.0),
        (2500, 60.0, 100.0),
    ] {
        let scenario = Scenario::OneSpeedCogging;
        let mut twin = Rig { scenario, lines }.twins(9_506).remove(0);
        twin.drive = Drive::SpeedLoop {
            r_min,
            f_hz: 10_000.0,
            bandwidth_hz: Some(hz),
            kp_n_m_s: None,
            ki_n_m: None,
            timeout_s: None,
            limit_n_m: None,
        };
        twin.shaft.stiffness_n_m_s = 0.0;
        twin.noise = Some(Noise::White {
            psd_n2_m2_s: noise_density() * twin.shaft.inertia_kg_m2.powi(2),
            hold_s: Some(1e-4),
        });
        let hump = suspicion(&twin);
        assert!(
            hump.is_some(),
            "{lines} lines, {r_min} r/min, {hz} Hz: {hump:?}"
        );
    }
}

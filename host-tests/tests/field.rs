//! A simulated drive, calibrated over its port with the core's own estimator, committed, and started again from flash.

use quadcal::recalibrate::{Failure, Options, Stage};
use quadcal::wire::{Reply, Request};
use quadcal_host::sim::{Event, Simulation};
use quadcal_host::twin::{Duration, Encoder, Errors, Noise, Per, Position, Twin};
use quadcal_host_tests::field::{Field, Flash};

const LINES: u32 = 250;

/// The paper's rig with a tenth of its lines and ten times its errors, at four times its speed.
fn twin(seed: u64, turns: f64) -> Twin {
    let mut twin = Twin::paper();
    twin.seed = seed;
    twin.duration = Duration::Turns(turns);
    twin.encoder = Encoder::Quadrature {
        lines: LINES,
        index: true,
    };
    twin.errors = Errors {
        position: Some(Position::Uniform {
            amplitude_rad: 6.2832e-4,
            per: Per::Edge,
        }),
        width_a_rad: 1.2566e-3,
        width_b_rad: 1.1310e-3,
        quadrature_rad: 1.2566e-3,
        ..Errors::default()
    };
    twin.noise = Some(Noise::SpeedWander {
        rms_fraction: 1e-3,
        correlation_rad: Some(0.5),
        hold_s: None,
    });
    twin
}

/// RMS of what is left of the angle over some changes of level, about its mean.
fn error(field: &mut Field, events: &mut impl Iterator<Item = Event>, count: u32) -> f64 {
    let passed = events.take(count as usize);
    let off: Vec<f64> = passed.filter_map(|event| field.pass(&event)).collect();
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    (off.iter().map(|off| (off - mean).powi(2)).sum::<f64>() / off.len() as f64).sqrt()
}

#[test]
fn a_drive_learns_by_command_and_starts_again_with_what_it_learned() {
    for seed in 1..=3 {
        let flash = Flash::default();
        let mut field = Field::new(&flash, LINES);
        let mut events = Simulation::new(&twin(seed, 60.0)).unwrap();
        let turn = 4 * LINES + 2;
        let raw = error(&mut field, &mut events, 3 * turn);
        let options = Options {
            turns: 16,
            ..Options::default()
        };
        assert_eq!(field.demand(&Request::Start(options)), Reply::Done);
        let mut learning = 0.0_f64;
        while !matches!(
            field.device.stage(),
            Stage::ReadyToCommit | Stage::Failed(_)
        ) {
            learning = learning.max(error(&mut field, &mut events, turn));
        }
        assert_eq!(field.device.stage(), Stage::ReadyToCommit);
        // The encoder runs on as before all the while.
        assert!((learning / raw - 1.0).abs() < 0.1, "{learning} {raw}");
        let Reply::Preview(Some(figures)) = field.ask(&Request::Preview) else {
            panic!("no preview")
        };
        let Reply::Result(Some(learned)) = field.ask(&Request::Result) else {
            panic!("no result")
        };
        println!("{figures:?}\n{learned:?}");
        assert!(figures.better && figures.new.interval * 4 < figures.old.interval);
        assert_eq!(field.demand(&Request::Commit), Reply::Done);
        let _ = error(&mut field, &mut events, turn);
        assert_eq!(field.device.stage(), Stage::Done);
        let corrected = error(&mut field, &mut events, 3 * turn);
        drop(field);
        let mut restarted = Field::new(&flash, LINES);
        let mut events = Simulation::new(&twin(seed + 100, 6.0)).unwrap();
        // Another disc: its errors are not these.
        let other = error(&mut restarted, &mut events, 4 * turn);
        println!(
            "raw {raw:.2e}, corrected {corrected:.2e}, another disc with this table {other:.2e}"
        );
        assert!(corrected < raw / 10.0, "{corrected:.2e} {raw:.2e}");
        assert!(other > raw / 2.0);
    }
}

/// Starts a calibration and turns until it has come to its end.
fn calibrate(field: &mut Field, events: &mut impl Iterator<Item = Event>) -> Stage {
    let options = Options {
        turns: 16,
        ..Options::default()
    };
    assert_eq!(field.demand(&Request::Start(options)), Reply::Done);
    while !matches!(
        field.device.stage(),
        Stage::ReadyToCommit | Stage::Failed(_)
    ) {
        let _ = error(field, events, 4 * LINES);
    }
    field.device.stage()
}

#[test]
fn a_table_no_better_than_the_one_in_use_is_refused() {
    let turn = 4 * LINES + 2;
    let refused = (11..=30)
        .filter(|seed| {
            let mut field = Field::new(&Flash::default(), LINES);
            let mut events = Simulation::new(&twin(*seed, 100.0)).unwrap();
            assert_eq!(calibrate(&mut field, &mut events), Stage::ReadyToCommit);
            assert_eq!(field.demand(&Request::Commit), Reply::Done);
            let _ = error(&mut field, &mut events, turn);
            // The same encoder, learned again from as many turns.
            calibrate(&mut field, &mut events) == Stage::Failed(Failure::NotBetter)
        })
        .count();
    println!("{refused} of 20 refused");
    assert!(refused >= 18);
}

//! Core and reference on the same recordings.

use quadcal::decoder::{DecoderConfig, QuadratureDecoder};
use quadcal::estimate::{Anchor, Estimator};
use quadcal::shape::EncoderShape;
use quadcal::step::{Flags, Outcome};
use quadcal::units::RAD_PER_TURN32;
use quadcal_host::buffers::HeapBuffers;
use quadcal_host::sim::Simulation;
use quadcal_host::twin::{Drive, Duration, Errors, Noise, Ripple, Twin};

use super::estimate;
use crate::accuracy::{distance, table_rad};

/// The paper's shaft with a drive that holds its speed softly, torque ripple at the paper's orders and white torque noise: at
/// 15 r/min the swings and the 0.1 % wander of the table, the same torques at any other speed.
fn rig(r_min: f64, seed: u64) -> Twin {
    let ripple = |order, phase_rad, torque| Ripple {
        order,
        phase_rad,
        torque_n_m: Some(torque),
        speed_fraction: None,
    };
    let mut twin = Twin::paper();
    twin.seed = seed;
    twin.drive = Drive::Constant { r_min };
    twin.shaft.stiffness_n_m_s = 2.1e-4;
    twin.ripple = vec![
        ripple(5.0, 0.3, 1.33e-5),
        ripple(10.0, 1.1, 1.26e-5),
        ripple(15.0, 2.0, 0.93e-5),
    ];
    twin.noise = Some(Noise::White {
        psd_n2_m2_s: 1.55e-13,
        hold_s: None,
    });
    twin.duration = Duration::Turns(9.1);
    twin
}

/// What the decoder makes of a recording, and the crossing times from the first edge 0 on. Edges after which both channels are
/// high are stamped late by `delay` ticks.
fn record(twin: &Twin, delay: u64) -> (Vec<Outcome>, Vec<u64>) {
    let simulation = Simulation::new(twin).expect("the twin is valid");
    let mut decoder = QuadratureDecoder::new(DecoderConfig::new(2500)).expect("lines are in range");
    let outcomes: Vec<Outcome> = simulation
        .map(|event| {
            let mut row = event.row;
            if row.levels.0 & 3 == 3 {
                row.ticks += delay;
            }
            decoder.push(row)
        })
        .collect();
    let mut times = Vec::new();
    for outcome in &outcomes {
        if let Outcome::Step(step) = outcome
            && step.flags.contains(Flags::REFERENCED)
            && (!times.is_empty() || step.edge == 0)
        {
            times.push(step.ticks);
        }
    }
    (outcomes, times)
}

/// The slow rig's recording and the fast one's of the same encoder.
fn two_speeds(seed: u64, delay: u64) -> [(Vec<Outcome>, Vec<u64>); 2] {
    let slow = rig(15.0, seed);
    let mut fast = rig(600.0, seed + 1000);
    fast.errors = Errors {
        list_rad: Simulation::new(&slow)
            .expect("the twin is valid")
            .true_errors(),
        ..Errors::default()
    };
    [record(&slow, delay), record(&fast, delay)]
}

/// Feeds both with the recordings and compares all that they say.
fn check(recordings: &[(Vec<Outcome>, Vec<u64>)]) {
    let shape = EncoderShape::new(10_000, 4).expect("four classes");
    let mut estimator =
        Estimator::new(shape, Anchor::Index, HeapBuffers::new(10_000)).expect("buffers fit");
    for (outcomes, _) in recordings {
        for outcome in outcomes {
            estimator.push(outcome);
        }
        estimator.interrupt();
    }
    let solution = estimator.solve().expect("turns enough");
    let times: Vec<&[u64]> = recordings.iter().map(|(_, times)| &times[..]).collect();
    let reference = estimate(&times, 10_000, 4, 0);

    let standard_error = reference.standard_error;
    let off = distance(&table_rad(&solution), &reference.error) / standard_error;
    assert!(off < 0.01, "{off}");
    let own = f64::from(solution.standard_error()) * RAD_PER_TURN32 / standard_error;
    assert!((own - 1.0).abs() < 0.01, "{own}");
    for (index, &meant) in reference.weights.iter().enumerate() {
        let weight = f64::from(solution.order_weight(index + 1)) / f64::from(1 << 15);
        assert!(
            (weight - meant).abs() < 0.02,
            "{}: {weight} {meant}",
            index + 1
        );
    }
    for order in [5, 10, 15] {
        let mut torques = solution.torque_orders().iter();
        assert!(torques.any(|torque| torque.order == order) && solution.locked_orders().is_empty());
        assert!(reference.torques.contains(&order.into()) && reference.locked.is_empty());
    }
}

#[test]
fn core_and_reference_agree_on_two_speeds_in_either_order() {
    for seed in [41, 42] {
        let mut recordings = two_speeds(seed, 0);
        check(&recordings);
        recordings.reverse();
        check(&recordings);
    }
}

#[test]
fn a_delay_that_two_speeds_show_does_not_reach_the_reference() {
    let of = |delay| {
        let recordings = two_speeds(43, delay);
        estimate(
            &recordings.each_ref().map(|(_, times)| &times[..]),
            10_000,
            4,
            0,
        )
    };
    let (without, with) = (of(0), of(40));
    let off = distance(&with.error, &without.error) / without.standard_error;
    assert!(off < 0.01, "{off}");
}

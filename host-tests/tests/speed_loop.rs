//! The figures for a live speed loop of 100 Hz at 15 and 600 r/min.

use quadcal_host::free_run::Knowledge;
use quadcal_host_tests::accuracy::rms;
use quadcal_host_tests::speed_loop::{FAST, SLOW, record, sweep};

const SEEDS: std::ops::RangeInclusive<u64> = 1..=3;
const EXACT: Knowledge = Knowledge {
    gains_within: 0.0,
    phase: true,
};
const WITHIN_10_PERCENT: Knowledge = Knowledge {
    gains_within: 0.1,
    phase: true,
};

#[test]
fn gains_known_exactly_take_off_98_percent() {
    for seed in SEEDS {
        let run = record(seed, FAST, 0);
        assert!(run.left_as_is() > 1.0, "the loop hid nothing");
        let left = run.left_undone(run.off_by(1.0, 1.0), EXACT);
        assert!(left < 0.015, "seed {seed}: {left}");
        let run = record(seed, SLOW, 0);
        let left = run.left_undone(run.off_by(1.0, 1.0), EXACT);
        assert!(left < 0.04, "seed {seed}, orders above 40: {left}");
    }
}

#[test]
fn gains_known_within_10_percent_take_off_98_percent() {
    for (seed, kp, ki) in [(1, 1.1, 1.1), (2, 1.1, 0.9), (3, 0.9, 1.1), (4, 0.9, 0.9)] {
        let run = record(seed, FAST, 0);
        let plain = run.left_undone(run.off_by(kp, ki), EXACT);
        let left = run.left_undone(run.off_by(kp, ki), WITHIN_10_PERCENT);
        assert!(plain > 0.3, "seed {seed}: gains made no difference");
        assert!(left < 0.015, "seed {seed}: {left}");
        let run = record(seed, SLOW, 0);
        let left = run.left_undone(run.off_by(kp, ki), WITHIN_10_PERCENT);
        assert!(left < 0.07, "seed {seed}, orders above 40: {left}");
    }
}

#[test]
fn an_unknown_sample_time_is_found() {
    let run = record(5, FAST, 5_003);
    let unknown = Knowledge {
        phase: false,
        ..WITHIN_10_PERCENT
    };
    let left = run.left_undone(run.off_by(0.9, 1.1), unknown);
    assert!(left < 0.015, "{left}");
}

#[test]
fn a_recorded_torque_serves_as_well_as_the_gains() {
    let run = record(6, FAST, 0);
    let left = |at_edges, lsb, timed| {
        let steps = run.torque(at_edges, lsb);
        run.left_undone(run.torque_push(&steps, 1.0, timed), EXACT)
    };
    // At every change, and at edges only with the drive's sample rate known.
    for (at_edges, timed) in [(false, false), (true, true)] {
        let exact = left(at_edges, None, timed);
        assert!(exact < 0.015, "{exact}");
        // 12 bits over +-4 N m.
        let rounded = left(at_edges, Some(4.0 / 2048.0), timed);
        assert!(rounded < 0.12, "{rounded}");
    }
}

#[test]
fn drawn_gains_leave_what_the_standard_error_says() {
    let judged = sweep(61..=66);
    for run in &judged {
        assert!(run.left < 0.015 * run.raw, "{run:?}");
        assert!(run.left < 2.5 * run.standard_error, "{run:?}");
    }
    // Order 1 is most of it, so that single runs tell little.
    let ratios = judged.iter().map(|run| run.left / run.standard_error);
    let ratio = rms(&ratios.collect::<Vec<_>>());
    assert!((0.4..1.6).contains(&ratio), "{ratio}");
}

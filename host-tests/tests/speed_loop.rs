//! The figures for a live speed loop of 100 Hz at 15 and 600 r/min.

use quadcal_host::free_run::Knowledge;
use quadcal_host_tests::speed_loop::{FAST, SLOW, record};

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
fn gains_known_exactly_take_off_97_percent() {
    for seed in SEEDS {
        let run = record(seed, FAST, 0);
        assert!(run.left_as_is() > 1.0, "the loop hid nothing");
        let left = run.left_undone(run.off_by(1.0, 1.0), EXACT);
        assert!(left < 0.03, "seed {seed}: {left}");
        let run = record(seed, SLOW, 0);
        let left = run.left_undone(run.off_by(1.0, 1.0), EXACT);
        assert!(left < 0.05, "seed {seed}, orders above 40: {left}");
    }
}

#[test]
fn gains_known_within_10_percent_take_off_90_percent() {
    for (seed, kp, ki) in [(1, 1.1, 1.1), (2, 1.1, 0.9), (3, 0.9, 1.1), (4, 0.9, 0.9)] {
        let run = record(seed, FAST, 0);
        let plain = run.left_undone(run.off_by(kp, ki), EXACT);
        let left = run.left_undone(run.off_by(kp, ki), WITHIN_10_PERCENT);
        assert!(plain > 0.3, "seed {seed}: gains made no difference");
        assert!(left < 0.03, "seed {seed}: {left}");
        let run = record(seed, SLOW, 0);
        let left = run.left_undone(run.off_by(kp, ki), WITHIN_10_PERCENT);
        assert!(left < 0.15, "seed {seed}, orders above 40: {left}");
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
    assert!(left < 0.03, "{left}");
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
        assert!(exact < 0.03, "{exact}");
        // 12 bits over +-4 N m.
        let rounded = left(at_edges, Some(4.0 / 2048.0), timed);
        assert!(rounded < 0.2, "{rounded}");
    }
}

//! When an edge is stamped.

use quadcal_blind::capture::rows;
use quadcal_blind::effect::Effect;
use quadcal_blind::turning::turn;
use quadcal_host::twin::{CaptureLatency, ChannelSkew, EdgeDelay, RiseFall};

use crate::{CLOCK_HZ, agree, back_and_forth, ours, steady, theirs};

#[test]
fn delays_count_by_the_level_that_changes_in_reverse_too() {
    let delay = Effect::EdgeDelay {
        rise_s: [2e-5, 1e-5, 0.0],
        fall_s: [0.0, 3e-5, 0.0],
    };
    let skew = Effect::ChannelSkew {
        channel_s: [0.0, 2e-5, 0.0],
    };
    let both = |rise_s, fall_s| RiseFall { rise_s, fall_s };
    for rig in [steady(), back_and_forth()] {
        agree(&rig, std::slice::from_ref(&delay), |twin| {
            twin.edge_delay = Some(EdgeDelay {
                a: both(2e-5, 0.0),
                b: both(1e-5, 3e-5),
                c: RiseFall::default(),
            });
        });
        agree(&rig, std::slice::from_ref(&skew), |twin| {
            twin.channel_skew = Some(ChannelSkew {
                b_s: 2e-5,
                ..ChannelSkew::default()
            });
        });
    }
}

#[test]
fn a_task_blocks_captures_at_the_same_times() {
    let task = Effect::CaptureTask {
        task_hz: 1000.0,
        busy_s: 5e-5,
        phase_s: 3e-4,
    };
    agree(&steady(), &[task], |twin| {
        twin.capture_latency = Some(CaptureLatency {
            mean_s: None,
            task_hz: Some(1000.0),
            busy_s: Some(5e-5),
            phase_s: Some(3e-4),
        });
    });
}

/// Mean and RMS about it of how much later than without noise edges are stamped, s.
fn late(with: &[(u64, u8)], without: &[(u64, u8)]) -> (f64, f64) {
    let pairs = with.iter().zip(without);
    let each: Vec<f64> = pairs
        .map(|(a, b)| (a.0 as f64 - b.0 as f64) / CLOCK_HZ as f64)
        .collect();
    let count = each.len() as f64;
    let mean = each.iter().sum::<f64>() / count;
    let square = each.iter().map(|late| (late - mean).powi(2)).sum::<f64>() / count;
    (mean, square.sqrt())
}

#[test]
fn jitter_adds_to_what_the_twin_has_square_on_square() {
    let mut rig = steady();
    (rig.jitter_s, rig.noise_known) = (3e-7, true);
    let jitter = [Effect::TimestampJitter { jitter_s: 4e-7 }];
    let (with, _) = rows(&turn(&rig, &jitter, Some(5)), &rig, &jitter, 5);
    let even = ours(&steady(), &[]);
    let (_, ours) = late(&with, &even);
    let (_, theirs) = late(&theirs(&rig, |twin| twin.timer.jitter_s = 5e-7), &even);
    assert!((ours / 5e-7 - 1.0).abs() < 0.05, "{ours:e}");
    assert!((theirs / 5e-7 - 1.0).abs() < 0.05, "{theirs:e}");
}

#[test]
fn latency_is_exponential_with_the_same_mean() {
    let (mean_s, rig) = (2e-6, steady());
    let latency = [Effect::CaptureLatency { mean_s }];
    let even = ours(&rig, &[]);
    let theirs = theirs(&rig, |twin| {
        twin.capture_latency = Some(CaptureLatency {
            mean_s: Some(mean_s),
            ..CaptureLatency::default()
        });
    });
    for rows in [ours(&rig, &latency), theirs] {
        let (mean, rms) = late(&rows, &even);
        assert!((mean / mean_s - 1.0).abs() < 0.1, "{mean:e}");
        assert!((rms / mean_s - 1.0).abs() < 0.15, "{rms:e}");
    }
}

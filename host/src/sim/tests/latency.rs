//! Captures that come late.

use super::*;
use crate::twin::CaptureLatency;

fn late(twin: &Twin) -> Vec<(Event, f64)> {
    let events = Simulation::new(twin).unwrap();
    let clock = twin.timer.clock_hz as f64;
    events
        .map(|event| (event, event.row.ticks as f64 / clock - event.truth.time_s))
        .collect()
}

/// A slow shaft and a fast clock: no capture meets the next.
fn clear() -> Twin {
    let mut twin = plain(6.0, 2.0);
    twin.timer.clock_hz = 1_000_000_000;
    twin
}

#[test]
fn an_interrupt_s_latency_is_exponential_and_moves_nothing_else() {
    let mut twin = clear();
    twin.capture_latency = Some(CaptureLatency {
        mean_s: Some(5e-6),
        ..CaptureLatency::default()
    });
    let found: Vec<f64> = late(&twin).iter().map(|late| late.1 + 0.5e-9).collect();
    let count = found.len() as f64;
    let mean = found.iter().sum::<f64>() / count;
    let moment = |power: i32| {
        let sum: f64 = found.iter().map(|late| (late - mean).powi(power)).sum();
        sum / count
    };
    // 2e4 samples: the mean to 0.7 %, the deviation to 1 %, the skewness 2 to 0.14 or so.
    assert!((mean / 5e-6 - 1.0).abs() < 0.03, "{mean:e}");
    let deviation = moment(2).sqrt();
    assert!((deviation / 5e-6 - 1.0).abs() < 0.05, "{deviation:e}");
    let skewness = moment(3) / deviation.powi(3);
    assert!((skewness - 2.0).abs() < 0.6, "{skewness}");
    assert!(found.iter().all(|late| *late > -1e-9));
    let plain = clear();
    let truths = |twin: &Twin| -> Vec<Truth> {
        Simulation::new(twin)
            .unwrap()
            .map(|event| event.truth)
            .collect()
    };
    assert!(truths(&twin) == truths(&plain));
}

#[test]
fn edges_in_a_task_s_busy_time_are_stamped_at_its_end() {
    let mut twin = clear();
    twin.capture_latency = Some(CaptureLatency {
        mean_s: None,
        task_hz: Some(707.0),
        busy_s: Some(1e-4),
        phase_s: Some(3e-4),
    });
    let mut held = 0;
    for (event, late) in late(&twin) {
        let since = (event.truth.time_s - 3e-4) * 707.0;
        let within = (since - since.floor()) / 707.0;
        let expected = if since > 0.0 && within < 1e-4 {
            held += 1;
            1e-4 - within
        } else {
            0.0
        };
        assert!((late - expected).abs() < 2e-9, "{event:?}");
    }
    // 7 % of 20,005 edges.
    assert!((1200..1600).contains(&held), "{held}");
}

#[test]
fn edges_that_one_busy_time_holds_stay_in_order() {
    let mut twin = plain(600.0, 2.0);
    twin.capture_latency = Some(CaptureLatency {
        mean_s: None,
        task_hz: Some(1000.0),
        busy_s: Some(5e-4),
        phase_s: None,
    });
    let events: Vec<Event> = Simulation::new(&twin).unwrap().collect();
    let plain: Vec<Event> = Simulation::new(&plain(600.0, 2.0)).unwrap().collect();
    assert!(events.windows(2).all(|w| w[0].row.ticks <= w[1].row.ticks));
    assert!(
        events
            .iter()
            .map(|e| e.row.levels)
            .eq(plain.iter().map(|e| e.row.levels))
    );
}

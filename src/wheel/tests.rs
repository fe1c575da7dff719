//! Wheels with and without missing teeth, turning at changing speed.

use super::*;
use crate::edge::Levels;
use proptest::prelude::*;
use std::vec::Vec;

fn sample(ticks: u64, a: bool) -> Sample {
    Sample {
        ticks,
        levels: Levels(u8::from(a)),
    }
}

/// Edges of `turns` turns with their slots, starting at tooth `from`, each pitch `ratio` times the one before.
fn edges(config: WheelConfig, from: u32, turns: u32, ratio: f64) -> Vec<(Sample, u32)> {
    let present = config.teeth - u32::from(config.missing);
    let (mut time, mut pitch) = (1e4, 10_000.0);
    let mut edges = Vec::new();
    for tooth in from..from + turns * config.teeth {
        let slot = tooth % config.teeth;
        if slot < present && config.both_edges {
            edges.push((sample(time as u64, true), 2 * slot));
            edges.push((sample((time + 0.4 * pitch) as u64, false), 2 * slot + 1));
        } else if slot < present {
            edges.push((sample(time as u64, true), slot));
        }
        time += pitch;
        pitch *= ratio;
    }
    edges
}

proptest! {
    #[test]
    fn the_gap_is_found_and_slots_stay_right(
        teeth in 12u32..64, missing in 1u16..3, both_edges: bool, from in 0u32..64, ratio in 0.99..1.01f64
    ) {
        let config = WheelConfig { missing, both_edges, ..WheelConfig::new(teeth) };
        let mut decoder = WheelDecoder::new(config).unwrap();
        let mut found = false;
        for (i, (sample, slot)) in edges(config, from, 5, ratio).into_iter().enumerate() {
            let step = decoder.push(sample).step().unwrap();
            // A gap before the second pitch has no measure yet.
            found |= step.flags.contains(Flags::INDEX);
            if found {
                prop_assert_eq!(step.edge, slot);
                prop_assert_eq!(step.flags.contains(Flags::INDEX), slot == 0);
                prop_assert_eq!(step.resync, 0);
            }
            prop_assert!(found || i < 4 * teeth as usize);
        }
        prop_assert_eq!(decoder.faults().total(), 0);
    }

    #[test]
    fn a_lost_tooth_is_booked_at_the_gap(
        teeth in 16u32..64, both_edges: bool, drop in 0usize..10, ratio in 0.999..1.001f64
    ) {
        let config = WheelConfig { missing: 2, both_edges, ..WheelConfig::new(teeth) };
        let mut edges = edges(config, 0, 5, ratio);
        let each = if both_edges { 2 } else { 1 };
        let at = each * (2 * (teeth as usize - 2) + 2 + drop);
        edges.drain(at..at + each);
        let mut decoder = WheelDecoder::new(config).unwrap();
        let mut flagged = false;
        for (sample, slot) in &edges {
            let step = decoder.push(*sample).step().unwrap();
            flagged |= step.flags.contains(Flags::TURN_SUSPECT);
            if *slot == 0 && step.flags.contains(Flags::REFERENCED) {
                prop_assert_eq!(step.edge, 0);
            }
        }
        prop_assert!(flagged && !decoder.is_uncertain());
        prop_assert_eq!(decoder.faults().lost, each as u32);
    }

    #[test]
    fn arbitrary_samples_stay_within_the_turn(
        rows in prop::collection::vec((0u64..1 << 34, any::<bool>()), 1..300),
        teeth in 8u32..20, missing in 0u16..4, both_edges: bool
    ) {
        let config = WheelConfig { missing, both_edges, ..WheelConfig::new(teeth) };
        let mut decoder = WheelDecoder::new(config).unwrap();
        for (ticks, a) in rows {
            decoder.push(sample(ticks, a));
            prop_assert!(decoder.position() < decoder.slots());
        }
    }
}

#[test]
fn a_plain_wheel_counts_over_a_lost_pulse_and_is_suspect_for_a_turn() {
    let config = WheelConfig::new(6);
    let mut decoder = WheelDecoder::new(config).unwrap();
    let mut edges = edges(config, 0, 6, 1.001);
    edges.remove(15);
    let mut suspect = 0;
    for (sample, slot) in edges {
        let step = decoder.push(sample).step().unwrap();
        assert_eq!(step.edge, slot);
        suspect += u32::from(step.flags.contains(Flags::TURN_SUSPECT));
    }
    assert_eq!((decoder.faults().lost, suspect), (1, 6));
}

#[test]
fn a_short_pulse_is_left_out() {
    let config = WheelConfig::new(6);
    let mut decoder = WheelDecoder::new(config).unwrap();
    for k in 1..10 {
        decoder.push(sample(k * 1000, true));
    }
    assert_eq!(decoder.push(sample(9100, true)), Outcome::Idle);
    let step = decoder.push(sample(10_000, true)).step().unwrap();
    assert_eq!((step.interval, step.edge), (1000, 3));
    assert_eq!(decoder.faults().glitch, 1);
}

#[test]
fn wheels_that_cannot_be_are_refused() {
    let refused = |teeth, missing, glitch_gate| {
        let config = WheelConfig {
            missing,
            glitch_gate,
            ..WheelConfig::new(teeth)
        };
        WheelDecoder::new(config).unwrap_err()
    };
    assert_eq!(refused(0, 0, 3), SensorError::Slots);
    assert_eq!(refused(u32::MAX, 0, 3), SensorError::Slots);
    assert_eq!(refused(5, 2, 3), SensorError::Missing);
    assert_eq!(refused(60, 2, 32), SensorError::Gate);
}

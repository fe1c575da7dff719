//! Merging, levels and losses, on captures laid by hand.

pub(crate) mod shaft;
mod streams;
pub(crate) mod truth;

use std::vec;
use std::vec::Vec;

use super::*;
use crate::encoder::{Encoder, EncoderConfig};
use shaft::{Edge, LINES, Random, Shaft};
use streams::{SETTLE, Streams};

type Drained<const BITS: u32> = Captures<Streams<BITS>, BITS>;

fn drain<const BITS: u32>(captures: &mut Drained<BITS>) -> Vec<Event> {
    let mut events = Vec::new();
    captures.drain(|event| events.push(event));
    events
}

/// Drained twice at a standstill, so that the levels are known. Time is 1000 then.
fn ready<const BITS: u32>() -> Drained<BITS> {
    let mut captures = Captures::new(Streams::default());
    assert_eq!(drain(&mut captures), []);
    captures.source().ticks = 1000;
    let start = Sample {
        ticks: 0,
        levels: Levels(0),
    };
    assert_eq!(drain(&mut captures), [Event::Change(start)]);
    captures
}

fn at(ticks: u64, levels: u8) -> Event {
    Event::Change(Sample {
        ticks,
        levels: Levels(levels),
    })
}

/// Runs a shaft through the streams, drained every 1 to `period` ticks; what came out.
fn drained<const BITS: u32>(shaft: &Shaft, random: &mut Random, period: u64) -> Vec<Event> {
    let mut captures = ready::<BITS>();
    let mut events = Vec::new();
    let mut edges = shaft.edges.iter().peekable();
    while captures.source().ticks < shaft.ticks + 2 * period {
        let ticks = captures.source().ticks + random.within(1, period);
        let source = captures.source();
        while let Some(edge) = edges.next_if(|edge| edge.ticks <= ticks) {
            source.lay(edge.channel, edge.ticks);
            source.look.levels = Some(edge.levels);
        }
        source.ticks = ticks;
        events.extend(drain(&mut captures));
    }
    assert_eq!(captures.now(), captures.source().ticks);
    events
}

fn changes(edges: &[Edge]) -> Vec<Event> {
    edges
        .iter()
        .map(|edge| Event::Change(edge.sample()))
        .collect()
}

#[test]
fn three_streams_come_out_as_the_shaft_made_them() {
    for seed in 0..30 {
        let mut random = Random(seed);
        let mut shaft = Shaft::new(1000);
        shaft.wander(&mut random, 400, 300);
        let events = drained::<32>(&shaft, &mut random, 3000);
        assert_eq!(events, changes(&shaft.edges), "seed {seed}");
    }
}

#[test]
fn a_timer_that_wraps_between_two_captures_changes_nothing() {
    for seed in 0..30 {
        let mut random = Random(seed);
        let mut shaft = Shaft::new(1000);
        // 16 bits wrap every 200 edges or so; edges up to 20,000 ticks apart are drained in between.
        shaft.wander(&mut random, 1000, 300);
        shaft.wander(&mut random, 100, 15_000);
        assert!(shaft.ticks > 10 << 16);
        let events = drained::<16>(&shaft, &mut random, 30_000);
        assert_eq!(events, changes(&shaft.edges), "seed {seed}");
    }
}

#[test]
fn edges_of_two_channels_at_one_tick_go_on_in_the_direction_of_motion() {
    for (last, order) in [
        // A rose last: forward, so B rises, and then A falls.
        (vec![Channel::A], vec![3, 2]),
        // A rose and B rose: forward, so A falls first.
        (vec![Channel::A, Channel::B], vec![2, 0]),
        // B rose last, from (0, 0): in reverse, so A rises first.
        (vec![Channel::B], vec![3, 1]),
    ] {
        let mut captures = ready::<32>();
        let source = captures.source();
        let mut levels = 0;
        let mut expected = Vec::new();
        for (channel, ticks) in last.iter().zip([1100, 1200]) {
            source.lay(*channel, ticks);
            levels ^= channel.bit();
            expected.push(at(ticks, levels));
        }
        source.lay(Channel::B, 1300);
        source.lay(Channel::A, 1300);
        source.ticks = 2000;
        expected.extend(order.iter().map(|levels| at(1300, *levels)));
        assert_eq!(drain(&mut captures), expected);
    }
}

#[test]
fn captures_a_tick_apart_keep_their_order_though_it_turns_the_shaft_round() {
    let mut captures = ready::<32>();
    let source = captures.source();
    source.lay(Channel::A, 1100);
    source.lay(Channel::A, 1300);
    source.lay(Channel::B, 1301);
    source.ticks = 2000;
    let expected = [at(1100, 1), at(1300, 0), at(1301, 2)];
    assert_eq!(drain(&mut captures), expected);
}

#[test]
fn an_index_that_changes_together_with_an_edge_is_never_high_in_a_state_too_many() {
    let mut captures = ready::<32>();
    let source = captures.source();
    for (channel, ticks) in [
        (Channel::Z, 1100),
        (Channel::A, 1100),
        (Channel::Z, 1200),
        (Channel::B, 1200),
    ] {
        source.lay(channel, ticks);
    }
    source.ticks = 2000;
    let expected = [at(1100, 1), at(1100, 5), at(1200, 1), at(1200, 3)];
    assert_eq!(drain(&mut captures), expected);
}

#[test]
fn a_capture_waits_until_an_older_one_of_another_channel_has_had_time_to_come() {
    let mut captures = ready::<32>();
    let source = captures.source();
    source.lay(Channel::A, 1100);
    source.lay(Channel::A, 1305);
    source.look.levels = Some(Levels(2));
    source.ticks = 1304 + u64::from(SETTLE);
    assert_eq!(drain(&mut captures), [at(1100, 1)]);
    let source = captures.source();
    source.lay(Channel::B, 1304);
    source.ticks += 1;
    assert_eq!(drain(&mut captures), [at(1304, 3), at(1305, 2)]);
}

#[test]
fn a_lost_edge_that_nobody_tells_of_is_found_at_the_pins() {
    let mut captures = ready::<32>();
    let source = captures.source();
    // A rose and was captured; B rose and was not.
    source.lay(Channel::A, 1100);
    source.look.levels = Some(Levels(3));
    source.ticks = 2000;
    assert_eq!(drain(&mut captures), [at(1100, 1)]);
    let source = captures.source();
    source.lay(Channel::A, 2100);
    source.look.levels = Some(Levels(2));
    source.ticks = 3000;
    assert_eq!(drain(&mut captures), [at(2100, 0)]);
    let source = captures.source();
    source.lay(Channel::B, 3100);
    source.look.levels = Some(Levels(0));
    source.ticks = 4000;
    let missed = Event::Missed(Loss::Levels);
    assert_eq!(drain(&mut captures), [missed, at(3100, 0)]);
    for ticks in [5000, 6000] {
        captures.source().ticks = ticks;
        assert_eq!(drain(&mut captures), []);
    }
    assert_eq!(captures.missed(), 1);
}

#[test]
fn a_pulse_that_the_filter_swallows_may_be_seen_at_the_pins_now_and_then() {
    let mut captures = ready::<32>();
    for look in 2..20 {
        let pulse = look % 3 != 0;
        captures.source().look.levels = Some(Levels(u8::from(pulse) << (look % 3)));
        captures.source().ticks = 1000 * look;
        assert_eq!(drain(&mut captures), []);
    }
    assert_eq!(captures.missed(), 0);
}

#[test]
fn pins_that_were_read_next_to_an_edge_prove_nothing() {
    let settle = u64::from(SETTLE);
    // The capture of an edge that the pins show already comes up to the settling time later, or the pins were read before it.
    for (captured, shown) in [
        (2000 + settle, 1),
        (2000, 1),
        (2000, 0),
        (2000 - settle + 1, 0),
    ] {
        let mut captures = ready::<32>();
        let source = captures.source();
        if captured <= 2000 {
            source.lay(Channel::A, captured);
        }
        source.look.levels = Some(Levels(shown));
        source.ticks = 2000;
        assert_eq!(drain(&mut captures), []);
        let source = captures.source();
        if captured > 2000 {
            source.lay(Channel::A, captured);
        }
        source.look.levels = Some(Levels(1));
        source.ticks = 3000;
        assert_eq!(drain(&mut captures), [at(captured, 1)]);
        captures.source().ticks = 4000;
        assert_eq!(drain(&mut captures), []);
    }
}

#[test]
fn pins_that_could_not_be_read_are_not_held_against_anything() {
    let mut captures = ready::<32>();
    captures.source().look.levels = None;
    captures.source().lay(Channel::A, 1100);
    captures.source().ticks = 2000;
    assert_eq!(drain(&mut captures), [at(1100, 1)]);
    captures.source().look.levels = Some(Levels(1));
    for ticks in [3000, 4000] {
        captures.source().ticks = ticks;
        assert_eq!(drain(&mut captures), []);
    }
}

#[test]
fn a_batch_with_an_over_capture_is_left_out_and_what_follows_is_right() {
    let mut captures = ready::<32>();
    let source = captures.source();
    source.lay(Channel::A, 1100);
    source.lay(Channel::B, 1200);
    source.look.levels = Some(Levels(2));
    source.look.over_captured = Levels::A;
    source.ticks = 2000;
    let told = [Event::Missed(Loss::OverCapture)];
    assert_eq!(drain(&mut captures), told);
    // The flag may have come after the pins were read: they are those of the next look.
    let source = captures.source();
    source.lay(Channel::B, 2100);
    source.look.levels = Some(Levels(0));
    source.ticks = 3000;
    assert_eq!(drain(&mut captures), []);
    let source = captures.source();
    source.lay(Channel::B, 3100);
    source.lay(Channel::A, 3200);
    source.look.levels = Some(Levels(3));
    source.ticks = 4000;
    assert_eq!(drain(&mut captures), [at(3100, 2), at(3200, 3)]);
    captures.source().ticks = 5000;
    assert_eq!(drain(&mut captures), []);
}

#[test]
fn after_an_over_capture_nothing_is_given_while_edges_stand_next_to_every_look() {
    let mut captures = ready::<32>();
    captures.source().look.over_captured = Levels::B;
    captures.source().ticks = 2000;
    assert_eq!(drain(&mut captures).len(), 1);
    let mut levels = 0;
    for look in 3..8 {
        let source = captures.source();
        // Just after the last look, and enough of A, whose level stays known.
        source.lay(Channel::B, 1000 * (look - 1) + 1);
        source.lay(Channel::A, 1000 * (look - 1) + 500);
        levels ^= 3;
        source.look.levels = Some(Levels(levels));
        source.ticks = 1000 * look;
        assert_eq!(drain(&mut captures), []);
    }
    let source = captures.source();
    source.lay(Channel::A, 7500);
    source.ticks = 8000;
    assert_eq!(drain(&mut captures), [at(7500, levels ^ 1)]);
}

#[test]
fn a_noisy_index_line_costs_no_edge_of_a_and_b() {
    let mut captures = ready::<32>();
    let source = captures.source();
    source.lay(Channel::Z, 1050);
    source.lay(Channel::A, 1100);
    source.look.over_captured = Levels::Z;
    source.look.levels = Some(Levels(5));
    source.ticks = 2000;
    let told = Event::Missed(Loss::OverCapture);
    assert_eq!(drain(&mut captures), [told, at(1100, 1)]);
    let source = captures.source();
    source.lay(Channel::B, 2100);
    source.look.levels = Some(Levels(7));
    source.ticks = 3000;
    assert_eq!(drain(&mut captures), [at(2100, 3)]);
    let source = captures.source();
    source.lay(Channel::A, 3100);
    source.lay(Channel::Z, 3200);
    source.look.levels = Some(Levels(2));
    source.ticks = 4000;
    assert_eq!(drain(&mut captures), [at(3100, 6), at(3200, 2)]);
}

#[test]
fn an_overrun_is_told_and_levels_come_from_the_look_after_it() {
    let mut captures = ready::<32>();
    let source = captures.source();
    source.lay(Channel::A, 1100);
    source.look.overrun = Levels::B;
    // Wrong, as an edge was taken away with the overrun.
    source.look.levels = Some(Levels(0));
    source.ticks = 2000;
    assert_eq!(drain(&mut captures), [Event::Missed(Loss::Overrun)]);
    let source = captures.source();
    source.look.levels = Some(Levels(3));
    source.ticks = 3000;
    assert_eq!(drain(&mut captures), []);
    let source = captures.source();
    source.lay(Channel::A, 3500);
    source.look.levels = Some(Levels(2));
    source.ticks = 4000;
    assert_eq!(drain(&mut captures), [at(3500, 2)]);
}

#[test]
fn memory_that_is_counted_but_not_written_yet_is_read_at_the_next_look() {
    let mut captures = ready::<32>();
    let source = captures.source();
    source.lay(Channel::B, 1100);
    // What stood there a lap ago, for a capture made at 1995.
    source.lay(Channel::A, 300);
    source.look.levels = Some(Levels(3));
    source.ticks = 2000;
    assert_eq!(drain(&mut captures), [at(1100, 2)]);
    let source = captures.source();
    source.streams[0][0] = 1995;
    source.ticks = 3000;
    assert_eq!(drain(&mut captures), [at(1995, 3)]);
    captures.source().ticks = 4000;
    assert_eq!(drain(&mut captures), []);
}

#[test]
fn a_capture_that_comes_too_late_to_be_put_in_order_is_an_overrun() {
    let mut captures = ready::<32>();
    captures.source().ticks = 2000;
    assert_eq!(drain(&mut captures), []);
    let source = captures.source();
    source.lay(Channel::A, 1900);
    source.look.levels = Some(Levels(1));
    source.ticks = 3000;
    assert_eq!(drain(&mut captures), []);
    captures.source().ticks = 4000;
    assert_eq!(drain(&mut captures), [Event::Missed(Loss::Overrun)]);
    let source = captures.source();
    source.lay(Channel::B, 4500);
    source.look.levels = Some(Levels(3));
    source.ticks = 5000;
    assert_eq!(drain(&mut captures), [at(4500, 3)]);
}

#[test]
fn what_is_missing_reaches_flags_and_faults_and_the_index_ends_the_doubt() {
    let mut shaft = Shaft::new(1000);
    shaft.cruise(10 * 4 * LINES, 500);
    let turn = 4 * LINES as usize;
    let mut encoder: Encoder = Encoder::new(EncoderConfig::new(LINES, 100_000), None).unwrap();
    let mut uncertain = Vec::new();
    for (k, edge) in shaft.edges.iter().enumerate() {
        if k == 3 * turn {
            let (last, ticks) = (encoder.last(), edge.ticks - 1);
            let now = (encoder.now(ticks), encoder.speed_at(ticks));
            assert!(encoder.take(Event::Missed(Loss::Overrun)).is_none());
            // What is known of the edges before stays.
            assert_eq!(encoder.last(), last);
            assert_eq!((encoder.now(ticks), encoder.speed_at(ticks)), now);
            assert!(encoder.decoder().is_uncertain());
        }
        if let Some(seen) = encoder.take(Event::Change(edge.sample())) {
            if seen.edge.flags.contains(crate::step::Flags::TURN_SUSPECT) {
                uncertain.push(k);
            }
            // Nothing was lost in truth, so angles stay right.
            let grid = f64::from(seen.edge.angle.0) / 2_f64.powi(32) * turn as f64;
            assert!((grid - grid.round()).abs() < 1e-6);
        }
    }
    // Up to the first index that comes eight edges later or more, and not beyond.
    assert!((8..=turn + 8).contains(&uncertain.len()), "{uncertain:?}");
    assert_eq!(uncertain[0], 3 * turn);
    assert_eq!(encoder.faults().missed, 1);
    assert_eq!(encoder.faults().total(), 1);
    assert!(!encoder.decoder().is_uncertain());
}

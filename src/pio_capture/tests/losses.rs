//! What goes wrong is told, and an angle is never wrong without that.

use super::model::WORDS;
use super::*;
use crate::capture::Loss;
use crate::capture::tests::truth::right_or_doubtful;

/// Cycles from one edge to the next.
const INTERVAL: u64 = 400;

/// A shaft in steady motion that is about to turn, and what the machine is to see of it.
fn cruising(seed: u64, bus: Bus) -> (Rig<Rp2040>, Shaft, Vec<Sample>) {
    let mut rig = Rig::new(RP2040_MAP, seed, bus);
    let mut shaft = rig.shaft();
    shaft.cruise(20 * 4 * LINES, INTERVAL);
    let samples = rig.turn(&shaft);
    (rig, shaft, samples)
}

/// Every gap in what was drained is told, between the samples where it is.
fn gaps_are_told(events: &[Event], samples: &[Sample]) {
    let mut next = Some(0);
    for event in events {
        match event {
            Event::Missed(_) => next = None,
            Event::Change(sample) => {
                let at = samples.iter().position(|other| other == sample);
                assert!(at.is_some() && (next.is_none() || at == next), "{sample:?}");
                next = at.map(|at| at + 1);
            }
        }
    }
}

#[test]
fn a_queue_without_room_is_an_overrun() {
    let mut found = 0;
    for seed in 0..40 {
        for edges in [5, 9, 12, 40] {
            let (mut rig, shaft, samples) = cruising(seed, BUS);
            // At any place in a turn: the queue may hold the index from before the loss.
            let from = shaft.edges[200].ticks + seed * INTERVAL * 5 / 6;
            rig.model().stalls.push((from, from + edges * INTERVAL));
            // Looks fall into the stall, between its end and the queue's, and after both.
            rig.drain_until(shaft.ticks + 2000, [200, 1500, 6000][seed as usize % 3]);
            let (missed, doubtful, sure) = right_or_doubtful(&rig.events, &samples);
            let lost = samples.len() + missed.len() - rig.events.len();
            // Eight words have room: five edges and the index.
            assert!(lost == 0 || edges > 5, "{seed}: {lost}");
            gaps_are_told(&rig.events, &samples);
            // Words that come later than the driver says are told too, though none is lost.
            let told = missed.contains(&Loss::Overrun);
            assert!(lost == 0 || told, "{seed} {edges}: {missed:?}");
            // In doubt for two turns of twenty at most, or as long as the stall.
            assert!(sure > 16 * 4 * LINES, "{seed} {edges}: {doubtful} {sure}");
            found += usize::from(lost > 0 && told);
        }
    }
    assert!(found > 80, "{found}");
}

#[test]
fn memory_that_dma_has_gone_round_in_is_an_overrun_whatever_the_number_of_laps() {
    // Words come every edge, and two more each turn.
    let lap = INTERVAL * WORDS as u64 * 32 / 34;
    for late in [
        lap / 2 + 2000,
        lap - 800,
        lap,
        lap + 800,
        2 * lap,
        2 * lap + 800,
    ] {
        for seed in 0..6 {
            let (mut rig, shaft, samples) = cruising(seed, BUS);
            rig.drain_until(shaft.edges[150].ticks + seed * 111, 3000);
            let now = rig.model().now;
            rig.model().advance(now + late);
            rig.drain_until(shaft.ticks + 2000, 3000);
            let (missed, doubtful, sure) = right_or_doubtful(&rig.events, &samples);
            assert!(missed.contains(&Loss::Overrun), "{late} {seed}: {missed:?}");
            assert!(missed.len() <= 2, "{late} {seed}: {missed:?}");
            assert!(
                doubtful > 8 && sure > 12 * 4 * LINES,
                "{late}: {doubtful} {sure}"
            );
        }
    }
}

#[test]
fn machines_that_someone_stops_are_an_overrun_at_every_drain_and_time_stands() {
    let (mut rig, shaft, _) = cruising(1, BUS);
    rig.drain_until(shaft.edges[100].ticks, 3000);
    for machine in &mut rig.model().machines {
        machine.on = false;
    }
    rig.events.clear();
    let time = rig.captures.now();
    for _ in 0..5 {
        let now = rig.model().now;
        rig.model().advance(now + 5000);
        rig.drain();
        assert_eq!(rig.captures.now(), time);
    }
    assert_eq!(rig.events, [Event::Missed(Loss::Overrun); 5]);
    // They go on: questions that were given up are not answered in the place of new ones.
    let gap = rig.model().now - rig.model().zero;
    for machine in &mut rig.model().machines {
        machine.on = true;
    }
    let now = rig.model().now;
    rig.model().advance(now + 300);
    rig.drain();
    let before = rig.captures.now();
    let now = rig.model().now;
    rig.model().advance(now + 6000);
    let later = rig.captures.now();
    assert!(
        (1000..1030).contains(&(later - before)),
        "{}",
        later - before
    );
    assert!(later < gap / 6 + 1500);
}

#[test]
fn a_drain_that_is_interrupted_anywhere_loses_nothing() {
    let bus = Bus {
        interrupt: 1500,
        ..BUS
    };
    for seed in 0..20 {
        let (mut rig, shaft, samples) = cruising(seed, bus);
        rig.drain_until(shaft.ticks + 9000, 1500);
        assert!(rig.events == changes(&samples), "seed {seed}");
    }
}

#[test]
fn a_word_that_does_not_reach_memory_is_found_at_the_pins_when_the_shaft_stops() {
    for seed in 0..20 {
        let (mut rig, shaft, samples) = cruising(seed, BUS);
        // The first word was that of the start.
        rig.model().dropped = Some(samples.len());
        rig.drain_until(shaft.ticks + 9000, 3000);
        let mut expected = changes(&samples);
        expected.pop();
        expected.push(Event::Missed(Loss::Levels));
        assert_eq!(rig.events, expected, "seed {seed}");
    }
}

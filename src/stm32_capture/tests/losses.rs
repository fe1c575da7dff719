//! What goes wrong is told, and an angle is never wrong without that.

use super::model::LATCHES;
use super::*;
use crate::capture::Loss;
use crate::capture::tests::truth;

/// What was missed, and how many samples came in doubt and without.
fn right_or_doubtful(rig: &Rig<F405>, edges: &[Edge]) -> (Vec<Loss>, u32, u32) {
    let samples: Vec<_> = edges.iter().map(Edge::sample).collect();
    truth::right_or_doubtful(&rig.events, &samples)
}

/// A shaft in steady motion, drained every `period` ticks at most, with what `disturb` does to the model.
fn disturbed(
    seed: u64,
    period: u64,
    disturb: impl FnOnce(&mut Model, u64),
) -> (Rig<F405>, Vec<Edge>) {
    let mut rig = Rig::new(F405_MAP, seed, BUS, Filter::of_ticks(8));
    let mut shaft = rig.shaft();
    let begin = shaft.ticks;
    shaft.cruise(20 * 4 * LINES, 400);
    let edges = rig.turn(&shaft);
    disturb(rig.model(), begin);
    rig.drain_until(shaft.ticks + 1000, period);
    (rig, edges)
}

#[test]
fn a_bus_that_stalls_over_two_edges_of_a_channel_is_an_over_capture() {
    for seed in 0..60 {
        let (rig, edges) = disturbed(seed, 3000, |model, begin| {
            // Between 800 and 2500 ticks: two edges of a channel at least, in turn 5 or so.
            let from = begin + 5 * 32 * 400 + seed * 37;
            model.stalls.push((from, from + 900 + seed * 25));
        });
        let (missed, doubtful, sure) = right_or_doubtful(&rig, &edges);
        assert!(
            missed.contains(&Loss::OverCapture),
            "seed {seed}: {missed:?}"
        );
        assert!(missed.len() <= 4, "seed {seed}: {missed:?}");
        // In doubt for two turns of twenty at most.
        assert!(
            doubtful > 8 && sure > 17 * 4 * LINES,
            "seed {seed}: {doubtful} {sure}"
        );
    }
}

#[test]
fn memory_that_dma_has_gone_round_in_is_an_overrun_whatever_the_number_of_laps() {
    // Edges of a channel come every 800 ticks.
    let lap = 800 * LATCHES as u64;
    for late in [
        lap / 2 + 2000,
        lap - 800,
        lap,
        lap + 800,
        lap * 3 / 2,
        2 * lap,
        2 * lap + 800,
    ] {
        for seed in 0..8 {
            let mut rig = Rig::<F405>::new(F405_MAP, seed, BUS, Filter::of_ticks(8));
            let mut shaft = rig.shaft();
            let begin = shaft.ticks;
            shaft.cruise(20 * 4 * LINES, 400);
            let edges = rig.turn(&shaft);
            rig.drain_until(begin + 5 * 32 * 400 + seed * 111, 3000);
            let now = rig.model().now;
            rig.model().advance(now + late);
            rig.drain_until(shaft.ticks + 1000, 3000);
            let (missed, doubtful, sure) = right_or_doubtful(&rig, &edges);
            assert!(missed.contains(&Loss::Overrun), "{late} {seed}: {missed:?}");
            assert!(missed.len() <= 2, "{late} {seed}: {missed:?}");
            assert!(
                doubtful > 8 && sure > 5 * 4 * LINES,
                "{late}: {doubtful} {sure}"
            );
        }
    }
}

#[test]
fn a_capture_that_the_timer_misses_without_a_word_is_found_at_the_pins() {
    for seed in 0..60 {
        let (rig, edges) = disturbed(seed, 1500, |model, _| {
            model.deaf_at.push(200 + seed as usize);
        });
        let mut encoder = truth::encoder();
        let last = rig.events.iter().filter(|event| {
            encoder.take(**event);
            matches!(event, Event::Missed(Loss::Levels))
        });
        assert_eq!(last.count(), 1, "seed {seed}");
        // Twelve turns later all is well again.
        let mut truth = truth::encoder();
        for edge in &edges {
            truth.edge_at(edge.sample());
        }
        assert_eq!(encoder.decoder().position(), truth.decoder().position());
        assert!(!encoder.decoder().is_uncertain());
        assert_eq!(encoder.faults().missed, 1);
    }
}

#[test]
fn a_drain_that_is_interrupted_between_pins_and_counter_uses_no_pins() {
    let bus = Bus {
        interrupt: 1000,
        ..BUS
    };
    for seed in 0..40 {
        let mut rig = Rig::<F405>::new(F405_MAP, seed, bus, Filter::of_ticks(8));
        let mut shaft = rig.shaft();
        shaft.wander(&mut Random(seed), 400, 400);
        let edges = rig.turn(&shaft);
        rig.drain_until(shaft.ticks + 5000, 1500);
        let expected: Vec<_> = edges.iter().map(|e| Event::Change(e.sample())).collect();
        assert_eq!(rig.events, expected, "seed {seed}");
    }
}

#[test]
fn a_flag_that_comes_while_others_are_cleared_is_seen_at_the_next_look() {
    const CC2OF: u32 = 1 << 10;
    const CC3OF: u32 = 1 << 11;
    let mut rig = Rig::<F405>::new(F405_MAP, 1, BUS, Filter::NONE);
    rig.model().raised = CC2OF;
    rig.drain();
    assert_eq!(rig.events, []);
    rig.model().raised = CC3OF;
    for _ in 0..3 {
        rig.drain();
    }
    let told = Event::Missed(Loss::OverCapture);
    assert_eq!(rig.events, [told, told]);
}

//! The driver on a model of its registers, up to the encoder behind it.

mod losses;
mod model;

use std::vec::Vec;

use super::*;
use crate::capture::tests::shaft::{Edge, LINES, Random, Shaft};
use crate::capture::tests::truth::encoder;
use crate::capture::{Captures, Event};
use crate::edge::Levels;
use model::{BUS, Bus, F405_MAP, G4_MAP, Map, Model};

/// The driver behind a merger, with a model that has begun and levels that are known.
struct Rig<C> {
    captures: Captures<DmaCapture<Model, C>>,
    filter: Filter,
    random: Random,
    events: Vec<Event>,
}

impl<C: Chip> Rig<C> {
    fn new(map: Map, seed: u64, bus: Bus, filter: Filter) -> Self {
        let driver = DmaCapture::start(Model::new(map, seed, bus), filter).unwrap();
        let mut rig = Self {
            captures: Captures::new(driver),
            filter,
            random: Random(seed),
            events: Vec::new(),
        };
        // A few looks at a standstill, as some may be too long to read the pins in.
        for _ in 0..50 {
            let now = rig.model().now;
            rig.drain_until(now + 1, 4000);
        }
        let start = rig.events.pop();
        assert!(matches!(start, Some(Event::Change(sample)) if sample.levels == Shaft::START));
        assert_eq!(rig.events, []);
        rig
    }

    fn model(&mut self) -> &mut Model {
        self.captures.source().registers()
    }

    /// Lays a shaft's edges at the pins; its captures, in the counter's time.
    fn turn(&mut self, shaft: &Shaft) -> Vec<Edge> {
        let filter = self.filter.ticks();
        let model = self.model();
        let began = model.now - model.counted();
        let mut edges = model.turn(&shaft.edges, filter);
        for edge in &mut edges {
            edge.ticks -= began;
        }
        edges
    }

    fn drain(&mut self) {
        let events = &mut self.events;
        self.captures.drain(|event| events.push(event));
    }

    /// Drains every 1 to `period` ticks until a time.
    fn drain_until(&mut self, end: u64, period: u64) {
        while self.model().now < end {
            let now = self.model().now + self.random.within(1, period);
            self.model().advance(now);
            self.drain();
        }
    }

    /// A shaft that begins soon.
    fn shaft(&mut self) -> Shaft {
        Shaft::new(self.model().now + 500)
    }
}

fn edges_come_through<C: Chip>(map: Map, seed: u64, (interval, ticks, period): (u64, u32, u64)) {
    let mut rig = Rig::<C>::new(map, seed, BUS, Filter::of_ticks(ticks));
    let mut shaft = rig.shaft();
    let mut random = Random(seed ^ 0x5555);
    shaft.wander(&mut random, 500, interval);
    let edges = rig.turn(&shaft);
    // The last ones are drained after they have settled.
    rig.drain_until(shaft.ticks + 1000, period);
    assert_eq!(rig.model().misuse, [""; 0]);
    let (mut direct, mut drained) = (encoder(), encoder());
    let expected: Vec<_> = edges
        .iter()
        .map(|edge| direct.edge_at(edge.sample()))
        .collect();
    let got: Vec<_> = rig
        .events
        .iter()
        .map(|event| drained.take(*event))
        .collect();
    assert_eq!(got.len(), expected.len(), "seed {seed}");
    assert!(got == expected, "seed {seed}");
    assert_eq!(drained.faults(), direct.faults(), "seed {seed}");
    assert_eq!(drained.faults().missed, 0, "seed {seed}");
    assert!(drained.decoder().is_referenced());
}

#[test]
fn edges_through_timer_and_dma_are_those_fed_directly() {
    for seed in 0..40 {
        // A slow shaft, a fast one with filter and short looks, one that fills nearly half of the memory between two drains.
        for motion in [(3000, 200, 20_000), (200, 8, 700), (150, 4, 4000)] {
            edges_come_through::<F405>(F405_MAP, seed, motion);
            edges_come_through::<G4>(G4_MAP, seed, motion);
        }
    }
}

#[test]
fn pulses_shorter_than_the_filter_are_no_captures() {
    let mut rig = Rig::<F405>::new(F405_MAP, 1, BUS, Filter::of_ticks(32));
    let mut shaft = rig.shaft();
    shaft.cruise(40, 400);
    // A spike of 31 ticks on every edge's level, and one of 32 that passes.
    let mut edges = Vec::new();
    for (k, edge) in shaft.edges.iter().enumerate() {
        edges.push(*edge);
        let long = k == 20;
        let spike = |ticks, levels| Edge {
            ticks: edge.ticks + ticks,
            channel: edge.channel,
            levels,
        };
        let other = Levels(edge.levels.0 ^ edge.channel.bit());
        if edge.channel != crate::capture::Channel::Z {
            edges.push(spike(35, other));
            edges.push(spike(if long { 67 } else { 66 }, edge.levels));
        }
    }
    let plain = shaft.edges.len();
    shaft.edges = edges;
    let captured = rig.turn(&shaft);
    assert_eq!(captured.len(), plain + 2);
    rig.drain_until(shaft.ticks + 1000, 2000);
    let expected: Vec<_> = captured.iter().map(|e| Event::Change(e.sample())).collect();
    assert_eq!(rig.events, expected);
}

#[test]
fn the_counter_s_wrap_may_come_anywhere_between_edges_and_reads() {
    for seed in 0..40 {
        let mut rig = Rig::<F405>::new(F405_MAP, seed, BUS, Filter::of_ticks(8));
        // Half periods and less, as the contract has it.
        let near = (1 << 32) - 20_000 - seed * 97;
        for end in [1 << 30, 3 << 30, near] {
            rig.model().advance(end);
            rig.drain();
        }
        let mut shaft = rig.shaft();
        let mut random = Random(seed);
        shaft.wander(&mut random, 200, 200);
        let edges = rig.turn(&shaft);
        assert!(edges.first().unwrap().ticks < 1 << 32 && edges.last().unwrap().ticks > 1 << 32);
        while rig.model().now < shaft.ticks + 1000 {
            let now = rig.model().now;
            rig.drain_until(now + 1, 800);
            // The control loop's time goes on meanwhile.
            let counted = rig.model().counted();
            let time = rig.captures.now();
            assert!((counted..counted + 5).contains(&time), "{time} {counted}");
        }
        let expected: Vec<_> = edges.iter().map(|e| Event::Change(e.sample())).collect();
        assert_eq!(rig.events, expected, "seed {seed}");
    }
}

#[test]
fn edges_of_a_and_b_next_to_each_other_or_at_one_tick_keep_the_direction() {
    for forward in [true, false] {
        for gap in 0..4 {
            let mut rig = Rig::<F405>::new(F405_MAP, gap, BUS, Filter::of_ticks(4));
            let mut shaft = rig.shaft();
            for k in 0..200 {
                // The direction is known from the first edge on.
                shaft.step(forward, if k == 0 || k % 2 == 1 { 400 } else { gap });
            }
            shaft
                .edges
                .retain(|edge| edge.channel != crate::capture::Channel::Z);
            rig.turn(&shaft);
            rig.drain_until(shaft.ticks + 1000, 900);
            let mut encoder = encoder();
            let mut steps = 0;
            for event in &rig.events {
                let seen = encoder.take(*event).unwrap();
                let sign = if forward { 1 } else { -1 };
                assert!(steps == 0 || seen.edge.moved.0.signum() == sign);
                steps += 1;
            }
            assert_eq!((steps, encoder.faults().total()), (200, 0), "gap {gap}");
        }
    }
}

#[test]
fn a_timer_without_clock_and_dma_that_runs_on_are_told() {
    let mut model = Model::new(F405_MAP, 1, BUS);
    model.keeps_period = false;
    let started = DmaCapture::<_, F405>::start(model, Filter::NONE);
    assert_eq!(started.err(), Some(StartError::Timer));
    for on_g4 in [false, true] {
        let mut model = Model::new(if on_g4 { G4_MAP } else { F405_MAP }, 1, BUS);
        model.dma_stops = false;
        let error = if on_g4 {
            DmaCapture::<_, G4>::start(model, Filter::NONE).err()
        } else {
            DmaCapture::<_, F405>::start(model, Filter::NONE).err()
        };
        assert_eq!(error, Some(StartError::Dma));
    }
}

#[test]
fn filters_are_those_of_the_manual() {
    for (wanted, got) in [
        (0, 0),
        (1, 2),
        (8, 8),
        (9, 12),
        (33, 48),
        (256, 256),
        (900, 256),
    ] {
        assert_eq!(Filter::of_ticks(wanted).ticks(), got);
    }
    assert_eq!(Filter::of_ticks(256).code(), 15);
}

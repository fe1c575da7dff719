//! The driver and its program on a model of machines, queues and DMA, up to the encoder behind it. Edges are in cycles here, captures in
//! ticks.

mod listing;
mod losses;
mod model;

use std::vec::Vec;

use super::*;
use crate::capture::tests::shaft::{Edge, LINES, Random, Shaft};
use crate::capture::tests::truth::encoder;
use crate::capture::{Captures, Channel, Event};
use crate::edge::Sample;
use model::{BUS, Bus, Map, Model, RP2040_MAP, RP2350_MAP, SYNCHRONISER};

/// The first of the three pins.
const FIRST_PIN: u32 = 2;

/// The driver behind a merger, with a model that has begun and levels that are known.
struct Rig<C> {
    captures: Captures<PioCapture<Model, C>, BITS>,
    random: Random,
    events: Vec<Event>,
}

impl<C: Chip> Rig<C> {
    fn new(map: Map, seed: u64, bus: Bus) -> Self {
        let model = Model::new(map, seed, bus, FIRST_PIN);
        let driver = PioCapture::start(model, FIRST_PIN).unwrap();
        let mut rig = Self {
            captures: Captures::new(driver),
            random: Random(seed),
            events: Vec::new(),
        };
        let now = rig.model().now;
        rig.drain_until(now + 4000, 900);
        // The first look of machine 0 says where levels began.
        let start = Sample {
            ticks: 0,
            levels: Shaft::START,
        };
        assert_eq!(rig.events, [Event::Change(start)]);
        rig.events.clear();
        rig
    }

    fn model(&mut self) -> &mut Model {
        self.captures.source().registers()
    }

    /// Lays a shaft's edges at the pins; what the machine is to make of them.
    fn turn(&mut self, shaft: &Shaft) -> Vec<Sample> {
        self.model().turn(&shaft.edges);
        seen(&shaft.edges, self.model().zero)
    }

    fn drain(&mut self) {
        let events = &mut self.events;
        self.captures.drain(|event| events.push(event));
    }

    /// Drains every 1 to `period` cycles until a time.
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

/// What a look at each tick sees, but for the tick after one that saw a change.
fn seen(edges: &[Edge], zero: u64) -> Vec<Sample> {
    let mut samples = Vec::new();
    let (mut tick, mut levels) = (0, Shaft::START);
    let mut edges = edges.iter().peekable();
    while let Some(edge) = edges.peek() {
        tick = (edge.ticks + SYNCHRONISER - zero)
            .div_ceil(CYCLES.into())
            .max(tick);
        let at = zero + tick * u64::from(CYCLES);
        let before = levels;
        while let Some(edge) = edges.next_if(|edge| edge.ticks + SYNCHRONISER <= at) {
            levels = edge.levels;
        }
        if levels != before {
            samples.push(Sample {
                ticks: tick,
                levels,
            });
            tick += 2;
        }
    }
    samples
}

fn changes(samples: &[Sample]) -> Vec<Event> {
    samples.iter().copied().map(Event::Change).collect()
}

fn edges_come_through<C: Chip>(map: Map, seed: u64, (interval, period): (u64, u64)) {
    let mut rig = Rig::<C>::new(map, seed, BUS);
    let mut shaft = rig.shaft();
    shaft.wander(&mut Random(seed ^ 0x5555), 500, interval);
    let samples = rig.turn(&shaft);
    assert_eq!(samples.len(), shaft.edges.len());
    // The last ones are drained after they have settled.
    rig.drain_until(shaft.ticks + 2000, period);
    assert_eq!(rig.model().misuse, [""; 0]);
    assert!(rig.events == changes(&samples), "seed {seed}");
    let (mut direct, mut drained) = (encoder(), encoder());
    for (sample, event) in samples.iter().zip(&rig.events) {
        assert!(
            direct.edge_at(*sample) == drained.take(*event),
            "seed {seed}"
        );
    }
    assert_eq!(drained.faults(), direct.faults(), "seed {seed}");
    assert_eq!(drained.faults().missed, 0, "seed {seed}");
    assert!(drained.decoder().is_referenced());
}

#[test]
fn edges_through_machines_and_dma_are_those_fed_directly() {
    for seed in 0..12 {
        // A slow shaft, a fast one with short looks, one that fills nearly half of the memory between two drains.
        for motion in [(3000, 20_000), (400, 1500), (300, 7000)] {
            edges_come_through::<Rp2040>(RP2040_MAP, seed, motion);
            edges_come_through::<Rp2350>(RP2350_MAP, seed, motion);
        }
    }
}

#[test]
fn edges_far_apart_are_told_to_a_tick_and_never_early() {
    let mut rig = Rig::<Rp2040>::new(RP2040_MAP, 5, BUS);
    let mut shaft = rig.shaft();
    shaft.cruise(300, 997);
    rig.turn(&shaft);
    rig.drain_until(shaft.ticks + 2000, 2500);
    let zero = rig.model().zero;
    assert_eq!(rig.events.len(), shaft.edges.len());
    for (event, edge) in rig.events.iter().zip(&shaft.edges) {
        let Event::Change(sample) = event else {
            panic!("{event:?}")
        };
        let late = sample.ticks * u64::from(CYCLES) + zero - edge.ticks;
        assert!((SYNCHRONISER..SYNCHRONISER + 6).contains(&late), "{late}");
    }
}

#[test]
fn the_count_s_wrap_may_come_anywhere_between_edges_and_questions() {
    for seed in 0..20 {
        let mut rig = Rig::<Rp2040>::new(RP2040_MAP, seed, BUS);
        // Half periods and less, as the contract has it; the 29 bits wrap, and at the second time all 32 of the machines' registers.
        let mut expected = Vec::new();
        let wrap = |wraps: u64| wraps << BITS;
        for wraps in [1, 8] {
            let near = wrap(wraps) - 3000 - seed * 97;
            while rig.model().counted() < near {
                let left = near - rig.model().counted();
                rig.model().skip(left.min(1 << 27) as u32);
                rig.drain();
            }
            let mut shaft = rig.shaft();
            shaft.wander(&mut Random(seed), 200, 200);
            let samples = rig.turn(&shaft);
            let (first, last) = (samples.first().unwrap(), samples.last().unwrap());
            assert!(first.ticks < wrap(wraps) && last.ticks > wrap(wraps));
            expected.extend(changes(&samples));
            while rig.model().now < shaft.ticks + 2000 {
                let now = rig.model().now;
                rig.drain_until(now + 1, 800);
                // The control loop's time goes on meanwhile.
                let before = rig.model().counted();
                let time = rig.captures.now();
                let after = rig.model().counted();
                assert!((before..=after).contains(&time), "{before} {time} {after}");
            }
        }
        assert_eq!(rig.events, expected, "seed {seed}");
    }
}

#[test]
fn changes_next_to_each_other_are_one_or_two_samples_and_none_is_lost() {
    let mut both = 0;
    for gap in 0..30 {
        for phase in 0..6 {
            let mut rig = Rig::<Rp2040>::new(RP2040_MAP, gap, BUS);
            let mut shaft = Shaft::new(rig.model().now + 500 + phase);
            for k in 0..40 {
                shaft.step(true, if k % 2 == 1 { 600 } else { gap });
            }
            shaft.edges.retain(|edge| edge.channel != Channel::Z);
            let samples = rig.turn(&shaft);
            rig.drain_until(shaft.ticks + 2000, 900);
            assert_eq!(rig.events, changes(&samples), "gap {gap}");
            let mut encoder = encoder();
            for event in &rig.events {
                encoder.take(*event);
            }
            // Two at once have no direction, which the decoder says; two that are told one after the other are right.
            let told = samples.len() == 40;
            assert_eq!(encoder.faults().total() == 0, told, "gap {gap} {phase}");
            both += u32::from(!told);
            assert!(told || gap < 12, "gap {gap}");
        }
    }
    assert!(both > 10, "{both}");
}

#[test]
fn an_index_that_changes_together_with_an_edge_is_one_sample_of_both() {
    let mut rig = Rig::<Rp2040>::new(RP2040_MAP, 3, BUS);
    let mut shaft = rig.shaft();
    shaft.cruise(20 * 4 * LINES, 400);
    // Z rises and falls with edges, as from a gated index.
    let mut last = 0;
    for edge in &mut shaft.edges {
        if edge.channel == Channel::Z && edge.levels.z() {
            edge.ticks = last;
        }
        last = edge.ticks;
    }
    let samples = rig.turn(&shaft);
    assert!(samples.len() < shaft.edges.len());
    rig.drain_until(shaft.ticks + 2000, 3000);
    assert_eq!(rig.events, changes(&samples));
    let mut encoder = encoder();
    for event in &rig.events {
        encoder.take(*event);
    }
    assert_eq!(encoder.faults().total(), 0);
    assert!(encoder.decoder().is_referenced());
}

#[test]
fn what_can_not_start_says_why() {
    let model = || Model::new(RP2040_MAP, 1, BUS, 28);
    let start = |model, pin| PioCapture::<_, Rp2040>::start(model, pin).err();
    assert_eq!(start(model(), 28), Some(StartError::Pins));
    let mut skewed = model();
    skewed.memory_at += 128;
    assert_eq!(start(skewed, 2), Some(StartError::Memory));
    let mut held = model();
    held.comes_out = false;
    assert_eq!(start(held, 2), Some(StartError::Reset));
    let mut busy = model();
    busy.dma_stops = false;
    assert_eq!(start(busy, 2), Some(StartError::Dma));
    assert_eq!(start(model(), 27), None);
}

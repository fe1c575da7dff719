//! Longest slice of solving and of looking out, in QEMU, for encoders of many shapes: `cargo qemu --bin qemu_slices`.
//!
//! The steps are made up: a disc with errors of its own, at two speeds or slower from turn to turn, with torque ripple. What counts is the
//! shape: few and many classes, numbers of edges with and without divisors.
#![no_std]
#![no_main]

#[path = "../qemu_cost/counter.rs"]
mod counter;
#[path = "../qemu/mod.rs"]
mod qemu;

use cortex_m::Peripherals;
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use quadcal::edge::Direction;
use quadcal::estimate::{
    Anchor, EdgeBuffers, Estimator, Lookout, Parts, Progress, Slice, Solver, block_edges,
};
use quadcal::shape::EncoderShape;
use quadcal::step::{Flags, Outcome, Step};
use quadcal::trig::{SINE_BITS, sin_cos};
use quadcal::units::Turn32;

use counter::InstructionCounter;

/// Edges and classes of the encoders.
const SHAPES: [(u32, u32); 12] = [
    (10_000, 4),
    (10_000, 2),
    (10_000, 1),
    (9216, 4),
    (4096, 4),
    (8000, 1),
    (2048, 1),
    (1009, 1),
    (1004, 4),
    (180, 6),
    (58, 2),
    (12, 6),
];

/// How the encoders are turned.
#[derive(Clone, Copy, Debug)]
enum Ride {
    /// Seven turns at one speed, then four times as fast; torque of one order.
    TwoSpeeds,
    /// Slower from turn to turn.
    RunDown,
    /// The same, with more orders of torque than are listed.
    Cogging,
}

const RIDES: [Ride; 3] = [Ride::TwoSpeeds, Ride::RunDown, Ride::Cogging];

/// Orders of the torques.
const ONE: [u32; 1] = [5];
const MANY: [u32; 19] = [
    3, 5, 8, 9, 10, 11, 13, 14, 15, 17, 18, 19, 20, 22, 23, 25, 26, 27, 28,
];

const EDGES: usize = 10_000;
const COARSE: usize = 3 * 1024;

/// Memory for any of the shapes.
struct Memory {
    sum: [i32; EDGES],
    cells: [i16; EDGES],
    coarse: [i32; COARSE],
}

/// As much of it as a shape needs.
struct Cut<'a> {
    memory: &'a mut Memory,
    edges: usize,
    blocks: usize,
}

impl EdgeBuffers for Cut<'_> {
    fn parts(&mut self) -> Parts<'_> {
        Parts {
            sum: &mut self.memory.sum[..self.edges],
            cells: &mut self.memory.cells[..self.edges],
            coarse: &mut self.memory.coarse[..3 * self.blocks],
        }
    }

    fn cells(&self) -> &[i16] {
        &self.memory.cells[..self.edges]
    }

    fn edges(&self) -> usize {
        self.edges
    }
}

#[entry]
fn main() -> ! {
    // The entry attribute hands this out as a unique reference: safe, and off the stack.
    static mut MEMORY: Memory = Memory {
        sum: [0; EDGES],
        cells: [0; EDGES],
        coarse: [0; COARSE],
    };
    let done = run(MEMORY);
    qemu::finish(done.ok_or("a shape does not fit the core, or was not learned"))
}

fn run(memory: &mut Memory) -> Option<()> {
    let counter = InstructionCounter::start(Peripherals::take()?.SYST);
    for ride in RIDES {
        for (edges, classes) in SHAPES {
            measure(memory, ride, (edges, classes), &counter)?;
        }
    }
    Some(())
}

fn measure(
    memory: &mut Memory,
    ride: Ride,
    (edges, classes): (u32, u32),
    counter: &InstructionCounter,
) -> Option<()> {
    let shape = EncoderShape::new(edges, classes).ok()?;
    let count = edges as usize;
    let blocks = count / block_edges(count, COARSE / 3)?;
    let buffers = Cut {
        memory,
        edges: count,
        blocks,
    };
    let mut estimator = Estimator::new(shape, Anchor::Index, buffers).ok()?;
    let mut rig = Rig::new(edges, ride);
    let mut longest = [0_u64; 2];
    while estimator.totals().turns < 14 {
        if let Progress::TurnTaken(_) = estimator.push(&Outcome::Step(rig.next())) {
            let mut lookout = Lookout::new();
            loop {
                let begin = counter.now();
                let looked = estimator.look_out(&mut lookout);
                longest[0] = longest[0].max(counter.now() - begin);
                if looked.is_ready() {
                    break;
                }
            }
        }
    }
    let (mut solver, mut slices) = (Solver::new(), 0);
    loop {
        let begin = counter.now();
        let slice = estimator.slice(&mut solver);
        longest[1] = longest[1].max(counter.now() - begin);
        slices += 1;
        if let Slice::Solved(_) = slice.ok()? {
            break;
        }
    }
    hprintln!(
        "ride={:?} edges={} classes={} look_out_longest={} solve_longest={} solve_slices={}",
        ride,
        edges,
        classes,
        longest[0],
        longest[1],
        slices
    );
    Some(())
}

/// Makes steps up.
struct Rig {
    ride: Ride,
    edges: u32,
    edge: u32,
    turns: u32,
    ticks: u64,
    random: u32,
}

impl Rig {
    const fn new(edges: u32, ride: Ride) -> Self {
        Self {
            ride,
            edges,
            edge: 0,
            turns: 0,
            ticks: 1000,
            random: 1,
        }
    }

    /// A number that repeats with the edge, below 2^10.
    const fn error(edge: u32) -> u32 {
        edge.wrapping_mul(2_654_435_769) >> 22
    }

    fn next(&mut self) -> Step {
        self.edge += 1;
        if self.edge == self.edges {
            (self.edge, self.turns) = (0, self.turns + 1);
        }
        self.random = self
            .random
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223);
        let base: u32 = match self.ride {
            Ride::TwoSpeeds if self.turns < 8 => 40_000,
            Ride::TwoSpeeds => 10_000,
            Ride::RunDown | Ride::Cogging => {
                20_000 + 1500 * self.turns + 1500 * self.edge / self.edges
            }
        };
        let orders = match self.ride {
            Ride::TwoSpeeds | Ride::RunDown => &ONE[..],
            Ride::Cogging => &MANY,
        };
        let angle = (u32::MAX / self.edges).wrapping_mul(self.edge);
        let sines = orders
            .iter()
            .map(|order| i64::from(sin_cos(Turn32(angle.wrapping_mul(*order))).0));
        let swing = (sines.sum::<i64>() * i64::from(base)) >> (SINE_BITS + 6);
        let swing = match self.ride {
            Ride::TwoSpeeds if self.turns < 8 => swing,
            Ride::TwoSpeeds => swing / 16,
            // Of one torque, a swing that goes with the square of the duration.
            Ride::RunDown | Ride::Cogging => (swing * i64::from(base / 1000).pow(2)) >> 10,
        };
        let noise = self.random >> 28;
        let before = if self.edge == 0 {
            self.edges
        } else {
            self.edge
        } - 1;
        let step = i64::from(base) + i64::from(Self::error(self.edge)) * i64::from(base) / 40_000
            - i64::from(Self::error(before)) * i64::from(base) / 40_000
            + swing
            + i64::from(noise);
        let interval = u32::try_from(step).unwrap_or(1);
        self.ticks += u64::from(interval);
        Step {
            ticks: self.ticks,
            edge: self.edge,
            position: self.edge,
            interval,
            resync: 0,
            advance: 1,
            flags: Flags::REFERENCED,
            direction: Direction::Forward,
        }
    }
}

//! Counts what one edge costs in instructions on the edge path of a drive that can be calibrated in the field, in QEMU:
//! `cargo qemu --bin edge_cost_field`. While the workbench has nothing to do but to correct it, while it learns, while it proves what
//! it has learned, and while it compares a table that was handed over. Edges and counting are those of image `edge_cost`.
//!
//! An image of its own, as a drive has one estimator too: a second one would keep the compiler from putting it in line.
#![no_std]
#![no_main]

#[path = "../qemu_cost/counter.rs"]
mod counter;
#[path = "../qemu/mod.rs"]
mod qemu;
// Nothing turns round here.
#[allow(dead_code)]
#[path = "../edge_cost/rig.rs"]
mod rig;
#[path = "../edge_cost/stage.rs"]
mod stage;

use core::hint::black_box;

use cortex_m::Peripherals;
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use crc::{CRC_32_ISO_HDLC, Crc};
use quadcal::decoder::{DecoderConfig, QuadratureDecoder};
use quadcal::device::{Bench, EstimatorLearner, MappedFlash, Shelf, Workbench, WorkbenchConfig};
use quadcal::edge::Sample;
use quadcal::estimate::{Solver, StaticBuffers};
use quadcal::recalibrate::{Action, Options, SolveInSlices, Solving};
use quadcal::shape::EncoderShape;
use quadcal::slot::{HEADER_BYTES, MAGIC, Slot, VERSION, slot_bytes};
use quadcal::step::Outcome;
use quadcal::store::{Found, Place};

use counter::InstructionCounter;
use rig::{BLOCK, LINES, Rig, SLOTS};
use stage::{Stage, idle};

type Buffers = StaticBuffers<{ LINES as usize }, 4>;

const CLOCK_HZ: u64 = 84_000_000;

/// Blocks before every state has what it needs: three turns.
const WARM: usize = 3 * SLOTS as usize / BLOCK;

/// Blocks counted in each state: three turns.
const COUNTED: usize = 3 * SLOTS as usize / BLOCK;

/// Bytes of the slot in use.
const SLOT_BYTES: usize = match EncoderShape::new(SLOTS, 4) {
    Ok(shape) => slot_bytes(shape),
    Err(_) => 0,
};

/// The slot in use: 7 in steps of 2^6 for each edge, and 100 for each class.
static SLOT: [u8; SLOT_BYTES] = slot();

/// Lays the bytes out as [`quadcal::slot`] describes them; there is no RAM for them beside the learner's.
const fn slot() -> [u8; SLOT_BYTES] {
    let mut bytes = [0; SLOT_BYTES];
    put(&mut bytes, 0, &MAGIC);
    put(&mut bytes, 4, &VERSION.to_le_bytes());
    put(&mut bytes, 6, &[4, 6]);
    put(&mut bytes, 8, &SLOTS.to_le_bytes());
    // Learned from so many turns, with an index.
    put(&mut bytes, 12, &[11, 0, 0, 0, 1]);
    let mut class = 0;
    while class < 4 {
        put(&mut bytes, 40 + 4 * class, &[100]);
        class += 1;
    }
    let mut edge = 0;
    while edge < SLOTS as usize {
        put(&mut bytes, HEADER_BYTES + 2 * edge, &[7]);
        edge += 1;
    }
    let (whole, _) = bytes.split_at(SLOT_BYTES - 4);
    let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC).checksum(whole);
    put(&mut bytes, SLOT_BYTES - 4, &crc.to_le_bytes());
    bytes
}

const fn put(bytes: &mut [u8], at: usize, piece: &[u8]) {
    let mut i = 0;
    while i < piece.len() {
        bytes[at + i] = piece[i];
        i += 1;
    }
}

/// A slot that is read where it lies.
#[derive(Clone, Copy)]
struct InPlace<'f>(&'f [u8]);

impl<'f> MappedFlash<'f> for InPlace<'f> {
    fn bytes(&self, offset: u32) -> Option<&'f [u8]> {
        self.0.get(offset as usize..)
    }
}

type FieldBench<'a> = Workbench<'a, EstimatorLearner<&'a Shelf<'a>, &'a mut Solver>, InPlace<'a>>;

/// The encoder in front of the workbench.
struct Line<'a> {
    rig: Rig,
    decoder: QuadratureDecoder,
    samples: &'a mut [Sample; BLOCK],
    outcomes: &'a mut [Outcome; BLOCK],
}

impl Line<'_> {
    fn fill(&mut self) {
        self.rig.fill(self.samples);
        for (outcome, sample) in self.outcomes.iter_mut().zip(self.samples.iter()) {
            *outcome = self.decoder.push(*sample);
        }
    }

    /// Passes three turns and prints what an edge costs; before, so many blocks that are not counted.
    fn count(
        &mut self,
        bench: &mut FieldBench<'_>,
        counter: &InstructionCounter,
        name: &str,
        warm: usize,
    ) {
        let (mut empty, mut push) = (Stage::default(), Stage::default());
        for block in 0..warm + COUNTED {
            self.fill();
            if block == warm {
                (empty, push) = (Stage::default(), Stage::default());
            }
            empty.count(counter, || idle(self.samples));
            push.count(counter, || push_block(bench, self.outcomes));
            // The main loop's part.
            bench.figures();
        }
        push.print(name, &empty);
    }
}

#[entry]
fn main() -> ! {
    // The entry attribute hands these out as unique references: safe, and off the stack.
    static mut BUFFERS: Buffers = Buffers::new();
    static mut SOLVER: Solver = Solver::new();
    static mut SAMPLES: [Sample; BLOCK] = [rig::NO_SAMPLE; BLOCK];
    static mut OUTCOMES: [Outcome; BLOCK] = [Outcome::Idle; BLOCK];
    let done = measure(BUFFERS, SOLVER, SAMPLES, OUTCOMES);
    qemu::finish(done.ok_or("the rig does not fit the core, or was not learned"))
}

/// Prints everything; `None` if the rig does not fit the core, or was not learned.
fn measure(
    buffers: &mut Buffers,
    solver: &mut Solver,
    samples: &mut [Sample; BLOCK],
    outcomes: &mut [Outcome; BLOCK],
) -> Option<()> {
    let counter = &InstructionCounter::start(Peripherals::take()?.SYST);
    let shape = EncoderShape::new(SLOTS, 4).ok()?;
    let header = Slot::parse(&SLOT).ok()?.header;
    let shelf = Shelf::new(buffers);
    let config = WorkbenchConfig {
        shape,
        clock_hz: CLOCK_HZ,
        still: CLOCK_HZ,
    };
    let learner = EstimatorLearner::new(shape, CLOCK_HZ, &shelf, solver);
    let mut bench = Workbench::new(config, learner, InPlace(&SLOT));
    let in_use = Found {
        place: Place::A,
        header,
        offset: 0,
    };
    let adopted = timed(counter, "adopt", || bench.adopt(Some(&in_use)));
    if !adopted {
        return None;
    }
    let mut line = Line {
        rig: Rig::new(),
        decoder: QuadratureDecoder::new(DecoderConfig::new(LINES)).ok()?,
        samples,
        outcomes,
    };
    line.count(&mut bench, counter, "push_with_nothing_to_do", WARM);

    let options = Options::default();
    timed(counter, "prepare", || {
        bench.perform(&Action::Prepare(options));
    });
    bench.perform(&Action::Learn);
    line.count(&mut bench, counter, "push_learning", WARM);

    bench.perform(&Action::Solve);
    while let Solving::Working(_) = bench.slice() {}
    bench.candidate()?;
    timed(counter, "prove", || bench.perform(&Action::Prove));
    line.count(&mut bench, counter, "push_proving", WARM);
    let proven = timed(counter, "figures", || bench.figures()).turns;

    bench.perform(&Action::Release);
    bench.room()?.fill(7);
    bench.perform(&Action::Compare);
    bench.compare(&header);
    line.count(&mut bench, counter, "push_comparing", WARM);
    (proven >= 3 && bench.figures().turns >= 3).then_some(())
}

/// Does a call of the main loop and prints what it takes.
fn timed<T>(counter: &InstructionCounter, name: &str, call: impl FnOnce() -> T) -> T {
    let begin = counter.now();
    let result = call();
    hprintln!("{}={}", name, counter.now() - begin);
    result
}

#[inline(never)]
fn push_block(bench: &mut FieldBench<'_>, outcomes: &[Outcome]) {
    for outcome in outcomes {
        if let Some(edge) = bench.push(black_box(outcome)) {
            black_box((edge.angle, edge.moved));
        }
    }
}

//! Counts what one edge costs in instructions, stage by stage, in QEMU: `cargo qemu --bin edge_cost`. `docs/cost.md` has
//! the result.
//!
//! The edges are those of an encoder of 2500 lines with an index, at 600 r/min and 84 MHz, each moved by up to 12 % of a
//! step; one edge in 10 000 is the index. They are made outside the counted loops. What an empty loop over the same
//! samples takes is subtracted.
#![no_std]
#![no_main]

mod captures;
#[path = "../qemu_cost/counter.rs"]
mod counter;
mod encoder;
mod locate;
mod rig;
mod stage;

use core::hint::black_box;
use core::panic::PanicInfo;

use cortex_m::Peripherals;
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, heprintln};
use quadcal::corrector::Corrector;
use quadcal::decoder::{DecoderConfig, QuadratureDecoder};
use quadcal::edge::Sample;
use quadcal::estimate::{Anchor, Estimator, Progress, StaticBuffers};
use quadcal::interval::{ErrorChange, Interval, IntervalConfig};
use quadcal::shape::{CLASSES_MAX, EncoderShape};
use quadcal::step::Outcome;
use quadcal::table::ErrorTable;
use quadcal::units::{TickDelta8, TurnDelta32};

use captures::Hardware;
use counter::InstructionCounter;
use rig::{BLOCK, LINES, Rig, SLOTS};
use stage::{Stage, idle};

/// Blocks of edges in a run: six turns.
const BLOCKS: usize = 6 * SLOTS as usize / BLOCK;

/// Blocks before the estimator has a turn to fold and one to take in.
const WARM: usize = 3 * SLOTS as usize / BLOCK;

type Learner = Estimator<&'static mut StaticBuffers<{ LINES as usize }, 4>>;

static ENTRIES: [i16; SLOTS as usize] = [7; SLOTS as usize];

#[entry]
fn main() -> ! {
    static mut BUFFERS: StaticBuffers<{ LINES as usize }, 4> = StaticBuffers::new();
    static mut SAMPLES: [Sample; BLOCK] = [rig::NO_SAMPLE; BLOCK];
    static mut HARDWARE: Hardware = Hardware::new();
    static mut OUTCOMES: [Outcome; BLOCK] = [Outcome::Idle; BLOCK];
    let shape = EncoderShape::new(SLOTS, 4).ok();
    let learner = shape.and_then(|shape| Estimator::new(shape, Anchor::Index, BUFFERS).ok());
    let done = match learner {
        Some(mut learner) => measure(&mut learner, SAMPLES, OUTCOMES, HARDWARE),
        None => None,
    };
    if done.is_none() {
        heprintln!("error: the rig does not fit the core");
    }
    exit(done.is_some())
}

fn measure(
    learner: &mut Learner,
    samples: &mut [Sample; BLOCK],
    outcomes: &mut [Outcome; BLOCK],
    hardware: &Hardware,
) -> Option<()> {
    let counter = InstructionCounter::start(Peripherals::take()?.SYST);
    let table = ErrorTable::new(
        learner.shape(),
        [TurnDelta32(100); CLASSES_MAX],
        &ENTRIES,
        6,
    )
    .ok()?;
    let (mut rig, mut swinging) = (Rig::new(), Rig::new());
    let mut decoder = QuadratureDecoder::new(DecoderConfig::new(LINES)).ok()?;
    let (mut recorder, mut watchful) = (decoder, decoder);
    let mut chained = (decoder, Corrector::new(table, Anchor::Index));
    let mut corrector = Corrector::new(table, Anchor::Index);
    let late = [300, -100, -300, 100, 0, 0].map(TickDelta8);
    let mut compensator = Corrector::new(table.with_delays(late), Anchor::Index);
    let mut interval = Interval::new(IntervalConfig::new(SLOTS, 84_000_000));
    let [
        mut empty,
        mut decode,
        mut reverse,
        mut correct,
        mut compensate,
        mut time,
        mut speed,
        mut learn,
        mut chain,
    ] = core::array::from_fn(|_| Stage::default());
    for block in 0..BLOCKS {
        rig.fill(samples);
        for (outcome, sample) in outcomes.iter_mut().zip(samples.iter()) {
            *outcome = recorder.push(*sample);
        }
        if block == WARM {
            [
                empty, decode, reverse, correct, compensate, time, speed, learn, chain,
            ] = core::array::from_fn(|_| Stage::default());
        }
        empty.count(&counter, || idle(samples));
        decode.count(&counter, || decode_block(&mut decoder, samples));
        correct.count(&counter, || correct_block(&mut corrector, outcomes));
        compensate.count(&counter, || compensate_block(&mut compensator, outcomes));
        chain.count(&counter, || {
            chain_block(&mut chained.0, &mut chained.1, samples)
        });
        time.count(&counter, || time_block(&mut interval, outcomes));
        speed.count(&counter, || speed_block(&interval, outcomes));
        learn.count(&counter, || learn_block(learner, outcomes));
        swinging.swing(samples);
        reverse.count(&counter, || decode_block(&mut watchful, samples));
    }
    decode.print("decode", &empty);
    reverse.print("decode_swinging", &empty);
    correct.print("correct", &empty);
    compensate.print("correct_with_delays", &empty);
    chain.print("decode_and_correct", &empty);
    time.print("interval", &empty);
    speed.print("speed", &empty);
    learn.print("learn", &empty);
    encoder::measure(&counter, samples, table)?;
    captures::measure(&counter, samples, table, hardware)?;
    locate::measure(&counter, samples)?;
    (learner.totals().turns == 4 && decoder == recorder).then_some(())
}

#[inline(never)]
fn decode_block(decoder: &mut QuadratureDecoder, samples: &[Sample]) {
    for sample in samples {
        black_box(&decoder.push(*black_box(sample)));
    }
}

#[inline(never)]
fn correct_block(corrector: &mut Corrector<'_>, outcomes: &[Outcome]) {
    for outcome in outcomes {
        if let Some(edge) = corrector.push(black_box(outcome)) {
            black_box((edge.angle, edge.moved));
        }
    }
}

/// The times are used as well.
#[inline(never)]
fn compensate_block(corrector: &mut Corrector<'_>, outcomes: &[Outcome]) {
    for outcome in outcomes {
        if let Some(edge) = corrector.push(black_box(outcome)) {
            black_box((edge.angle, edge.moved, edge.late, edge.stretch));
        }
    }
}

#[inline(never)]
fn chain_block(decoder: &mut QuadratureDecoder, corrector: &mut Corrector<'_>, samples: &[Sample]) {
    for sample in samples {
        if let Some(edge) = corrector.push(&decoder.push(*black_box(sample))) {
            black_box((edge.angle, edge.moved));
        }
    }
}

#[inline(never)]
fn time_block(interval: &mut Interval, outcomes: &[Outcome]) {
    for outcome in outcomes {
        if let Outcome::Step(step) = black_box(outcome) {
            interval.push(step, ErrorChange::NONE);
            black_box(&interval);
        }
    }
}

/// A control loop's question, once an edge.
#[inline(never)]
fn speed_block(interval: &Interval, outcomes: &[Outcome]) {
    for outcome in outcomes {
        if let Outcome::Step(step) = black_box(outcome) {
            black_box(black_box(interval).speed_at(step.ticks));
        }
    }
}

#[inline(never)]
fn learn_block(learner: &mut Learner, outcomes: &[Outcome]) {
    for outcome in outcomes {
        if learner.push(black_box(outcome)) != Progress::Running {
            black_box(&learner);
        }
    }
}

fn exit(success: bool) -> ! {
    loop {
        debug::exit(if success {
            debug::EXIT_SUCCESS
        } else {
            debug::EXIT_FAILURE
        });
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    heprintln!("{}", info);
    exit(false)
}

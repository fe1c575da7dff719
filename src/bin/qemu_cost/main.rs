//! Instructions that each stage takes an edge, in QEMU, for an encoder of 2500 lines.
//!
//! Does what a session does, but stage by stage: a batch of events goes through time base and decoder as a whole, then
//! what came of it through the estimator, or, after the solve, the corrector. So the counter is read twice a batch and
//! stage. Taken off are the cost of reading it and that of a loop that calls a function which does nothing.
//!
//! Command line: `qemu_cost EVENTS SLOT`. The events must be of a 32-bit timer, so that hardly any is not an edge. Writes the
//! table learned, and prints lines of `key=value` pairs: instructions and calls of every stage, and of solving and of looking
//! out (before it) all instructions, slices and the longest slice. The functions in `stages` are the edge path that the tests look into.
#![no_std]
#![no_main]

mod counter;
#[path = "../qemu/mod.rs"]
mod qemu;
mod stages;

use core::fmt;
use core::hint::black_box;

use cortex_m::Peripherals;
use cortex_m_rt::entry;
use cortex_m_semihosting::{heprintln, hprintln};
use quadcal::corrector::Corrector;
use quadcal::decoder::{DecoderConfig, QuadratureDecoder};
use quadcal::estimate::{
    Anchor, EdgeBuffers, Estimator, Findings, Lookout, Progress, Slice, SolveError, Solver,
    StaticBuffers,
};
use quadcal::replay::{Event, EventReader, ReadError, TURNS_DEFAULT, TimerWidth};
use quadcal::shape::{EncoderShape, ShapeError};
use quadcal::slot::{self, SlotHeader};
use quadcal::step::{Outcome, SensorError};
use quadcal::summary::Summary;
use quadcal::table::{ErrorTable, TableError};
use quadcal::timebase::Timebase32;
use quadcal::units::Ticks;

use counter::InstructionCounter;
use qemu::output::Output;
use qemu::semihost::{self, File, IoError, Mode};

const LINES: u32 = 2500;

/// Events that go through a stage at a time.
const BATCH: usize = 256;

/// Bytes that go to or come from the host in one semihosting call.
const BLOCK: usize = 1024;

/// All memory besides the stack.
struct Memory {
    buffers: StaticBuffers<{ LINES as usize }, 4>,
    events: heapless::Vec<Event, BATCH>,
    outcomes: heapless::Vec<Outcome, BATCH>,
    line: [u8; 256],
    block: [u8; BLOCK],
    output: [u8; BLOCK],
}

/// Why a run failed.
enum Failure {
    Usage,
    PeripheralsTaken,
    Header,
    Io(IoError),
    Read(ReadError<IoError>),
    Shape(ShapeError),
    Sensor(SensorError),
    TooFewTurns,
    Solve(SolveError),
    Table(TableError),
}

impl From<IoError> for Failure {
    fn from(error: IoError) -> Self {
        Self::Io(error)
    }
}

impl From<ReadError<IoError>> for Failure {
    fn from(error: ReadError<IoError>) -> Self {
        Self::Read(error)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage => f.write_str("usage: qemu_cost EVENTS SLOT"),
            Self::PeripheralsTaken => f.write_str("the peripherals are taken"),
            Self::Header => f.write_str("not 2500 lines and a 32-bit timer"),
            Self::Io(error) => error.fmt(f),
            Self::Read(error) => error.fmt(f),
            Self::Shape(error) => write!(f, "{error:?}"),
            Self::Sensor(error) => write!(f, "{error:?}"),
            Self::TooFewTurns => f.write_str("the stream ended before enough turns were whole"),
            Self::Solve(error) => write!(f, "{error:?}"),
            Self::Table(error) => write!(f, "{error:?}"),
        }
    }
}

/// Instructions and calls of one stage.
#[derive(Default)]
struct Cost {
    instructions: u64,
    calls: u64,
}

/// Measures loops over a batch.
struct Meter {
    counter: InstructionCounter,
    /// Instructions between two reads of the counter with nothing in between.
    read: u64,
}

impl Meter {
    fn new(counter: InstructionCounter) -> Self {
        let read = (0..8)
            .map(|_| {
                let begin = counter.now();
                counter.now() - begin
            })
            .min()
            .unwrap_or(0);
        Self { counter, read }
    }

    /// Runs `work` and counts its instructions.
    fn total<T>(&self, work: impl FnOnce() -> T) -> (T, u64) {
        let begin = self.counter.now();
        let result = work();
        let end = self.counter.now();
        (result, (end - begin).saturating_sub(self.read))
    }

    /// Runs `stage` on every item, and counts its instructions less those of the loop and the call.
    fn each<T>(&self, cost: &mut Cost, items: &[T], mut stage: impl FnMut(&T)) {
        let ((), with) = self.total(|| items.iter().for_each(&mut stage));
        let ((), without) = self.total(|| items.iter().for_each(stages::nothing));
        cost.instructions += with.saturating_sub(without);
        cost.calls += items.len() as u64;
    }
}

/// Instructions of all slices of a piece of work, and of the longest.
#[derive(Default)]
struct Slices {
    instructions: u64,
    slices: u64,
    longest: u64,
}

impl Slices {
    fn take(&mut self, instructions: u64) {
        self.instructions += instructions;
        self.slices += 1;
        self.longest = self.longest.max(instructions);
    }
}

impl Meter {
    fn outlook<B: EdgeBuffers>(&self, estimator: &mut Estimator<B>) -> Slices {
        let (mut slices, mut lookout) = (Slices::default(), Lookout::new());
        loop {
            let (looked, instructions) = self.total(|| estimator.look_out(&mut lookout));
            slices.take(instructions);
            if looked.is_ready() {
                return slices;
            }
        }
    }

    fn solve<B: EdgeBuffers>(
        &self,
        estimator: &mut Estimator<B>,
    ) -> Result<(Findings, Slices), Failure> {
        let (mut slices, mut solver) = (Slices::default(), Solver::new());
        loop {
            let (slice, instructions) = self.total(|| estimator.slice(&mut solver));
            slices.take(instructions);
            match slice.map_err(Failure::Solve)? {
                Slice::More(_) => {}
                Slice::Solved(findings) => return Ok((findings, slices)),
            }
        }
    }
}

#[entry]
fn main() -> ! {
    // The entry attribute hands this out as a unique reference: safe, and off the stack.
    static mut MEMORY: Memory = Memory {
        buffers: StaticBuffers::new(),
        events: heapless::Vec::new(),
        outcomes: heapless::Vec::new(),
        line: [0; 256],
        block: [0; BLOCK],
        output: [0; BLOCK],
    };
    qemu::finish(run(MEMORY))
}

fn run(memory: &mut Memory) -> Result<(), Failure> {
    let timer = Peripherals::take().ok_or(Failure::PeripheralsTaken)?.SYST;
    let meter = Meter::new(InstructionCounter::start(timer));
    let mut words = semihost::command_line(&mut memory.line)?
        .split_ascii_whitespace()
        .skip(1);
    let (Some(path), Some(slot), None) = (words.next(), words.next(), words.next()) else {
        return Err(Failure::Usage);
    };
    let mut input = File::open(path, Mode::Read)?;
    let mut events = EventReader::new(|block: &mut [u8]| input.read(block), &mut memory.block)?;
    let header = *events.header();
    if header.lines != LINES || header.timer != TimerWidth::Bits32 {
        return Err(Failure::Header);
    }
    let turns = match header.turns {
        0 => TURNS_DEFAULT,
        turns => turns,
    };
    let shape = EncoderShape::new(4 * LINES, 4).map_err(Failure::Shape)?;
    let decoder = QuadratureDecoder::new(DecoderConfig::new(LINES)).map_err(Failure::Sensor)?;
    let mut front = Front {
        base: Timebase32::new(),
        decoder,
        cost: Cost::default(),
    };
    let estimator = Estimator::new(shape, Anchor::Index, &mut memory.buffers);
    let mut estimator = estimator.map_err(Failure::Shape)?;
    let mut learning = Cost::default();
    let mut learned_until = None;
    while learned_until.is_none() {
        if !refill(&mut events, &mut memory.events)? {
            return Err(Failure::TooFewTurns);
        }
        front.batch(&meter, &memory.events, &mut memory.outcomes);
        meter.each(&mut learning, &memory.outcomes, |outcome| {
            // What is left of the batch after the last turn goes on into the estimator's next, unfinished one.
            if let Progress::TurnTaken(taken) = stages::learn(&mut estimator, outcome)
                && taken == turns
            {
                learned_until = outcome.step().map(|step| step.ticks);
            }
        });
    }
    let looking = meter.outlook(&mut estimator);
    let (findings, solving) = meter.solve(&mut estimator)?;
    let solution = estimator.finish(findings);
    heprintln!("learned: {}", Summary::of(&solution));

    let mut output = Output::new(slot, &mut memory.output);
    let header = SlotHeader::of(
        &solution,
        learned_until.unwrap_or_default(),
        header.clock_hz.into(),
    );
    slot::write(&header, solution.entries(), |bytes| output.write(bytes))?;
    output.close()?;

    let offsets = *solution.class_offsets();
    let table = ErrorTable::new(shape, offsets, solution.entries(), solution.shift());
    let table = table
        .map_err(Failure::Table)?
        .with_delays(header.delays.of_class);
    let mut corrector = Corrector::new(table, Anchor::Index);
    let (mut correcting, mut asking) = (Cost::default(), Cost::default());
    while refill(&mut events, &mut memory.events)? {
        front.batch(&meter, &memory.events, &mut memory.outcomes);
        meter.each(&mut correcting, &memory.outcomes, |outcome| {
            black_box(stages::correct(&mut corrector, outcome));
        });
        // As a control loop would ask: some time after the last edge.
        let newest = corrector.last().map_or(0, |edge| edge.ticks);
        let times: [Ticks; 16] = core::array::from_fn(|ask| newest + 100 * ask as Ticks);
        meter.each(&mut asking, &times, |now| {
            black_box(stages::angle_at(&corrector, *now));
        });
    }
    hprintln!(
        "look_out_instructions={} look_out_slices={} look_out_longest={} solve_instructions={} solve_slices={} solve_longest={}",
        looking.instructions,
        looking.slices,
        looking.longest,
        solving.instructions,
        solving.slices,
        solving.longest,
    );
    hprintln!(
        "front_instructions={} front_calls={} learn_instructions={} learn_calls={} correct_instructions={} correct_calls={} angle_at_instructions={} angle_at_calls={}",
        front.cost.instructions,
        front.cost.calls,
        learning.instructions,
        learning.calls,
        correcting.instructions,
        correcting.calls,
        asking.instructions,
        asking.calls,
    );
    Ok(())
}

/// Time base and decoder, with what they cost.
struct Front {
    base: Timebase32,
    decoder: QuadratureDecoder,
    cost: Cost,
}

impl Front {
    fn batch(
        &mut self,
        meter: &Meter,
        events: &[Event],
        outcomes: &mut heapless::Vec<Outcome, BATCH>,
    ) {
        outcomes.clear();
        meter.each(&mut self.cost, events, |event| {
            let outcome = stages::front(&mut self.base, &mut self.decoder, event);
            // There is room: no more outcomes than events.
            let _ = outcomes.push(outcome);
        });
    }
}

/// Reads the next batch; false at the file's end.
fn refill<S>(
    reader: &mut EventReader<'_, S>,
    events: &mut heapless::Vec<Event, BATCH>,
) -> Result<bool, Failure>
where
    S: FnMut(&mut [u8]) -> Result<usize, IoError>,
{
    events.clear();
    while !events.is_full() {
        let Some(event) = reader.next_event()? else {
            break;
        };
        let _ = events.push(event);
    }
    Ok(!events.is_empty())
}

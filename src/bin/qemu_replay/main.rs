//! Firmware image for QEMU (`-M netduinoplus2`, an STM32F405): takes an event file from the host through semihosting,
//! works on it as a drive's interrupt handlers would, and writes the result back.
//!
//! Command line: `qemu_replay EVENTS RESULT`. Prints one line of `key=value` pairs for the test to read. The exit code is
//! that of a command: 0, or 1 with the reason on the error output.
#![no_std]
#![no_main]

mod counter;
mod memory;
mod semihost;

use core::fmt;

use cortex_m::Peripherals;
use cortex_m_rt::{ExceptionFrame, entry, exception};
use cortex_m_semihosting::{heprintln, hprintln};
use quadcal::replay::{Event, HEADER_LEN, Header, RECORD_LEN, ReplayError, Tally};

use counter::InstructionCounter;
use semihost::{File, IoError, Mode};

/// Makes a change of the memory layout rebuild the image; the linker finds the file by itself.
const _: &[u8] = include_bytes!("../../../memory.x");

/// Bytes read from the host in one go: a semihosting call costs far more than the work on one record.
const BLOCK: usize = 8192;

/// Why a run failed.
enum Failure {
    Usage,
    PeripheralsTaken,
    Io(IoError),
    Format { offset: usize, error: ReplayError },
    Truncated { offset: usize },
}

impl From<IoError> for Failure {
    fn from(error: IoError) -> Self {
        Self::Io(error)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage => f.write_str("usage: qemu_replay EVENTS RESULT"),
            Self::PeripheralsTaken => f.write_str("the peripherals are taken"),
            Self::Io(error) => error.fmt(f),
            Self::Format { offset, error } => write!(f, "byte {offset}: {error}"),
            Self::Truncated { offset } => write!(f, "byte {offset}: the file ends inside a record"),
        }
    }
}

/// What one run cost.
struct Cost {
    events: u32,
    instructions: u64,
}

#[entry]
fn main() -> ! {
    // The entry attribute hands these out as unique references: safe, and off the stack.
    static mut LINE: [u8; 256] = [0; 256];
    static mut BUFFER: [u8; BLOCK] = [0; BLOCK];
    match run(LINE, BUFFER) {
        Ok(cost) => {
            hprintln!(
                "events={} instructions={} stack_bytes={} static_bytes={}",
                cost.events,
                cost.instructions,
                memory::stack_high_water(),
                memory::static_bytes()
            );
            semihost::exit(true)
        }
        Err(failure) => {
            heprintln!("error: {}", failure);
            semihost::exit(false)
        }
    }
}

fn run(line: &mut [u8], block: &mut [u8; BLOCK]) -> Result<Cost, Failure> {
    let timer = Peripherals::take().ok_or(Failure::PeripheralsTaken)?.SYST;
    let counter = InstructionCounter::start(timer);
    let mut words = semihost::command_line(line)?
        .split_ascii_whitespace()
        .skip(1);
    let (Some(events), Some(result), None) = (words.next(), words.next(), words.next()) else {
        return Err(Failure::Usage);
    };
    let (tally, cost) = replay(&mut File::open(events, Mode::Read)?, block, &counter)?;
    let mut out = File::open(result, Mode::Write)?;
    out.write(&tally.emit())?;
    out.close()?;
    Ok(cost)
}

fn replay(
    file: &mut File,
    block: &mut [u8; BLOCK],
    counter: &InstructionCounter,
) -> Result<(Tally, Cost), Failure> {
    let mut head = [0; HEADER_LEN];
    let got = file.read(&mut head)?;
    if got < HEADER_LEN {
        return Err(Failure::Truncated { offset: got });
    }
    let header = Header::parse(&head).map_err(|error| Failure::Format { offset: 0, error })?;
    let mut tally = Tally::default();
    let mut cost = Cost {
        events: 0,
        instructions: 0,
    };
    let mut offset = HEADER_LEN;
    loop {
        let got = file.read(block)?;
        let (records, rest) = block[..got].as_chunks::<RECORD_LEN>();
        let begin = counter.now();
        for record in records {
            let event = Event::parse(record, header.timer)
                .map_err(|error| Failure::Format { offset, error })?;
            tally.add(&event);
            offset += RECORD_LEN;
            cost.events += 1;
        }
        cost.instructions += counter.now() - begin;
        if !rest.is_empty() {
            return Err(Failure::Truncated { offset });
        }
        if got < BLOCK {
            return Ok((tally, cost));
        }
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    heprintln!("{}", info);
    semihost::exit(false)
}

// SAFETY: cortex-m-rt asks for `unsafe` because a hard fault handler may run with any state broken; this one only reads
// its frame and ends the run.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    heprintln!("hard fault at {:#010x}", frame.pc());
    semihost::exit(false)
}

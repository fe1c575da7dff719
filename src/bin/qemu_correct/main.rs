//! Corrects an event file in QEMU with a table that was learned before ([`quadcal::replay::correct`]), and writes the corrected edges
//! back. It fits a Cortex-M0 with 16 KiB of RAM, for an encoder of up to 480 lines.
//!
//! Command line: `qemu_correct EVENTS SLOT CORRECTED`. Prints a line of `key=value` pairs for the test to read.
#![no_std]
#![no_main]

#[path = "../qemu/memory.rs"]
mod memory;
#[path = "../qemu/mod.rs"]
mod qemu;

use core::fmt;

use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use quadcal::replay::{self, SessionError};
use quadcal::slot::{Slot, SlotError};

use qemu::output::Output;
use qemu::semihost::{self, File, IoError, Mode};

/// Bytes that go to or come from the host in one semihosting call, which costs far more than the work on one record.
const BLOCK: usize = 512;

/// All memory besides the stack.
struct Memory {
    line: [u8; 256],
    input: [u8; BLOCK],
    output: [u8; BLOCK],
    slot: [u8; 4096],
}

/// Why a run failed.
enum Failure {
    Usage,
    Io(IoError),
    Slot(SlotError),
    Session(SessionError<IoError>),
}

impl From<IoError> for Failure {
    fn from(error: IoError) -> Self {
        Self::Io(error)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage => f.write_str("usage: qemu_correct EVENTS SLOT CORRECTED"),
            Self::Io(error) => error.fmt(f),
            Self::Slot(error) => write!(f, "{error:?}"),
            Self::Session(error) => error.fmt(f),
        }
    }
}

#[entry]
fn main() -> ! {
    // The entry attribute hands this out as a unique reference: safe, and off the stack.
    static mut MEMORY: Memory = Memory {
        line: [0; 256],
        input: [0; BLOCK],
        output: [0; BLOCK],
        slot: [0; 4096],
    };
    qemu::finish(run(MEMORY))
}

fn run(memory: &mut Memory) -> Result<(), Failure> {
    let mut words = semihost::command_line(&mut memory.line)?
        .split_ascii_whitespace()
        .skip(1);
    let (Some(events), Some(slot), Some(corrected), None) =
        (words.next(), words.next(), words.next(), words.next())
    else {
        return Err(Failure::Usage);
    };
    let length = File::open(slot, Mode::Read)?.read(&mut memory.slot)?;
    let slot = memory.slot.get(..length).unwrap_or_default();
    let slot = Slot::parse(slot).map_err(Failure::Slot)?;
    let mut input = File::open(events, Mode::Read)?;
    let mut output = Output::new(corrected, &mut memory.output);
    let source = |block: &mut [u8]| input.read(block);
    let edges = replay::correct(source, &mut memory.input, &slot, |bytes| {
        output.write(bytes)
    });
    let edges = edges.map_err(Failure::Session)?;
    output.close()?;
    hprintln!(
        "corrected={} stack_bytes={} static_bytes={}",
        edges,
        memory::stack_high_water(),
        memory::static_bytes()
    );
    Ok(())
}

//! The body of the replay images: takes an event file from the host, learns and corrects as a drive would
//! ([`quadcal::replay::run`]), and writes table and corrected edges back.
//!
//! Command line: `IMAGE EVENTS SLOT CORRECTED`. Prints one line of `key=value` pairs for the test to read.

#[path = "memory.rs"]
mod memory;

use core::fmt;

use cortex_m_semihosting::hprintln;
use quadcal::estimate::StaticBuffers;
use quadcal::replay::{self, Part, Report, SessionError};

use crate::qemu::output::Output;
use crate::qemu::semihost::{self, File, IoError, Mode};

/// Bytes that go to or come from the host in one semihosting call, which costs far more than the work on one record.
const BLOCK: usize = 512;

/// All memory of an image for `M` lines besides its stack; a `static` of the image.
pub struct Memory<const M: usize> {
    buffers: StaticBuffers<M, 4, 1000>,
    line: [u8; 256],
    input: [u8; BLOCK],
    output: [u8; BLOCK],
}

impl<const M: usize> Memory<M> {
    /// Zeroed memory.
    pub const fn new() -> Self {
        Self {
            buffers: StaticBuffers::new(),
            line: [0; 256],
            input: [0; BLOCK],
            output: [0; BLOCK],
        }
    }
}

/// The entry point of an image that replays for an encoder of so many lines; wants `qemu` and `replay` at the crate's root.
macro_rules! replay_image {
    ($lines:literal) => {
        #[cortex_m_rt::entry]
        fn main() -> ! {
            // The entry attribute hands this out as a unique reference: safe, and off the stack.
            static mut MEMORY: $crate::replay::Memory<$lines> = $crate::replay::Memory::new();
            $crate::qemu::finish($crate::replay::run(MEMORY))
        }
    };
}

/// Why a run failed.
pub enum Failure {
    Usage,
    Io(IoError),
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
            Self::Usage => f.write_str("usage: IMAGE EVENTS SLOT CORRECTED"),
            Self::Io(error) => error.fmt(f),
            Self::Session(error) => error.fmt(f),
        }
    }
}

/// Does the work and prints what it took.
pub fn run<const M: usize>(memory: &mut Memory<M>) -> Result<(), Failure> {
    let report = session(memory)?;
    hprintln!(
        "turns={} broken={} irregular={} speed_change={} corrected={} stack_bytes={} static_bytes={}",
        report.learned.turns,
        report.learned.broken,
        report.learned.irregular,
        report.learned.speed_change,
        report.corrected,
        memory::stack_high_water(),
        memory::static_bytes()
    );
    Ok(())
}

fn session<const M: usize>(memory: &mut Memory<M>) -> Result<Report, Failure> {
    let mut words = semihost::command_line(&mut memory.line)?
        .split_ascii_whitespace()
        .skip(1);
    let (Some(events), Some(slot), Some(corrected), None) =
        (words.next(), words.next(), words.next(), words.next())
    else {
        return Err(Failure::Usage);
    };
    let mut input = File::open(events, Mode::Read)?;
    let mut output = Output::new(slot, &mut memory.output);
    let mut writing = Part::Slot;
    let sink = |part, bytes: &[u8]| {
        if part != writing {
            writing = part;
            output.turn_to(corrected)?;
        }
        output.write(bytes)
    };
    let source = |block: &mut [u8]| input.read(block);
    let report = replay::run(source, &mut memory.input, &mut memory.buffers, sink)
        .map_err(Failure::Session)?;
    output.close()?;
    Ok(report)
}

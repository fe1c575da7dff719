//! Keeps tables in a flash that is a file of the host, in QEMU.
//!
//! Command line: `qemu_store FLASH [commit N | loop | roll-back | erase]`, FLASH being made if it is not there. Says which table
//! counts; then commits N tables, or tables without end, or withdraws the newest or all, and says what counts then. The table
//! of a sequence number is known, so each is compared byte by byte.
#![no_std]
#![no_main]

#[path = "../qemu/flash.rs"]
mod flash;
#[path = "../qemu/mod.rs"]
mod qemu;
#[path = "../tables/mod.rs"]
mod tables;

use core::fmt;

use cortex_m_rt::entry;
use quadcal::store::StoreError;

use flash::{FileFlash, FileFlashError};
use qemu::semihost::{self, IoError};
use tables::{EDGES, Tables};

/// Why a run failed.
enum Failure {
    Usage,
    Io(IoError),
    Tables(tables::Failure<FileFlashError>),
}

impl From<IoError> for Failure {
    fn from(error: IoError) -> Self {
        Self::Io(error)
    }
}

impl From<tables::Failure<FileFlashError>> for Failure {
    fn from(error: tables::Failure<FileFlashError>) -> Self {
        Self::Tables(error)
    }
}

impl From<StoreError<FileFlashError>> for Failure {
    fn from(error: StoreError<FileFlashError>) -> Self {
        Self::Tables(error.into())
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage => {
                f.write_str("usage: qemu_store FLASH [commit N | loop | roll-back | erase]")
            }
            Self::Io(error) => error.fmt(f),
            Self::Tables(error) => error.fmt(f),
        }
    }
}

#[entry]
fn main() -> ! {
    // The entry attribute hands these out as unique references: safe, and off the stack.
    static mut ENTRIES: [i16; EDGES] = [0; EDGES];
    static mut LINE: [u8; 256] = [0; 256];
    qemu::finish(run(LINE, ENTRIES))
}

fn run(line: &mut [u8], entries: &mut [i16; EDGES]) -> Result<(), Failure> {
    let mut words = semihost::command_line(line)?.split_ascii_whitespace();
    let path = words.nth(1).ok_or(Failure::Usage)?;
    let (command, number) = (words.next(), words.next());
    let mut tables = Tables::new(FileFlash::open(path)?, entries)?;
    tables.report()?;
    match (command, number) {
        (None, _) => return Ok(()),
        (Some("commit"), Some(number)) => {
            for _ in 0..number.parse().map_err(|_| Failure::Usage)? {
                tables.commit()?;
            }
        }
        (Some("loop"), None) => loop {
            tables.commit()?;
        },
        (Some("roll-back"), None) => drop(tables.store().roll_back()?),
        (Some("erase"), None) => tables.store().erase()?,
        _ => return Err(Failure::Usage),
    }
    tables.report()?;
    Ok(())
}

//! Keeps tables in the flash of a real STM32F405: `cargo board --bin board_store`. Says which table counts, commits the next one,
//! and says what counts then; once more after a reset, it goes on from there.
//!
//! QEMU has no such flash: there it ends with what the driver says to that.
#![no_std]
#![no_main]

#[path = "../stm32f405/interface.rs"]
mod interface;
#[path = "../qemu/mod.rs"]
mod qemu;
#[path = "../tables/mod.rs"]
mod tables;

use core::fmt;

use cortex_m_rt::entry;
use quadcal::stm32f405::{Flash, FlashError, Supply};

use interface::FlashInterface;
use tables::{EDGES, Tables};

/// The chip starts on its internal oscillator, and this image leaves it there.
const CORE_HZ: u32 = 16_000_000;

/// Why a run failed.
enum Failure {
    InterfaceTaken,
    Tables(tables::Failure<FlashError>),
}

impl From<tables::Failure<FlashError>> for Failure {
    fn from(error: tables::Failure<FlashError>) -> Self {
        Self::Tables(error)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::InterfaceTaken => f.write_str("the flash interface is taken"),
            Self::Tables(error) => error.fmt(f),
        }
    }
}

#[entry]
fn main() -> ! {
    // The entry attribute hands this out as a unique reference: safe, and off the stack.
    static mut ENTRIES: [i16; EDGES] = [0; EDGES];
    qemu::finish(run(ENTRIES))
}

fn run(entries: &mut [i16; EDGES]) -> Result<(), Failure> {
    let interface = FlashInterface::take().ok_or(Failure::InterfaceTaken)?;
    let flash = Flash::new(interface, interface::room(), Supply::From2V7, CORE_HZ);
    let mut tables = Tables::new(flash, entries)?;
    tables.report()?;
    tables.commit()?;
    tables.report()?;
    Ok(())
}

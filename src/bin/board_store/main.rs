//! Keeps tables in the flash of a real STM32F405: `cargo board --bin board_store`. Says which table counts, commits the next one,
//! and says what counts then; once more after a reset, it goes on from there. At last a turn of edges is corrected with the table
//! that counts, where it lies in flash.
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
use cortex_m_semihosting::hprintln;
use quadcal::corrector::Corrector;
use quadcal::device::MappedFlash;
use quadcal::edge::Direction;
use quadcal::estimate::Anchor;
use quadcal::shape::Grid;
use quadcal::slot::Slot;
use quadcal::step::{Flags, Outcome, Step};
use quadcal::stm32f405::{self, Flash, FlashError, Supply};
use quadcal::store::Found;

use interface::{FlashInterface, MappedSlots};
use tables::{EDGES, Tables};

/// The chip starts on its internal oscillator, and this image leaves it there.
const CORE_HZ: u32 = 16_000_000;

/// Why a run failed.
enum Failure {
    InterfaceTaken,
    /// The table that counts can't be used where it lies.
    NotInPlace,
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
            Self::NotInPlace => f.write_str("the table can't be used where it lies"),
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
    let layout = stm32f405::layout(&flash).map_err(tables::Failure::Layout)?;
    let mut tables = Tables::new(flash, entries)?;
    tables.report()?;
    tables.commit()?;
    tables.report()?;
    // SAFETY: nothing is written or erased any more.
    let slots = unsafe { MappedSlots::new(layout) };
    let newest = tables.store().newest().map_err(tables::Failure::from)?;
    let largest = newest.and_then(|found| correct_a_turn(slots.bytes(found.offset)?, &found));
    let largest = largest.ok_or(Failure::NotInPlace)?;
    hprintln!("corrected edges={} largest={}", EDGES, largest);
    Ok(())
}

/// Corrects a turn with a slot's table in place; the largest error taken off, 2^-32 turn.
fn correct_a_turn(slot: &[u8], found: &Found) -> Option<u32> {
    let slot = Slot::parse(slot).ok()?;
    let table = slot.table_at(CORE_HZ.into()).ok()?;
    let mut corrector = Corrector::new(table, Anchor::Index);
    let grid = Grid::new(found.header.shape);
    let mut largest = 0;
    for edge in 0..found.header.shape.edges() {
        let corrected = corrector.push(&Outcome::Step(Step {
            ticks: 1000 * u64::from(edge),
            edge,
            position: edge,
            interval: 1000,
            resync: 0,
            advance: 1,
            flags: Flags::REFERENCED,
            direction: Direction::Forward,
        }))?;
        let off = grid.angle(edge).minus(corrected.angle);
        largest = largest.max(off.0.unsigned_abs());
    }
    (slot.header == found.header).then_some(largest)
}

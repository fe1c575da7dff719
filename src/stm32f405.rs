//! The STM32F405's own flash, for [`crate::store`].
//!
//! Chapter 3 of the reference manual RM0090 says how the flash is driven, the data sheet DS8626 how long that takes.
//! [`Flash`] follows the manual's sequences over [`Interface`], the few accesses that a board makes to registers and memory.
//!
//! While a sector is erased or a word written, the chip's only bank can't be read: code in flash stands still, interrupt
//! handlers too, for up to 1 s while place A is erased and 1.1 s for place B (1.6 s and 2.4 s below 2.1 V). So a drive commits
//! at standstill, or has its edge path and vectors in RAM meanwhile, and a watchdog must wait as long.
//!
//! ```text
//! sector   offset     size
//!      0   0x00000  16 KiB  vectors
//!      1   0x04000  16 KiB  free, for a boot loader
//!      2   0x08000  16 KiB  place A
//!      3   0x0C000  16 KiB  place A
//!      4   0x10000  64 KiB  place B
//!   5-11   0x20000  128 KiB each, the program
//! ```
//!
//! A table of 2500 lines does not fit one of the small sectors, so place A takes two. Sectors 2 and 3, not 1 and 2, leave 32
//! KiB in one piece before them. The places lie below the 128 KiB sectors, whose erasure takes up to twice as long.

mod error;
mod flash;
mod interface;
mod sectors;
mod supply;

#[cfg(test)]
mod tests;

pub use error::{FlashError, Refusal};
pub use flash::Flash;
pub use interface::{Interface, Register, Unit};
pub use sectors::{CAPACITY, SECTORS, is_border, sector_at, sector_start};
pub use supply::Supply;

use core::ops::Range;

use embedded_storage::nor_flash::NorFlash;

use crate::store::{Layout, LayoutError};

/// Offsets that are kept free of program for the two places.
pub const ROOM: Range<u32> = sector_start(2)..sector_start(5);

/// Offsets of place A and place B.
pub const PLACES: [Range<u32>; 2] = [
    sector_start(2)..sector_start(4),
    sector_start(4)..sector_start(5),
];

/// Erasures of a sector that the data sheet promises (DS8626, "endurance and data retention").
pub const ERASURES_MAX: u32 = 10_000;

/// [`PLACES`] in a flash with the STM32F405's sectors.
///
/// # Errors
/// [`LayoutError`] where the flash is too small or is written in other pieces.
pub fn layout<F: NorFlash>(flash: &F) -> Result<Layout, LayoutError> {
    Layout::on_sectors(flash, PLACES, ERASURES_MAX, is_border)
}

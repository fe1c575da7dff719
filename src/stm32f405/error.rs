//! What can go wrong.

use embedded_storage::nor_flash::{NorFlashError, NorFlashErrorKind};

/// What the controller says when it does not do what it should.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refusal {
    /// `WRPERR`: the sector is write-protected by the option bytes.
    WriteProtected,
    /// `PGSERR`: written without having been asked to.
    Sequence,
    /// `PGPERR`: an access of another size than `PSIZE`.
    Parallelism,
    /// `PGAERR`: an access across a row of 128 bits.
    Alignment,
    /// `OPERR`: an operation that it can't do.
    Operation,
}

/// Why the flash was not read, written or erased; offsets are bytes from its start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FlashError {
    /// Not whole words, or not whole sectors.
    NotAligned,
    /// Beyond the flash.
    OutOfBounds,
    /// Outside the room that the driver was given: vectors or program.
    NotOurs,
    /// The controller does not open for its keys, as a wrong one was written to it before: it stays shut until reset. On the chip
    /// the attempt is a bus error too, so the board's fault handler may hear of it first.
    Locked,
    /// The controller does not keep what is written to its control register.
    Deaf,
    /// The controller was still busy after the longest time that this may take.
    Timeout,
    /// The controller refused.
    Refused {
        /// The unit or sector.
        at: u32,
        /// What it said.
        why: Refusal,
    },
    /// This word does not read as it was written.
    Mismatch(u32),
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::NotAligned => NorFlashErrorKind::NotAligned,
            Self::OutOfBounds | Self::NotOurs => NorFlashErrorKind::OutOfBounds,
            _ => NorFlashErrorKind::Other,
        }
    }
}

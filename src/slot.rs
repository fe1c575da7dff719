//! The bytes of one error table, in a file or a flash slot, and the rule that makes them valid.
//!
//! All numbers are little-endian.
//!
//! ```text
//! offset  size  field
//!      0     4  magic "QCTB"
//!      4     2  format version, 2
//!      6     1  edge classes C (1..=6)
//!      7     1  entry shift: an entry counts 2^shift of 2^-32 turn
//!      8     4  edges a turn N
//!     12     4  turns that the table was learned from
//!     16     4  flags; bit 0: edge 0 is at the index (else it was the recording's first edge)
//!     20     4  standard error of a line position error, 2^-32 turn
//!     24     4  standard error of a class offset, 2^-32 turn
//!     28     4  source: CRC-32 of the start of the recording learned from, 0 on a device
//!     32     8  last tick learned from
//!     40    24  class offsets, six signed words, 2^-32 turn; those beyond C are zero
//!     64    24  class delays, six signed words, 2^-8 tick; those beyond C are zero
//!     88     4  standard error of a class delay, 2^-8 tick
//!     92     8  clock whose ticks the delays count, hertz; 0 only where all delays are zero
//!    100    60  reserved, written as zero and not looked at: zero will mean "not given"
//!    160    2N  entries, signed 16-bit, edge 0 first
//! 160+2N   0/2  zero bytes up to a multiple of four
//!    end     4  CRC-32 (ISO-HDLC) over every byte before it
//! ```
//!
//! A slot is valid when magic and version are known, every field is in range, and the CRC agrees.
//!
//! Version 1 has its entries at byte 64 and no delays; it is still read. The folder `slot/data` keeps a slot of every version
//! ever written, and a test reads them all.

mod header;

use crc::{CRC_32_ISO_HDLC, Crc, Digest, Table};

use crate::shape::{EncoderShape, ShapeError};
use crate::table::{Entry, ErrorTable, TableError};
use header::{Fields, header_bytes};

pub use header::{Delays, HEADER_BYTES, HEADER_BYTES_V1, SlotHeader};

/// First bytes of every slot.
pub const MAGIC: [u8; 4] = *b"QCTB";

/// Format version written by this code.
pub const VERSION: u16 = 2;

/// Bytes of the CRC at the end.
const CRC_BYTES: usize = 4;

// The 16-entry table: a slot is checked once, and 64 bytes of flash are cheaper than a kilobyte.
const CRC32: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// Why bytes are not a valid slot; positions are byte offsets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SlotError {
    /// Shorter than the slot says or than any slot.
    Truncated {
        /// Bytes that there should be.
        needed: usize,
        /// Bytes that there are.
        found: usize,
    },
    /// Bytes 0..4 are not the magic: this is no table.
    Magic([u8; 4]),
    /// Bytes 4..6: a version that this code does not know.
    Version(u16),
    /// The shape at bytes 6 and 8 is out of range.
    Shape(ShapeError),
    /// The scale at byte 7 is out of range.
    Table(TableError),
    /// Bytes 64..100: delays without the clock in whose ticks they are.
    Clock,
    /// The CRC differs: bytes were changed or are missing.
    Crc {
        /// CRC stored at the end.
        stored: u32,
        /// CRC of the bytes before.
        computed: u32,
    },
}

/// A valid slot: its header and its entries in place.
#[derive(Clone, Copy, Debug)]
pub struct Slot<'a> {
    /// What the slot says of itself.
    pub header: SlotHeader,
    entries: &'a [[u8; 2]],
}

/// Bytes of a slot for an encoder's shape as this code writes it, CRC included.
#[must_use]
pub const fn slot_bytes(shape: EncoderShape) -> usize {
    bytes_behind(HEADER_BYTES, shape)
}

const fn bytes_behind(header: usize, shape: EncoderShape) -> usize {
    (header + 2 * shape.edges() as usize).next_multiple_of(4) + CRC_BYTES
}

impl<'a> Slot<'a> {
    /// Checks the slot at the start of `bytes`, of any version; what follows it is ignored.
    ///
    /// # Errors
    /// [`SlotError`] says which field is wrong.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, SlotError> {
        let truncated = |needed| SlotError::Truncated {
            needed,
            found: bytes.len(),
        };
        let shortest = HEADER_BYTES_V1 + CRC_BYTES;
        let [m0, m1, m2, m3, v0, v1, ..] = *bytes.get(..shortest).ok_or(truncated(shortest))?
        else {
            return Err(truncated(shortest));
        };
        let magic = [m0, m1, m2, m3];
        if magic != MAGIC {
            return Err(SlotError::Magic(magic));
        }
        let head = header_bytes(u16::from_le_bytes([v0, v1]))?;
        let fields = Fields::new(bytes.get(..head).ok_or(truncated(head + CRC_BYTES))?);
        let shape = fields.shape()?;
        let whole = bytes_behind(head, shape);
        let (body, crc) = bytes
            .get(..whole)
            .and_then(|slot| slot.split_last_chunk())
            .ok_or(truncated(whole))?;
        let (stored, computed) = (u32::from_le_bytes(*crc), CRC32.checksum(body));
        if stored != computed {
            return Err(SlotError::Crc { stored, computed });
        }
        let header = fields.header()?;
        let entries = body[head..].as_chunks().0;
        let entries = &entries[..shape.edges() as usize];
        let slot = Self { header, entries };
        slot.angles().map_err(SlotError::Table)?;
        Ok(slot)
    }

    /// The table, used in place, for edges stamped by a clock of `clock_hz`.
    ///
    /// # Errors
    /// [`TableError::Clock`] when the delays can't be told in ticks of that clock: it is 0 Hz, or they are too long. A slot
    /// without delays always gives its table.
    pub fn table_at(&self, clock_hz: u64) -> Result<ErrorTable<'a, [u8; 2]>, TableError> {
        let wrong = TableError::Clock(clock_hz);
        if clock_hz == 0 && !self.header.delays.is_zero() {
            return Err(wrong);
        }
        let delays = self.header.delays.at_clock(clock_hz).ok_or(wrong)?;
        Ok(self.angles()?.with_delays(delays))
    }

    /// The table without its delays, used in place: angles alone, for any clock.
    ///
    /// # Errors
    /// Never for a parsed slot: its scale and length were checked.
    pub const fn angles(&self) -> Result<ErrorTable<'a, [u8; 2]>, TableError> {
        ErrorTable::new(
            self.header.shape,
            self.header.class_offsets,
            self.entries,
            self.header.shift,
        )
    }
}

/// Writes a slot piece by piece to `sink`, in order; pieces are multiples of four bytes. Stops at the sink's first error.
///
/// # Errors
/// The sink's.
pub fn write<E: Entry, F: FnMut(&[u8]) -> Result<(), X>, X>(
    header: &SlotHeader,
    entries: &[E],
    mut sink: F,
) -> Result<(), X> {
    let mut digest: Digest<'_, u32, Table<1>> = CRC32.digest();
    let mut put = |bytes: &[u8]| {
        digest.update(bytes);
        sink(bytes)
    };
    put(&header.emit())?;
    for pair in entries.chunks(2) {
        let mut bytes = [0; 4];
        for (cell, entry) in bytes.as_chunks_mut::<2>().0.iter_mut().zip(pair) {
            *cell = entry.value().to_le_bytes();
        }
        put(&bytes)?;
    }
    let crc = digest.finalize();
    sink(&crc.to_le_bytes())
}

#[cfg(test)]
mod tests;

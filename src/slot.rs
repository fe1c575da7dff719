//! The bytes of one error table, in a file or a flash slot, and the rule that makes them valid.
//!
//! All numbers are little-endian.
//!
//! ```text
//! offset  size  field
//!      0     4  magic "QCTB"
//!      4     2  format version, 3
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
//!    100     8  serial number of the encoder, 0: not given
//!    108     8  when it was learned, seconds since 1970, 0: not given
//!    116     2  temperature then, signed, 1/16 degree Celsius
//!    118     2  1 where the temperature is given
//!    120     4  sequence: of two valid slots the later one counts, see [`crate::store`]
//!    124     4  RMS of the error that the table holds, 2^-32 turn, 0: not given
//!    128    32  reserved, written as zero and not looked at: zero will mean "not given"
//!    160    2N  entries, signed 16-bit, edge 0 first
//! 160+2N   0/2  zero bytes up to a multiple of four
//!    end     4  CRC-32 (ISO-HDLC) over every byte before it
//! ```
//!
//! A slot is valid when magic and version are known, every field is in range, and the CRC agrees.
//!
//! Version 1 has its entries at byte 64 and no delays; version 2 has nothing in bytes 100 to 160. Both are still read. The folder `slot/data` keeps a slot of every version
//! ever written, and a test reads them all.

mod header;

use core::convert::Infallible;

use crc::{CRC_32_ISO_HDLC, Crc, Digest, Table};

use crate::shape::{EncoderShape, ShapeError};
use crate::table::{Entry, ErrorTable, TableError};
use header::{Fields, header_bytes};

pub use header::{Delays, HEADER_BYTES, HEADER_BYTES_V1, SlotHeader, Stamp};

/// First bytes of every slot.
pub const MAGIC: [u8; 4] = *b"QCTB";

/// Format version written by this code.
pub const VERSION: u16 = 3;

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
        let copy = |at: usize, piece: &mut [u8]| {
            let there = bytes.get(at..).unwrap_or_default();
            for (cell, byte) in piece.iter_mut().zip(there) {
                *cell = *byte;
            }
            Ok::<(), Infallible>(())
        };
        let Ok(checked) = check(bytes.len(), copy);
        let (header, head) = checked?;
        let entries = bytes.get(head..).unwrap_or_default().as_chunks().0;
        let edges = header.shape.edges() as usize;
        Ok(Self {
            header,
            entries: entries.get(..edges).unwrap_or_default(),
        })
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

/// Checks a slot of any version that `read` gives piece by piece, in pieces of 32 bytes or a multiple, from where it starts; what is
/// read beyond `room` bytes does not matter. The header, and how many bytes it has.
///
/// # Errors
/// Those of `read`; within, [`SlotError`].
pub(crate) fn check<X>(
    room: usize,
    mut read: impl FnMut(usize, &mut [u8]) -> Result<(), X>,
) -> Result<Result<(SlotHeader, usize), SlotError>, X> {
    let mut head = [0; HEADER_BYTES];
    read(0, &mut head)?;
    let (fields, head) = match frame(&head, room) {
        Ok(frame) => frame,
        Err(error) => return Ok(Err(error)),
    };
    let mut digest: Digest<'_, u32, Table<1>> = CRC32.digest();
    let mut stored = [0; CRC_BYTES];
    let mut piece = [0; 32];
    for at in (0..head.whole).step_by(piece.len()) {
        read(at, &mut piece)?;
        let body = head.whole - CRC_BYTES - at.min(head.whole - CRC_BYTES);
        let (body, rest) = piece.split_at(body.min(piece.len()));
        digest.update(body);
        // Body and piece are whole words, so the CRC is in one piece.
        if let Some(crc) = rest.first_chunk() {
            stored = *crc;
        }
    }
    let (stored, computed) = (u32::from_le_bytes(stored), digest.finalize());
    Ok(if stored == computed {
        fields.header().map(|header| (header, head.bytes))
    } else {
        Err(SlotError::Crc { stored, computed })
    })
}

/// How long a slot is.
struct Frame {
    /// Bytes of its header.
    bytes: usize,
    /// All bytes.
    whole: usize,
}

/// What a slot's first bytes say of its size.
fn frame(head: &[u8; HEADER_BYTES], room: usize) -> Result<(Fields, Frame), SlotError> {
    let truncated = |needed| SlotError::Truncated {
        needed,
        found: room,
    };
    let shortest = HEADER_BYTES_V1 + CRC_BYTES;
    if room < shortest {
        return Err(truncated(shortest));
    }
    let [m0, m1, m2, m3, v0, v1, ..] = *head;
    let magic = [m0, m1, m2, m3];
    if magic != MAGIC {
        return Err(SlotError::Magic(magic));
    }
    let bytes = header_bytes(u16::from_le_bytes([v0, v1]))?;
    let fields = Fields::new(&head[..bytes]);
    let whole = bytes_behind(bytes, fields.shape()?);
    if room < whole {
        return Err(truncated(whole));
    }
    Ok((fields, Frame { bytes, whole }))
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

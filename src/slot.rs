//! The bytes of one error table, in a file or a flash slot, and the rule that makes them valid.
//!
//! All numbers are little-endian.
//!
//! ```text
//! offset  size  field
//!      0     4  magic "QCTB"
//!      4     2  format version, 1
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
//!     64    2N  entries, signed 16-bit, edge 0 first
//!  64+2N   0/2  zero bytes up to a multiple of four
//!    end     4  CRC-32 (ISO-HDLC) over every byte before it
//! ```
//!
//! A slot is valid when magic and version are known, every field is in range, and the CRC agrees.

use crc::{CRC_32_ISO_HDLC, Crc, Digest, Table};

use crate::shape::{CLASSES_MAX, EncoderShape, ShapeError};
use crate::table::{Entry, ErrorTable, TableError};
use crate::units::TurnDelta32;

/// First bytes of every slot.
pub const MAGIC: [u8; 4] = *b"QCTB";

/// Format version written by this code.
pub const VERSION: u16 = 1;

/// Bytes before the entries.
pub const HEADER_BYTES: usize = 64;

const FLAG_INDEXED: u32 = 1;

// The 16-entry table: a slot is checked once, and 64 bytes of flash are cheaper than a kilobyte.
const CRC32: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// What a slot says besides its entries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SlotHeader {
    /// The encoder's shape.
    pub shape: EncoderShape,
    /// Scale of the entries.
    pub shift: u32,
    /// Turns that the table was learned from.
    pub turns: u32,
    /// Whether edge 0 is at the index.
    pub indexed: bool,
    /// Standard error of a line position error, 2^-32 turn.
    pub standard_error: u32,
    /// Standard error of a class offset, 2^-32 turn.
    pub class_standard_error: u32,
    /// CRC-32 of the start of the recording learned from, 0 on a device: a check on the same recording must use other turns.
    pub source: u32,
    /// Last tick learned from.
    pub learned_until: u64,
    /// Mean error of every class.
    pub class_offsets: [TurnDelta32; CLASSES_MAX],
}

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

/// Bytes of a slot for an encoder's shape, CRC included.
#[must_use]
pub const fn slot_bytes(shape: EncoderShape) -> usize {
    (HEADER_BYTES + 2 * shape.edges() as usize).next_multiple_of(4) + 4
}

impl<'a> Slot<'a> {
    /// Checks the slot at the start of `bytes`; what follows it is ignored.
    ///
    /// # Errors
    /// [`SlotError`] says which field is wrong.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, SlotError> {
        let truncated = |needed| SlotError::Truncated {
            needed,
            found: bytes.len(),
        };
        let head: &[u8; HEADER_BYTES] = bytes.first_chunk().ok_or(truncated(HEADER_BYTES + 4))?;
        let word =
            |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
        let magic = word(0).to_le_bytes();
        if magic != MAGIC {
            return Err(SlotError::Magic(magic));
        }
        let version = u16::from_le_bytes([head[4], head[5]]);
        if version != VERSION {
            return Err(SlotError::Version(version));
        }
        let shape = EncoderShape::new(word(8), u32::from(head[6])).map_err(SlotError::Shape)?;
        let whole = slot_bytes(shape);
        let body = bytes.get(..whole - 4).ok_or(truncated(whole))?;
        let stored = bytes[whole - 4..]
            .first_chunk()
            .copied()
            .map(u32::from_le_bytes)
            .ok_or(truncated(whole))?;
        let computed = CRC32.checksum(body);
        if stored != computed {
            return Err(SlotError::Crc { stored, computed });
        }
        let mut class_offsets = [TurnDelta32(0); CLASSES_MAX];
        for (class, offset) in class_offsets.iter_mut().enumerate() {
            *offset = TurnDelta32(word(40 + 4 * class).cast_signed());
        }
        let header = SlotHeader {
            shape,
            shift: u32::from(head[7]),
            turns: word(12),
            indexed: word(16) & FLAG_INDEXED != 0,
            standard_error: word(20),
            class_standard_error: word(24),
            source: word(28),
            learned_until: u64::from(word(32)) | (u64::from(word(36)) << 32),
            class_offsets,
        };
        let entries = body[HEADER_BYTES..].as_chunks().0;
        let entries = &entries[..shape.edges() as usize];
        ErrorTable::new(shape, class_offsets, entries, header.shift).map_err(SlotError::Table)?;
        Ok(Self { header, entries })
    }

    /// The table, used in place.
    ///
    /// # Errors
    /// Never for a parsed slot: its scale and length were checked.
    pub const fn table(&self) -> Result<ErrorTable<'a, [u8; 2]>, TableError> {
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
    let mut head = [0; HEADER_BYTES];
    let mut field = |at: usize, bytes: &[u8]| head[at..at + bytes.len()].copy_from_slice(bytes);
    field(0, &MAGIC);
    field(4, &VERSION.to_le_bytes());
    #[allow(clippy::cast_possible_truncation)]
    field(6, &[header.shape.classes() as u8, header.shift as u8]);
    field(8, &header.shape.edges().to_le_bytes());
    field(12, &header.turns.to_le_bytes());
    field(
        16,
        &if header.indexed { FLAG_INDEXED } else { 0 }.to_le_bytes(),
    );
    field(20, &header.standard_error.to_le_bytes());
    field(24, &header.class_standard_error.to_le_bytes());
    field(28, &header.source.to_le_bytes());
    field(32, &header.learned_until.to_le_bytes());
    for (class, offset) in header.class_offsets.iter().enumerate() {
        field(40 + 4 * class, &offset.0.to_le_bytes());
    }
    put(&head)?;
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
mod tests {
    extern crate std;
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn sample(edges: u32, classes: u32) -> (SlotHeader, Vec<i16>, Vec<u8>) {
        let mut class_offsets = [TurnDelta32(0); CLASSES_MAX];
        class_offsets[0] = TurnDelta32(-77);
        let header = SlotHeader {
            shape: EncoderShape::new(edges, classes).unwrap(),
            shift: 3,
            turns: 11,
            indexed: true,
            standard_error: 1234,
            class_standard_error: 5,
            source: 0x1234_5678,
            learned_until: 0x1_0000_0002,
            class_offsets,
        };
        let entries: Vec<i16> = (0..edges).map(|k| (k as i16).wrapping_mul(-321)).collect();
        let mut bytes = Vec::new();
        write(&header, &entries, |piece| {
            bytes.extend_from_slice(piece);
            Ok::<(), ()>(())
        })
        .unwrap();
        (header, entries, bytes)
    }

    #[test]
    fn a_slot_read_back_is_the_slot_written() {
        for (edges, classes) in [(12, 6), (9, 1), (10_000, 4)] {
            let (header, entries, mut bytes) = sample(edges, classes);
            assert_eq!(bytes.len(), slot_bytes(header.shape));
            bytes.extend_from_slice(&[0xFF; 7]);
            let slot = Slot::parse(&bytes).unwrap();
            assert_eq!(slot.header, header);
            let back: Vec<i16> = slot.entries.iter().map(|entry| entry.value()).collect();
            assert_eq!(back, entries);
        }
    }

    #[test]
    fn every_single_bit_flip_and_every_cut_is_found() {
        let (_, _, bytes) = sample(12, 6);
        for bit in 0..bytes.len() * 8 {
            let mut broken = bytes.clone();
            broken[bit / 8] ^= 1 << (bit % 8);
            assert!(Slot::parse(&broken).is_err(), "bit {bit}");
        }
        for length in 0..bytes.len() {
            assert!(
                matches!(
                    Slot::parse(&bytes[..length]),
                    Err(SlotError::Truncated { .. })
                ),
                "{length}"
            );
        }
    }

    proptest! {
        #[test]
        fn any_bytes_are_refused_without_panic(mut bytes in prop::collection::vec(any::<u8>(), 0..200), magic in any::<bool>()) {
            if magic && bytes.len() > 6 {
                bytes[..4].copy_from_slice(&MAGIC);
                bytes[4..6].copy_from_slice(&VERSION.to_le_bytes());
            }
            prop_assert!(Slot::parse(&bytes).is_err());
        }
    }
}

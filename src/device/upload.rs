//! A slot that is handed over piece by piece: its entries go to the room for them, the rest is kept here.

use core::convert::Infallible;

use crate::shape::EncoderShape;
use crate::slot::{self, HEADER_BYTES, SlotHeader, slot_bytes};
use crate::wire::TableFault;

/// Bytes after the entries at the most: two to fill up, and the CRC.
const TAIL_BYTES: usize = 6;

/// A slot that is coming in.
#[derive(Clone, Debug)]
pub(super) struct Upload {
    shape: EncoderShape,
    head: [u8; HEADER_BYTES],
    tail: [u8; TAIL_BYTES],
    received: usize,
}

impl Upload {
    /// Of an encoder of this shape.
    pub fn new(shape: EncoderShape) -> Self {
        Self {
            shape,
            head: [0; HEADER_BYTES],
            tail: [0; TAIL_BYTES],
            received: 0,
        }
    }

    /// Byte wanted next.
    #[allow(clippy::cast_possible_truncation)]
    pub const fn next(&self) -> u32 {
        self.received as u32
    }

    /// Whether all bytes are there.
    pub const fn is_whole(&self) -> bool {
        self.received == slot_bytes(self.shape)
    }

    /// Takes the next bytes; those beyond the slot's end are left.
    pub fn take(&mut self, bytes: &[u8], entries: &mut [i16]) {
        for byte in bytes {
            if self.is_whole() {
                break;
            }
            self.put(*byte, entries);
            self.received += 1;
        }
    }

    fn put(&mut self, byte: u8, entries: &mut [i16]) {
        let at = self.received;
        if let Some(cell) = self.head.get_mut(at) {
            *cell = byte;
            return;
        }
        let behind = at - HEADER_BYTES;
        let edges = self.shape.edges() as usize;
        if behind < 2 * edges {
            if let Some(entry) = entries.get_mut(behind / 2) {
                let [low, high] = entry.to_le_bytes();
                let bytes = if behind.is_multiple_of(2) {
                    [byte, high]
                } else {
                    [low, byte]
                };
                *entry = i16::from_le_bytes(bytes);
            }
        } else if let Some(cell) = self.tail.get_mut(behind - 2 * edges) {
            *cell = byte;
        }
    }

    fn byte(&self, at: usize, entries: &[i16]) -> u8 {
        if let Some(byte) = self.head.get(at) {
            return *byte;
        }
        let behind = at - HEADER_BYTES;
        let edges = self.shape.edges() as usize;
        let byte = if behind < 2 * edges {
            let entry = entries.get(behind / 2).copied().unwrap_or(0);
            entry.to_le_bytes().get(behind % 2).copied()
        } else {
            self.tail.get(behind - 2 * edges).copied()
        };
        byte.unwrap_or(0)
    }

    /// Checks a slot that is whole.
    ///
    /// # Errors
    /// [`TableFault::Header`], [`TableFault::Shape`] or [`TableFault::Crc`].
    pub fn check(&self, entries: &[i16]) -> Result<SlotHeader, TableFault> {
        let copy = |at: usize, piece: &mut [u8]| {
            for (cell, at) in piece.iter_mut().zip(at..) {
                *cell = self.byte(at, entries);
            }
            Ok::<(), Infallible>(())
        };
        let Ok(checked) = slot::check(slot_bytes(self.shape), copy);
        match checked {
            Ok((header, HEADER_BYTES)) if header.shape == self.shape => Ok(header),
            Ok((_, HEADER_BYTES)) => Err(TableFault::Shape),
            Err(slot::SlotError::Truncated { .. }) => Err(TableFault::Shape),
            Err(slot::SlotError::Crc { .. }) => Err(TableFault::Crc),
            _ => Err(TableFault::Header),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::tests::header;
    use std::vec::Vec;

    fn slot(edges: u32) -> Vec<u8> {
        let header = header(EncoderShape::new(edges, 1).unwrap(), 0);
        let entries: Vec<i16> = (0..edges as i16).map(|k| 300 * k - 5000).collect();
        let mut bytes = Vec::new();
        let sink = |piece: &[u8]| {
            bytes.extend_from_slice(piece);
            Ok::<(), Infallible>(())
        };
        let Ok(()) = slot::write(&header, &entries, sink);
        bytes
    }

    /// Takes a slot in pieces and checks it.
    fn take(bytes: &[u8], edges: u32, piece: usize) -> (Result<SlotHeader, TableFault>, Vec<i16>) {
        let mut upload = Upload::new(EncoderShape::new(edges, 1).unwrap());
        let mut entries = std::vec![0; edges as usize];
        for piece in bytes.chunks(piece) {
            upload.take(piece, &mut entries);
        }
        assert!(upload.is_whole());
        (upload.check(&entries), entries)
    }

    #[test]
    fn a_slot_comes_through_in_pieces_of_any_size() {
        for edges in [7, 8] {
            for piece in [1, 31, 128, 1000] {
                let (header, entries) = take(&slot(edges), edges, piece);
                assert_eq!(header.unwrap().shape.edges(), edges);
                assert!(
                    (0..)
                        .zip(&entries)
                        .all(|(k, entry)| *entry == 300 * k - 5000)
                );
            }
        }
    }

    #[test]
    fn any_bit_flipped_on_the_way_is_found() {
        let whole = slot(7);
        for bit in 0..8 * whole.len() {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(take(&bytes, 7, 128).0.is_err(), "bit {bit}");
        }
    }

    #[test]
    fn a_slot_of_another_shape_is_refused() {
        let mut longer = slot(8);
        assert_eq!(take(&longer, 7, 128).0, Err(TableFault::Shape));
        let mut shorter = slot(7);
        shorter.extend([0; 4]);
        assert_eq!(take(&shorter, 9, 128).0, Err(TableFault::Shape));
        longer[4] = 1;
        assert!(take(&longer, 8, 128).0.is_err());
    }
}

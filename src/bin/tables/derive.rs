//! A table that its sequence number alone decides, so that whoever reads it knows whether it is whole.

use quadcal::shape::{CLASSES_MAX, EncoderShape, ShapeError};
use quadcal::slot::{Delays, SlotHeader, Stamp};
use quadcal::units::TurnDelta32;

/// Edges a turn: the largest table of the design.
pub const EDGES: usize = 10_000;

/// The header of the table with this sequence number.
pub fn header(sequence: u32) -> Result<SlotHeader, ShapeError> {
    Ok(SlotHeader {
        shape: EncoderShape::new(EDGES as u32, 4)?,
        shift: 2,
        turns: 11,
        indexed: true,
        standard_error: sequence >> 8,
        class_standard_error: 1,
        source: 0,
        learned_until: u64::from(sequence) << 20,
        class_offsets: [TurnDelta32(entry(sequence, u32::MAX).into()); CLASSES_MAX],
        delays: Delays::NONE,
        stamp: Stamp {
            serial: 405,
            sequence,
            ..Stamp::default()
        },
    })
}

/// An entry of the table with this sequence number.
pub const fn entry(sequence: u32, edge: u32) -> i16 {
    let mut x = sequence.wrapping_mul(0x9E37_79B9) ^ edge.wrapping_mul(0x85EB_CA6B);
    x ^= x >> 15;
    x = x.wrapping_mul(0x2C1B_3C6D);
    (x >> 16).cast_signed() as i16
}

//! What the check of a slot lets pass: every single bit flipped, and random bytes.

use std::convert::Infallible;
use std::fmt;

use quadcal::shape::{CLASSES_MAX, EncoderShape, ShapeError};
use quadcal::slot::{self, Delays, MAGIC, Slot, SlotError, SlotHeader, Stamp, VERSION};
use quadcal::units::{TickDelta8, TurnDelta32};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Edges a turn of the largest table of the design.
pub const EDGES: u32 = 10_000;

/// What slots were taken for, or why they were refused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Slots looked at.
    pub tries: u64,
    /// Taken for valid.
    pub valid: u64,
    /// Refused for their magic.
    pub magic: u64,
    /// For their version.
    pub version: u64,
    /// For their shape.
    pub shape: u64,
    /// For being shorter than they say.
    pub truncated: u64,
    /// For their CRC.
    pub crc: u64,
    /// For another field, with the right CRC.
    pub field: u64,
}

impl Tally {
    fn count(&mut self, slot: Result<Slot<'_>, SlotError>) {
        self.tries += 1;
        *match slot {
            Ok(_) => &mut self.valid,
            Err(SlotError::Magic(_)) => &mut self.magic,
            Err(SlotError::Version(_)) => &mut self.version,
            Err(SlotError::Shape(_)) => &mut self.shape,
            Err(SlotError::Truncated { .. }) => &mut self.truncated,
            Err(SlotError::Crc { .. }) => &mut self.crc,
            Err(SlotError::Table(_) | SlotError::Clock) => &mut self.field,
        } += 1;
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} tries, {} taken for valid; refused: {} magic, {} version, {} shape, {} too short, {} CRC, {} another field",
            self.tries,
            self.valid,
            self.magic,
            self.version,
            self.shape,
            self.truncated,
            self.crc,
            self.field
        )
    }
}

/// Flips every `stride`-th bit of a slot for `edges` edges in four classes, one at a time, and checks the slot after each.
///
/// # Errors
/// `edges` is out of range.
pub fn flips(edges: u32, stride: usize) -> Result<Tally, ShapeError> {
    let mut bytes = sample(edges)?;
    let mut tally = Tally::default();
    for bit in (0..8 * bytes.len()).step_by(stride.max(1)) {
        let flip = 1 << (bit % 8);
        bytes[bit / 8] ^= flip;
        tally.count(Slot::parse(&bytes));
        bytes[bit / 8] ^= flip;
    }
    Ok(tally)
}

/// What a slot of random bytes has right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noise {
    /// Nothing.
    All,
    /// Magic, a known version, and a shape that fits: the CRC alone can refuse it.
    BehindHeader,
}

/// Checks `tries` slots of random bytes. They are for `edges` edges, or for any number up to [`EDGES`], small ones as often as
/// large ones (by powers of two).
///
/// # Errors
/// `edges` is out of range.
pub fn noise(noise: Noise, tries: u64, edges: Option<u32>, seed: u64) -> Result<Tally, ShapeError> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut bytes = Vec::new();
    let mut tally = Tally::default();
    for _ in 0..tries {
        let edges = edges.unwrap_or_else(|| {
            let bits = random.random_range(2..14);
            random.random_range(1_u32 << bits..2 << bits).min(EDGES)
        });
        let classes = (1..=CLASSES_MAX as u32)
            .rev()
            .find(|classes| edges.is_multiple_of(*classes));
        let shape = EncoderShape::new(edges, classes.unwrap_or(1))?;
        bytes.resize(slot::slot_bytes(shape), 0);
        random.fill_bytes(&mut bytes);
        if noise == Noise::BehindHeader {
            let version = random.random_range(1..=VERSION);
            bytes[..4].copy_from_slice(&MAGIC);
            bytes[4..6].copy_from_slice(&version.to_le_bytes());
            bytes[6] = shape.classes() as u8;
            bytes[8..12].copy_from_slice(&edges.to_le_bytes());
        }
        tally.count(Slot::parse(&bytes));
    }
    Ok(tally)
}

/// A slot with something in every field.
fn sample(edges: u32) -> Result<Vec<u8>, ShapeError> {
    let header = SlotHeader {
        shape: EncoderShape::new(edges, 4)?,
        shift: 3,
        turns: 11,
        indexed: true,
        standard_error: 1234,
        class_standard_error: 5,
        source: 0x1234_5678,
        learned_until: 0x1_0000_0002,
        class_offsets: [TurnDelta32(-77); CLASSES_MAX],
        delays: Delays {
            of_class: [TickDelta8(700); CLASSES_MAX],
            standard_error: 9,
            clock_hz: 84_000_000,
        },
        stamp: Stamp {
            serial: 0x0102_0304_0506_0708,
            learned_at: 1_790_000_000,
            temperature_q4: Some(-40),
            sequence: 7,
            table_rms: 98_765,
        },
    };
    let entries: Vec<i16> = (0..edges)
        .map(|edge| (edge as i16).wrapping_mul(-321))
        .collect();
    let mut bytes = Vec::with_capacity(slot::slot_bytes(header.shape));
    let Ok(()) = slot::write(&header, &entries, |piece| {
        bytes.extend_from_slice(piece);
        Ok::<(), Infallible>(())
    });
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flipped_bit_is_found_wherever_it_is() {
        assert!(Slot::parse(&sample(EDGES).unwrap()).is_ok());
        let small = flips(12, 1).unwrap();
        assert_eq!((small.tries, small.valid), (188 * 8, 0));
        let large = flips(EDGES, 41).unwrap();
        println!("{large}");
        assert_eq!((large.tries, large.valid), (20_164_u64 * 8 / 41 + 1, 0));
    }

    #[test]
    fn random_bytes_are_no_slot_and_a_right_header_leaves_it_to_the_crc() {
        let all = noise(Noise::All, 100_000, Some(12), 1).unwrap();
        assert_eq!((all.tries, all.valid), (100_000, 0));
        let behind = noise(Noise::BehindHeader, 20_000, None, 2).unwrap();
        assert_eq!((behind.crc, behind.valid), (20_000, 0));
    }
}

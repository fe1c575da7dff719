//! The bytes before a slot's entries, of every version.

use super::{MAGIC, SlotError, VERSION};
use crate::estimate::{ClassDelays, EdgeBuffers, Solution};
use crate::shape::{CLASSES_MAX, EncoderShape};
use crate::table::{SHIFT_MAX, TableError};
use crate::units::{TickDelta8, TurnDelta32};

/// Bytes before the entries in a slot of the version that is written.
pub const HEADER_BYTES: usize = 160;

/// Bytes before the entries in a slot of version 1.
pub const HEADER_BYTES_V1: usize = 64;

/// Largest number of bytes before the entries.
pub(super) type Head = [u8; HEADER_BYTES];

const FLAG_INDEXED: u32 = 1;

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
    /// Delays of the capture.
    pub delays: Delays,
    /// Whose table it is and since when.
    pub stamp: Stamp,
}

/// Whose table a slot holds and since when; what is not given is zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Stamp {
    /// Serial number of the encoder.
    pub serial: u64,
    /// When it was learned, seconds since 1970.
    pub learned_at: u64,
    /// Temperature then, 1/16 degree Celsius.
    pub temperature_q4: Option<i16>,
    /// Counts up from commit to commit; of two valid slots the later one counts.
    pub sequence: u32,
    /// RMS of the error that the table holds, class offsets included, 2^-32 turn.
    pub table_rms: u32,
}

/// Delays of the capture, and the clock in whose ticks they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Delays {
    /// How much later than the mean of all classes each electrical edge is captured; those beyond C are zero.
    pub of_class: [TickDelta8; CLASSES_MAX],
    /// Standard error of a class delay, 2^-8 tick; 0 where delays were not looked for.
    pub standard_error: u32,
    /// Tick rate of the clock, in hertz; 0 where there are no delays.
    pub clock_hz: u64,
}

impl Delays {
    /// The delays that a calibration found in ticks of a clock, or none.
    #[must_use]
    pub fn found(delays: Option<ClassDelays>, clock_hz: u64) -> Self {
        delays.map_or(Self::NONE, |delays| Self {
            of_class: delays.of_class,
            standard_error: delays.standard_error,
            clock_hz,
        })
    }

    /// No delays known.
    pub const NONE: Self = Self {
        of_class: [TickDelta8::ZERO; CLASSES_MAX],
        standard_error: 0,
        clock_hz: 0,
    };

    /// Whether all delays are zero.
    #[must_use]
    pub fn is_zero(&self) -> bool {
        self.of_class.iter().all(|delay| delay.0 == 0)
    }

    /// The delays in ticks of another clock. None where one does not fit, or when `clock_hz` is 0 and a delay is not.
    /// Divides, so not for the edge path.
    #[must_use]
    pub fn at_clock(&self, clock_hz: u64) -> Option<[TickDelta8; CLASSES_MAX]> {
        let mut delays = self.of_class;
        for delay in &mut delays {
            *delay = delay.at_clock(self.clock_hz, clock_hz)?;
        }
        Some(delays)
    }
}

/// Bytes before the entries in a slot of a format version.
///
/// # Errors
/// [`SlotError::Version`] for one that this code does not know.
pub(super) const fn header_bytes(version: u16) -> Result<usize, SlotError> {
    match version {
        1 => Ok(HEADER_BYTES_V1),
        2 | VERSION => Ok(HEADER_BYTES),
        other => Err(SlotError::Version(other)),
    }
}

/// A header's numbers. What an older version does not have reads as zero.
pub(super) struct Fields {
    head: Head,
}

impl Fields {
    /// Of the bytes before the entries.
    pub fn new(bytes: &[u8]) -> Self {
        let mut head = [0; HEADER_BYTES];
        for (cell, byte) in head.iter_mut().zip(bytes) {
            *cell = *byte;
        }
        Self { head }
    }

    fn word(&self, at: usize) -> u32 {
        let bytes = self.head.get(at..).and_then(|rest| rest.first_chunk());
        bytes.copied().map_or(0, u32::from_le_bytes)
    }

    fn long(&self, at: usize) -> u64 {
        u64::from(self.word(at)) | (u64::from(self.word(at + 4)) << 32)
    }

    fn signed(&self, at: usize) -> [i32; CLASSES_MAX] {
        core::array::from_fn(|class| self.word(at + 4 * class).cast_signed())
    }

    /// The encoder's shape.
    ///
    /// # Errors
    /// [`SlotError::Shape`].
    pub fn shape(&self) -> Result<EncoderShape, SlotError> {
        EncoderShape::new(self.word(8), u32::from(self.head[6])).map_err(SlotError::Shape)
    }

    fn stamp(&self) -> Stamp {
        // In version 2 these bytes were reserved.
        if u32::from(self.head[4]) | (u32::from(self.head[5]) << 8) < 3 {
            return Stamp::default();
        }
        let [low, high, given, _] = self.word(116).to_le_bytes();
        Stamp {
            serial: self.long(100),
            learned_at: self.long(108),
            temperature_q4: (given & 1 != 0).then_some(i16::from_le_bytes([low, high])),
            sequence: self.word(120),
            table_rms: self.word(124),
        }
    }

    /// Every field.
    ///
    /// # Errors
    /// [`SlotError::Shape`], [`SlotError::Table`] for a scale out of range, or [`SlotError::Clock`] for delays without a clock.
    pub fn header(&self) -> Result<SlotHeader, SlotError> {
        let delays = Delays {
            of_class: self.signed(64).map(TickDelta8),
            standard_error: self.word(88),
            clock_hz: self.long(92),
        };
        if delays.clock_hz == 0 && !delays.is_zero() {
            return Err(SlotError::Clock);
        }
        let shift = u32::from(self.head[7]);
        if shift > SHIFT_MAX {
            return Err(SlotError::Table(TableError::Shift(shift)));
        }
        Ok(SlotHeader {
            shape: self.shape()?,
            shift,
            turns: self.word(12),
            indexed: self.word(16) & FLAG_INDEXED != 0,
            standard_error: self.word(20),
            class_standard_error: self.word(24),
            source: self.word(28),
            learned_until: self.long(32),
            class_offsets: self.signed(40).map(TurnDelta32),
            delays,
            stamp: self.stamp(),
        })
    }
}

impl SlotHeader {
    /// What a drive says of a table that it learned at the index, up to tick `learned_until` of a clock of `clock_hz`.
    #[must_use]
    pub fn of<B: EdgeBuffers>(solution: &Solution<B>, learned_until: u64, clock_hz: u64) -> Self {
        Self {
            shape: solution.shape(),
            shift: solution.shift(),
            turns: solution.turns(),
            indexed: true,
            standard_error: solution.standard_error(),
            class_standard_error: solution.class_standard_error(),
            source: 0,
            learned_until,
            class_offsets: *solution.class_offsets(),
            delays: Delays::found(solution.class_delays(), clock_hz),
            stamp: Stamp {
                table_rms: solution.table_rms(),
                ..Stamp::default()
            },
        }
    }

    /// The bytes before the entries, in the version that is written.
    pub(super) fn emit(&self) -> Head {
        let mut head = [0; HEADER_BYTES];
        let mut field = |at: usize, bytes: &[u8]| head[at..at + bytes.len()].copy_from_slice(bytes);
        field(0, &MAGIC);
        field(4, &VERSION.to_le_bytes());
        #[allow(clippy::cast_possible_truncation)]
        field(6, &[self.shape.classes() as u8, self.shift as u8]);
        field(8, &self.shape.edges().to_le_bytes());
        field(12, &self.turns.to_le_bytes());
        field(16, &(u32::from(self.indexed) * FLAG_INDEXED).to_le_bytes());
        field(20, &self.standard_error.to_le_bytes());
        field(24, &self.class_standard_error.to_le_bytes());
        field(28, &self.source.to_le_bytes());
        field(32, &self.learned_until.to_le_bytes());
        for (class, offset) in self.class_offsets.iter().enumerate() {
            field(40 + 4 * class, &offset.0.to_le_bytes());
        }
        for (class, delay) in self.delays.of_class.iter().enumerate() {
            field(64 + 4 * class, &delay.0.to_le_bytes());
        }
        field(88, &self.delays.standard_error.to_le_bytes());
        field(92, &self.delays.clock_hz.to_le_bytes());
        let stamp = &self.stamp;
        field(100, &stamp.serial.to_le_bytes());
        field(108, &stamp.learned_at.to_le_bytes());
        if let Some(temperature) = stamp.temperature_q4 {
            field(116, &temperature.to_le_bytes());
            field(118, &[1]);
        }
        field(120, &stamp.sequence.to_le_bytes());
        field(124, &stamp.table_rms.to_le_bytes());
        head
    }
}

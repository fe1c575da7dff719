//! The event file: what a drive's interrupt handlers see, written down so that a firmware image can be fed with it.
//!
//! Little endian throughout. One header, then records to the end of the file.
//!
//! ```text
//! header, 20 bytes                      record, 8 bytes
//!  0  4  magic "QCEV"                    0  1  kind: 0 capture, 1 overflow interrupt served
//!  4  2  version, 1                      1  1  levels after the change (bit 0 A, 1 B, 2 Z or C)
//!  6  1  timer bits, 16 or 32            2  1  flags, bit 0: overflow pending at the capture's handler
//!  7  1  channels: 0 quadrature,         3  1  reserved, 0
//!        1 Hall, 2 wheel, 3 pulses       4  4  captured timer count
//!  8  4  lines, pole pairs or teeth
//! 12  4  timer clock in hertz
//! 16  4  turns wanted
//! ```
//!
//! Levels, flags and count of an overflow record are 0. Records stand in the order the handlers ran, which at a wrap is
//! not the order things happened: a capture taken just after the wrap may be served before the overflow is. One handler
//! serves the timer, captures before the overflow, each less than half a timer period late; so the overflow flag and the
//! upper bit of the count settle which period a capture belongs to.

use core::fmt;

use crate::edge::Levels;

pub mod corrected;
mod reader;
mod session;

pub use reader::{EventReader, ReadError};
pub use session::{Part, Report, SessionError, TURNS_DEFAULT, correct, run};

/// First four bytes of an event file.
pub const MAGIC: [u8; 4] = *b"QCEV";
/// Version of the format that [`Header::emit`] writes and [`Header::parse`] reads.
pub const VERSION: u16 = 1;
/// Bytes in the header.
pub const HEADER_LEN: usize = 20;
/// Bytes in one record.
pub const RECORD_LEN: usize = 8;

const KIND_CAPTURE: u8 = 0;
const KIND_OVERFLOW: u8 = 1;
const FLAG_OVERFLOW_PENDING: u8 = 1;
const LEVELS_MASK: u8 = 7;

/// Width of the capture timer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TimerWidth {
    /// Counts 0 to 2^16 - 1.
    Bits16,
    /// Counts 0 to 2^32 - 1.
    Bits32,
}

impl TimerWidth {
    /// Number of bits, 16 or 32.
    #[must_use]
    pub const fn bits(self) -> u8 {
        match self {
            Self::Bits16 => 16,
            Self::Bits32 => 32,
        }
    }

    /// Largest count; also the mask that cuts 64-bit ticks down to a capture.
    #[must_use]
    pub const fn max(self) -> u32 {
        match self {
            Self::Bits16 => 0xffff,
            Self::Bits32 => u32::MAX,
        }
    }
}

/// What is wired to the capture inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Wiring {
    /// A and B in quadrature, and an index.
    Quadrature,
    /// Three Hall sensors.
    Hall,
    /// One channel, both edges.
    Wheel,
    /// One channel, one pulse a tooth.
    Pulses,
}

/// The file's header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Header {
    /// Width of the capture timer.
    pub timer: TimerWidth,
    /// What the level bits mean.
    pub wiring: Wiring,
    /// Lines of the disc, pole pairs or teeth; at least 1.
    pub lines: u32,
    /// Timer clock in hertz; at least 1.
    pub clock_hz: u32,
    /// Turns to calibrate on; 0 leaves it to the image.
    pub turns: u32,
}

/// One run of an interrupt handler.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Event {
    /// The capture handler took a count from the timer.
    Capture {
        /// The captured count, at most [`TimerWidth::max`].
        raw: u32,
        /// Levels after the change.
        levels: Levels,
        /// Whether an overflow was flagged, and not yet served, when the handler ran.
        overflow_pending: bool,
    },
    /// The overflow handler ran.
    Overflow,
}

/// Why a header or a record was refused, with the value found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ReplayError {
    /// The file does not begin with [`MAGIC`].
    Magic,
    /// Another version of the format.
    Version(u16),
    /// Timer bits other than 16 and 32.
    TimerBits(u8),
    /// Unknown kind of channels.
    Wiring(u8),
    /// No lines, pole pairs or teeth.
    NoLines,
    /// A clock of 0 Hz.
    NoClock,
    /// Unknown kind of record.
    Kind(u8),
    /// Level bits outside the three there are.
    Levels(u8),
    /// Unknown flags, or a reserved byte that is not 0.
    Flags(u8),
    /// A count that the timer can't hold, or a count in an overflow record.
    Count(u32),
}

impl fmt::Display for ReplayError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Magic => f.write_str("not an event file"),
            Self::Version(v) => write!(f, "event file version {v} is not known"),
            Self::TimerBits(b) => write!(f, "timer of {b} bits, expected 16 or 32"),
            Self::Wiring(w) => write!(f, "kind of channels {w} is not known"),
            Self::NoLines => f.write_str("header names no lines"),
            Self::NoClock => f.write_str("header names no clock"),
            Self::Kind(k) => write!(f, "kind of record {k} is not known"),
            Self::Levels(l) => write!(f, "levels {l} use more than three bits"),
            Self::Flags(x) => write!(f, "flags {x} are not known"),
            Self::Count(c) => write!(f, "count {c} can't come from this timer"),
        }
    }
}

impl core::error::Error for ReplayError {}

impl Header {
    /// Reads a header.
    ///
    /// # Errors
    /// Any of the header's [`ReplayError`] variants.
    pub fn parse(bytes: &[u8; HEADER_LEN]) -> Result<Self, ReplayError> {
        let [m0, m1, m2, m3, v0, v1, bits, wiring, rest @ ..] = *bytes;
        let [l0, l1, l2, l3, c0, c1, c2, c3, t0, t1, t2, t3] = rest;
        if [m0, m1, m2, m3] != MAGIC {
            return Err(ReplayError::Magic);
        }
        let version = u16::from_le_bytes([v0, v1]);
        if version != VERSION {
            return Err(ReplayError::Version(version));
        }
        let header = Self {
            timer: match bits {
                16 => TimerWidth::Bits16,
                32 => TimerWidth::Bits32,
                other => return Err(ReplayError::TimerBits(other)),
            },
            wiring: match wiring {
                0 => Wiring::Quadrature,
                1 => Wiring::Hall,
                2 => Wiring::Wheel,
                3 => Wiring::Pulses,
                other => return Err(ReplayError::Wiring(other)),
            },
            lines: u32::from_le_bytes([l0, l1, l2, l3]),
            clock_hz: u32::from_le_bytes([c0, c1, c2, c3]),
            turns: u32::from_le_bytes([t0, t1, t2, t3]),
        };
        match header {
            Self { lines: 0, .. } => Err(ReplayError::NoLines),
            Self { clock_hz: 0, .. } => Err(ReplayError::NoClock),
            _ => Ok(header),
        }
    }

    /// The header's bytes.
    #[must_use]
    pub fn emit(&self) -> [u8; HEADER_LEN] {
        let [m0, m1, m2, m3] = MAGIC;
        let [v0, v1] = VERSION.to_le_bytes();
        let wiring = match self.wiring {
            Wiring::Quadrature => 0,
            Wiring::Hall => 1,
            Wiring::Wheel => 2,
            Wiring::Pulses => 3,
        };
        let [l0, l1, l2, l3] = self.lines.to_le_bytes();
        let [c0, c1, c2, c3] = self.clock_hz.to_le_bytes();
        let [t0, t1, t2, t3] = self.turns.to_le_bytes();
        let bits = self.timer.bits();
        [
            m0, m1, m2, m3, v0, v1, bits, wiring, l0, l1, l2, l3, c0, c1, c2, c3, t0, t1, t2, t3,
        ]
    }
}

impl Event {
    /// Reads one record of a file whose timer is `timer` wide.
    ///
    /// # Errors
    /// Any of the record's [`ReplayError`] variants.
    pub fn parse(bytes: &[u8; RECORD_LEN], timer: TimerWidth) -> Result<Self, ReplayError> {
        let [kind, levels, flags, reserved, r0, r1, r2, r3] = *bytes;
        let raw = u32::from_le_bytes([r0, r1, r2, r3]);
        if reserved != 0 {
            return Err(ReplayError::Flags(reserved));
        }
        match kind {
            KIND_CAPTURE if levels & !LEVELS_MASK != 0 => Err(ReplayError::Levels(levels)),
            KIND_CAPTURE if flags & !FLAG_OVERFLOW_PENDING != 0 => Err(ReplayError::Flags(flags)),
            KIND_CAPTURE if raw > timer.max() => Err(ReplayError::Count(raw)),
            KIND_CAPTURE => Ok(Self::Capture {
                raw,
                levels: Levels(levels),
                overflow_pending: flags & FLAG_OVERFLOW_PENDING != 0,
            }),
            KIND_OVERFLOW if levels != 0 => Err(ReplayError::Levels(levels)),
            KIND_OVERFLOW if flags != 0 => Err(ReplayError::Flags(flags)),
            KIND_OVERFLOW if raw != 0 => Err(ReplayError::Count(raw)),
            KIND_OVERFLOW => Ok(Self::Overflow),
            other => Err(ReplayError::Kind(other)),
        }
    }

    /// The record's bytes.
    #[must_use]
    pub fn emit(&self) -> [u8; RECORD_LEN] {
        match *self {
            Self::Capture {
                raw,
                levels,
                overflow_pending,
            } => {
                let [r0, r1, r2, r3] = raw.to_le_bytes();
                let flags = u8::from(overflow_pending);
                [KIND_CAPTURE, levels.0, flags, 0, r0, r1, r2, r3]
            }
            Self::Overflow => [KIND_OVERFLOW, 0, 0, 0, 0, 0, 0, 0],
        }
    }
}

#[cfg(test)]
mod tests;

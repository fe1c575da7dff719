//! How an encoder is set up, why it can't be, and what its timer captures.

use crate::decoder::DecoderConfig;
use crate::edge::Levels;
use crate::estimate::Anchor;
use crate::shape::{EncoderShape, ShapeError};
use crate::step::SensorError;
use crate::units::Ticks;

/// What the encoder is; fixed for its life.
///
/// ```
/// use quadcal::encoder::EncoderConfig;
///
/// // 2500 lines; at a standstill after 0.1 s without an edge, at 84 MHz.
/// let config = EncoderConfig::new(2500, 8_400_000);
/// assert_eq!(config.decoder.lines, 2500);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EncoderConfig {
    /// Lines, index and glitch gate.
    pub decoder: DecoderConfig,
    /// Where the table's edge 0 is.
    pub anchor: Anchor,
    /// Time without an edge after which the shaft stands still, ticks.
    pub timeout: Ticks,
}

impl EncoderConfig {
    /// The usual settings for an encoder of `lines` lines with an index, 1 to 16,384, at a standstill after `timeout` ticks without
    /// an edge.
    #[must_use]
    pub const fn new(lines: u32, timeout: Ticks) -> Self {
        Self {
            decoder: DecoderConfig::new(lines),
            anchor: Anchor::Index,
            timeout,
        }
    }
}

/// Why an encoder can't be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum EncoderError {
    /// The decoder refuses its settings.
    Sensor(SensorError),
    /// The lines do not make a shape: there are none, or too many.
    Shape(ShapeError),
    /// The table is of an encoder of this shape.
    Table(EncoderShape),
}

/// One capture as the timer's interrupt finds it.
///
/// ```
/// use quadcal::edge::Levels;
/// use quadcal::encoder::Capture;
///
/// // Captured at 0x1234, A high and B low since, no overflow waiting to be served.
/// let capture = Capture { raw: 0x1234, overflow_pending: false, levels: Levels(Levels::A) };
/// assert!(capture.levels.a());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Capture {
    /// The latched counter, ticks, 0 to 2^`BITS` - 1.
    pub raw: u32,
    /// The timer's overflow flag, read after the capture.
    pub overflow_pending: bool,
    /// Levels of A, B and Z after the change.
    pub levels: Levels,
}

//! Recordings of encoder edges: reading, in passing, every format the field has, and writing two of them.

use quadcal::edge::Sample;

/// What the level bits of a recording's samples mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channels {
    /// A, B and, where `index` is set, Z.
    Quadrature {
        /// Whether the recording has a Z column.
        index: bool,
    },
    /// Three Hall sensors A, B, C.
    Hall,
    /// One channel with both edges (a toothed wheel).
    Wheel,
    /// One channel with one pulse a tooth; every sample is a pulse and its levels carry nothing.
    Pulses,
}

/// What a recording says of itself before its first sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// Tick rate of the samples' times, in hertz.
    pub clock_hz: u64,
    /// Meaning of the level bits.
    pub channels: Channels,
    /// Every `# key = value` line, in order, as written.
    pub notes: Vec<(String, String)>,
}

/// One change of level; the times of a recording never fall.
pub type Row = Sample;

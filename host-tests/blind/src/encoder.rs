//! Encoders: which channel changes at which place of the grid.

use std::f64::consts::TAU;

/// What kind of encoder turns with the shaft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoder {
    /// Two channels, four edges a line.
    Quadrature {
        /// Lines a turn.
        lines: u32,
        /// Whether there is an index channel.
        index: bool,
    },
    /// Three Hall sensors, six edges a pole pair.
    Hall {
        /// Pole pairs a turn.
        pole_pairs: u32,
    },
    /// One channel, two edges a tooth.
    Wheel {
        /// Teeth a turn.
        teeth: u32,
    },
}

/// The channel that changes at an edge and how, seen in forward motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Class {
    /// 0 to 2 for A, B and C.
    pub channel: usize,
    /// Whether its level rises.
    pub rises: bool,
}

impl Encoder {
    /// Edges a turn, N.
    #[must_use]
    pub const fn edges(self) -> usize {
        match self {
            Self::Quadrature { lines, .. } => 4 * lines as usize,
            Self::Hall { pole_pairs } => 6 * pole_pairs as usize,
            Self::Wheel { teeth } => 2 * teeth as usize,
        }
    }

    /// Channels without the index.
    #[must_use]
    pub const fn channels(self) -> usize {
        match self {
            Self::Quadrature { .. } => 2,
            Self::Hall { .. } => 3,
            Self::Wheel { .. } => 1,
        }
    }

    /// Whether there is an index channel.
    #[must_use]
    pub const fn index(self) -> bool {
        matches!(self, Self::Quadrature { index: true, .. })
    }

    /// Grid step, rad.
    #[must_use]
    pub fn step_rad(self) -> f64 {
        TAU / self.edges() as f64
    }

    /// Class of edge k.
    #[must_use]
    pub fn class(self, k: usize) -> Class {
        let class = |channel, rises| Class { channel, rises };
        match self {
            Self::Quadrature { .. } => class(k % 2, k % 4 < 2),
            // B rises, C falls, A rises, B falls, C rises, A falls: each 60 electrical degrees after the one before.
            Self::Hall { .. } => match k % 6 {
                0 => class(1, true),
                1 => class(2, false),
                2 => class(0, true),
                3 => class(1, false),
                4 => class(2, true),
                _ => class(0, false),
            },
            Self::Wheel { .. } => class(0, k.is_multiple_of(2)),
        }
    }
}

//! The record of one change of level, and what a decoder makes of it.

use crate::units::Ticks;

/// Levels of the sensor channels, one bit each: bit 0 is A, bit 1 is B, bit 2 is Z (quadrature) or C (three Hall sensors).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Levels(pub u8);

impl Levels {
    /// Bit of channel A.
    pub const A: u8 = 1;
    /// Bit of channel B.
    pub const B: u8 = 2;
    /// Bit of the index channel Z.
    pub const Z: u8 = 4;
    /// Bit of the third Hall sensor.
    pub const C: u8 = 4;

    /// Level of channel A.
    #[inline]
    #[must_use]
    pub const fn a(self) -> bool {
        self.0 & Self::A != 0
    }

    /// Level of channel B.
    #[inline]
    #[must_use]
    pub const fn b(self) -> bool {
        self.0 & Self::B != 0
    }

    /// Level of the index channel.
    #[inline]
    #[must_use]
    pub const fn z(self) -> bool {
        self.0 & Self::Z != 0
    }
}

/// One captured change of level: the time of the change and the levels after it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sample {
    /// Time of the change.
    pub ticks: Ticks,
    /// Levels after the change.
    pub levels: Levels,
}

/// Direction of motion; forward is the order A rise, B rise, A fall, B fall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Direction {
    /// Position counts up.
    #[default]
    Forward,
    /// Position counts down.
    Reverse,
}

impl Direction {
    /// The other direction.
    #[inline]
    #[must_use]
    pub const fn opposite(self) -> Self {
        match self {
            Self::Forward => Self::Reverse,
            Self::Reverse => Self::Forward,
        }
    }

    /// +1 forward, -1 reverse.
    #[inline]
    #[must_use]
    pub const fn sign(self) -> i32 {
        match self {
            Self::Forward => 1,
            Self::Reverse => -1,
        }
    }
}

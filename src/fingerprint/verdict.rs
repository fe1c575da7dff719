//! What is asked of a search, and what it answers.

use super::odds::Doubt;

/// What is asked of a search; fixed for its life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FingerprintConfig {
    /// The table's own standard error of a line position error, 2^-32 turn, as solution and slot have it.
    pub standard_error: u32,
    /// A place or a refusal is told when it is wrong with a probability of at most 2^-bits; 1 to 60.
    pub bits: u8,
}

impl FingerprintConfig {
    /// A chance of 6e-8 (2^-24) to be wrong.
    #[must_use]
    pub const fn new(standard_error: u32) -> Self {
        Self {
            standard_error,
            bits: 24,
        }
    }
}

/// Why a table has no use as a fingerprint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FingerprintError {
    /// Edge classes other than four: only quadrature encoders have a class that the levels tell.
    Classes(u32),
    /// Fewer edges a turn than a window has.
    Edges(u32),
    /// Bits out of range.
    Bits(u8),
}

/// A place in the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Place {
    /// The table's edge is the decoder's edge plus this, modulo the edges of a turn. A multiple of four.
    pub offset: u32,
    /// Bound of the probability that this is the wrong place.
    pub doubt: Doubt,
}

/// What is known after a slice of search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Verdict {
    /// More edges are needed: too few came in a row since the start, a fault or a reversal.
    Gathering,
    /// The search goes on with the next slice.
    Searching,
    /// The place is found. Stays so while edges are numbered from no reference and the table goes on fitting. Where they are
    /// numbered from the index and the offset is not zero, the index has moved against the disc.
    Found(Place),
    /// Edges are numbered from a reference, and the table fits there.
    Fits,
    /// The table has stopped fitting where it should: stop correcting. The search goes on and ends with [`Verdict::Found`] (the
    /// count or the index is off) or [`Verdict::OtherDisc`].
    Misfit(Doubt),
    /// The table is of another disc, and is not to be applied. Final.
    OtherDisc(Doubt),
    /// The table's pattern is too weak for its own error, for this clock at this speed, or for the noise of 16 windows. But for the
    /// first, the search goes on.
    Undecidable,
}

//! What every decoder hands on: steps of the position, their flags, and the count of faults.

use crate::edge::Direction;
use crate::units::Ticks;

/// Set of facts about a step, one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Flags(pub u16);

impl Flags {
    /// No fact.
    pub const NONE: Self = Self(0);
    /// First edge after start: its interval means nothing.
    pub const FIRST: Self = Self(1);
    /// The direction changed at this edge.
    pub const REVERSED: Self = Self(1 << 1);
    /// The index (or the gap of a toothed wheel) has been seen, or the fingerprint found: the position is an angle of the disc.
    pub const REFERENCED: Self = Self(1 << 2);
    /// The index (or gap) was found at this event.
    pub const INDEX: Self = Self(1 << 3);
    /// Something since the last index makes the count uncertain. At an event with [`Flags::INDEX`] this tells of the turn
    /// that ends there; it goes once an index agrees with the count.
    pub const TURN_SUSPECT: Self = Self(1 << 4);
    /// An impossible change of levels: the step stands for more than one edge.
    pub const ILLEGAL: Self = Self(1 << 5);
    /// A reversal without the slowing down that a shaft needs for it.
    pub const ABRUPT: Self = Self(1 << 6);
    /// The interval before this one was far too long for the motion around it.
    pub const SPIKE: Self = Self(1 << 7);
    /// The reference is the fingerprint's, and no index has borne it out yet. At an event with [`Flags::INDEX`] this tells of the
    /// reference that ends there.
    pub const LOCATED: Self = Self(1 << 8);

    /// Whether all facts of `other` are in this set.
    #[inline]
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Whether any fact of `other` is in this set.
    #[inline]
    #[must_use]
    pub const fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// This set and `other` together.
    #[inline]
    #[must_use]
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// The facts of this set that are in `other` too.
    #[inline]
    #[must_use]
    pub const fn within(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// This set without `other`.
    #[inline]
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }
}

/// One accepted edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Step {
    /// Time of the edge.
    pub ticks: Ticks,
    /// The edge crossed, `0..N`: the new position going forward, the old one in reverse.
    pub edge: u32,
    /// Position after the step, `0..N`: position k is the sector between edges k and k + 1.
    pub position: u32,
    /// Time since the previous accepted edge, ticks, at most `u32::MAX`.
    pub interval: u32,
    /// Edges by which an index at this step moved the count, forward positive; 0 where it agreed or was the first.
    pub resync: i32,
    /// Edges this step stands for: 1, or more after an illegal change or over the gap of a toothed wheel.
    pub advance: u16,
    /// Facts about the step.
    pub flags: Flags,
    /// Direction of motion.
    pub direction: Direction,
}

/// An index found without an edge: Z rose within the sector that it marks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reference {
    /// Time of the change of Z.
    pub ticks: Ticks,
    /// Position, after resynchronising.
    pub position: u32,
    /// Edges by which the count was moved, forward positive.
    pub resync: i32,
    /// Facts, as in [`Step::flags`].
    pub flags: Flags,
}

/// A pulse too short to be motion: the previous [`Step`] is to be taken back, and this edge does not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Glitch {
    /// Time of the second edge of the pulse.
    pub ticks: Ticks,
    /// The edge that was crossed and crossed back.
    pub edge: u32,
    /// Position, as before the pulse.
    pub position: u32,
}

/// What became of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Outcome {
    /// No edge and no index.
    Idle,
    /// An edge was accepted.
    Step(Step),
    /// The index was found at a change of Z.
    Index(Reference),
    /// The previous step is withdrawn together with this edge.
    Glitch(Glitch),
}

impl Outcome {
    /// The accepted step, if there is one.
    #[inline]
    #[must_use]
    pub const fn step(self) -> Option<Step> {
        match self {
            Self::Step(step) => Some(step),
            _ => None,
        }
    }
}

/// Counts of what went wrong; they saturate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Faults {
    /// Changes of levels that no single edge makes.
    pub illegal: u32,
    /// Edges missing from the count, found at the index.
    pub lost: u32,
    /// Edges too many in the count, found at the index.
    pub extra: u32,
    /// Pulses shorter than the glitch gate.
    pub glitch: u32,
    /// Reversals without slowing down.
    pub abrupt_reversal: u32,
    /// Single intervals far too long between steady ones.
    pub interval_spike: u32,
    /// Samples that change no level.
    pub repeated: u32,
    /// Times that captures were missing before they came to the decoder, as hardware or its driver tells.
    pub missed: u32,
}

impl Faults {
    /// No faults.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            illegal: 0,
            lost: 0,
            extra: 0,
            glitch: 0,
            abrupt_reversal: 0,
            interval_spike: 0,
            repeated: 0,
            missed: 0,
        }
    }

    /// All counts together.
    #[must_use]
    pub const fn total(&self) -> u32 {
        self.illegal
            .saturating_add(self.lost)
            .saturating_add(self.extra)
            .saturating_add(self.glitch)
            .saturating_add(self.abrupt_reversal)
            .saturating_add(self.interval_spike)
            .saturating_add(self.repeated)
            .saturating_add(self.missed)
    }

    /// Books a correction of the count by `resync` edges made while moving in `direction`.
    pub(crate) const fn book_resync(&mut self, resync: i32, direction: Direction) {
        let size = resync.unsigned_abs();
        if (resync > 0) == matches!(direction, Direction::Forward) {
            self.lost = self.lost.saturating_add(size);
        } else {
            self.extra = self.extra.saturating_add(size);
        }
    }
}

/// Adds one to a saturating count.
#[inline]
pub(crate) const fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

/// Why a sensor's description was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum SensorError {
    /// The slots of a turn are none or more than [`MAX_SLOTS`].
    Slots,
    /// A toothed wheel must keep at least four teeth, and miss at most as many as it keeps.
    Missing,
    /// The glitch gate's shift must be from 2 to 31.
    Gate,
}

/// The most edges in a turn: 2^28.
pub const MAX_SLOTS: u32 = 1 << 28;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_count_behind_the_motion_is_lost_and_one_ahead_is_extra() {
        let mut faults = Faults::default();
        faults.book_resync(4, Direction::Forward);
        faults.book_resync(-8, Direction::Reverse);
        assert_eq!((faults.lost, faults.extra), (12, 0));
        faults.book_resync(-4, Direction::Forward);
        faults.book_resync(8, Direction::Reverse);
        assert_eq!((faults.lost, faults.extra), (12, 12));
    }
}

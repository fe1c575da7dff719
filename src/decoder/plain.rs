//! The usual case, told by three compares: one more step in settled motion, Z low, not at the turn's end, no long interval.

use crate::counter::Counter;
use crate::edge::{Direction, Levels};
use crate::step::Flags;

/// What the next sample is like if it is a plain step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Plain {
    /// Interval from which on a step needs a closer look, ticks; 0 when any sample does.
    limit: u32,
    /// Bits 0 to 2: the levels. Bits 8 and 9: the channel that changes at the step after.
    levels: u32,
    /// The position whose next step goes round the turn's end.
    pub seam: u32,
    /// [`crate::step::Step::advance`] and flags of the step: side by side here as there, one word to copy.
    pub advance: u16,
    pub flags: Flags,
}

const CHANNELS: u32 = (Levels::A | Levels::B) as u32;
const CHANNEL_SHIFT: u32 = 8;

impl Plain {
    /// Every sample needs a closer look.
    pub const NONE: Self = Self {
        limit: 0,
        levels: 0,
        seam: 0,
        advance: 1,
        flags: Flags::NONE,
    };

    /// After a step to the counter's position, Z low.
    pub fn after(counter: &Counter, direction: Direction, flags: Flags, limit: u32) -> Self {
        let position = counter.position();
        let (edge, seam) = match direction {
            Direction::Forward => (position.wrapping_add(1), counter.slots() - 1),
            Direction::Reverse => (position, 0),
        };
        // Even edges are those of A. Position 0 is (A, B) = (1, 0); every two positions both are the other way.
        let channel = |edge: u32| 1 << (edge & 1);
        let present = match position & 3 {
            0 => 0b01,
            1 => 0b11,
            2 => 0b10,
            _ => 0b00,
        };
        Self {
            limit,
            levels: (present ^ channel(edge)) | (channel(edge + 1) << CHANNEL_SHIFT),
            seam,
            advance: 1,
            flags,
        }
    }

    /// Whether a sample is this step.
    #[inline]
    pub fn is(&self, levels: Levels, elapsed: u64, position: u32) -> bool {
        (u32::from(levels.0) ^ self.levels) & 7 == 0
            && elapsed < u64::from(self.limit)
            && position != self.seam
    }

    /// Looks on to the step after this one.
    #[inline]
    pub fn pass(&mut self, limit: u32) {
        self.levels ^= (self.levels >> CHANNEL_SHIFT) ^ (CHANNELS << CHANNEL_SHIFT);
        self.limit = limit;
    }
}

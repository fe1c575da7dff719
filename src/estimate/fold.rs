//! Folding a whole turn into the sum and the contrast, one entry an edge while the next turn comes in.

use super::EdgeBuffers;
use super::turn::wrapped;
use crate::edge::Direction;

/// Bits by which the contrast is coarser than the sum, so that 16 bits hold thousands of noisy turns.
pub(super) const CONTRAST_SHIFT: u32 = 3;

/// Sign of a turn in the contrast: the Thue-Morse sequence, which cancels a constant pattern in every pair and a steady
/// drift in every four.
pub(super) fn sign_of_turn(turn: u32) -> i32 {
    if turn.count_ones().is_multiple_of(2) {
        1
    } else {
        -1
    }
}

/// What is left to fold of the turn taken last.
pub(super) struct Fold {
    remaining: u32,
    slot: u32,
    direction: Direction,
    sign: i32,
    slope_q32: i64,
    level_q32: i64,
    level_before: i32,
}

impl Fold {
    pub(super) fn idle() -> Self {
        Self {
            remaining: 0,
            slot: 0,
            direction: Direction::Forward,
            sign: 1,
            slope_q32: 0,
            level_q32: 0,
            level_before: 0,
        }
    }

    /// A turn whose mean deviation an edge is `slope_q32` (Q32 step fractions), to be counted with `sign`.
    pub(super) fn of_turn(direction: Direction, sign: i32, slope_q32: i64, edges: u32) -> Self {
        let slot = if direction == Direction::Forward {
            1
        } else {
            0
        };
        Self {
            remaining: edges,
            slot,
            direction,
            sign,
            slope_q32,
            ..Self::idle()
        }
    }

    pub(super) fn is_idle(&self) -> bool {
        self.remaining == 0
    }

    /// Whether a turn in `direction` that starts now writes every cell after it was folded.
    pub(super) fn follows(&self, direction: Direction) -> bool {
        let first = if direction == Direction::Forward {
            1
        } else {
            0
        };
        self.direction == direction && self.slot == first
    }

    /// Folds one entry.
    #[inline]
    pub(super) fn step<B: EdgeBuffers>(&mut self, buffers: &mut B, edges: u32) {
        if self.remaining == 0 {
            return;
        }
        self.remaining -= 1;
        let slot = self.slot as usize;
        self.slot = wrapped(self.slot, 1, edges, self.direction == Direction::Forward);
        let Some(cells) = buffers.work().get_mut(slot) else {
            return;
        };
        let entry = i32::from(cells[0]);
        // Rounding the running level, not each entry, keeps the rounding error from adding up over the turn.
        self.level_q32 += (i64::from(entry) << 32) - self.slope_q32;
        #[allow(clippy::cast_possible_truncation)]
        let level = (self.level_q32 >> (32 + CONTRAST_SHIFT)) as i32;
        let contrast = i32::from(cells[1]) + self.sign * (level - self.level_before);
        self.level_before = level;
        #[allow(clippy::cast_possible_truncation)]
        let kept = contrast.clamp(i32::from(i16::MIN), i32::from(i16::MAX)) as i16;
        cells[1] = kept;
        if let Some(sum) = buffers.sum().get_mut(slot) {
            *sum = sum.wrapping_add(entry);
        }
    }

    /// Folds all that is left.
    pub(super) fn finish<B: EdgeBuffers>(&mut self, buffers: &mut B, edges: u32) {
        while self.remaining != 0 {
            self.step(buffers, edges);
        }
    }
}

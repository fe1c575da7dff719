//! Folding a whole turn into the sum and the contrast, one entry an edge while the next turn comes in.

use super::EdgeBuffers;
use super::lockstep::fold_entry;
use super::turn::wrapped;
use crate::edge::Direction;

/// Bits by which the contrast is coarser than the sum, so that its 16 bits hold all turns. Encoders of few edges are run
/// for thousands of turns and timed coarsely; with many edges, a few quiet turns must not drown in rounding.
pub(super) const fn contrast_shift(edges: u32) -> u32 {
    if edges < 1024 { 3 } else { 1 }
}

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
    pub remaining: u32,
    pub slot: u32,
    pub direction: Direction,
    pub sign: i32,
    pub slope_q32: i64,
    pub level_q32: i64,
    pub contrast_shift: u32,
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
            contrast_shift: 1,
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
            slope_q32: slope_q32 >> contrast_shift(edges),
            contrast_shift: contrast_shift(edges),
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
        let entry = fold_entry(
            cells,
            &mut self.level_q32,
            self.slope_q32,
            self.sign,
            self.contrast_shift,
        );
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

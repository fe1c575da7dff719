//! One window of measured blocks held against every line of the table, a few blocks at a time.

use super::block::{BLOCK_EDGES, Block, CONTRASTS};
use super::odds::{BIT, Bits, WeightSum, count_bits, light, likelier, log};
use super::trail::Trail;
use crate::table::Entry;

/// What the table is, in the unit of its entries.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    /// Edges of a turn.
    pub slots: u32,
    /// 15 grid steps.
    pub span: u64,
    /// Energy of a block that the table's own error and rounding leave.
    pub table_noise: u64,
    /// Mean energy of a block of the table.
    pub power: u64,
}

impl Scale {
    /// Lines: places that a window may be at.
    pub const fn lines(&self) -> u32 {
        self.slots / 4
    }
}

/// Blocks measured one after the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window<const BLOCKS: usize> {
    blocks: [Block; BLOCKS],
    /// The decoder's number of the first edge.
    pub first: u32,
    /// Energy of noise that is there for certain: of the timer and the table.
    floor: u64,
}

/// Why there is no window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NoWindow {
    /// Too few edges in a row, or too sudden a change of speed.
    Edges,
    /// The timer's tick is too coarse for the pattern at this speed: rounding would be no noise any more.
    Clock,
}

impl<const BLOCKS: usize> Window<BLOCKS> {
    pub const EMPTY: Self = Self {
        blocks: [Block::EMPTY; BLOCKS],
        first: 0,
        floor: 1,
    };

    /// Edges of a window.
    #[allow(clippy::cast_possible_truncation)]
    pub const EDGES: u32 = BLOCKS as u32 * BLOCK_EDGES;

    /// Independent contrasts of a window.
    #[allow(clippy::cast_possible_truncation)]
    pub const FREEDOM: u32 = (BLOCKS * CONTRASTS) as u32;

    /// The newest window of a trail.
    pub fn load<const W: usize>(trail: &Trail<W>, scale: &Scale) -> Result<Self, NoWindow> {
        let run = trail.run(Self::EDGES).ok_or(NoWindow::Edges)?;
        let mut window = Self {
            first: run.first(scale.slots),
            ..Self::EMPTY
        };
        for (place, block) in window.blocks.iter_mut().zip(0..) {
            let (measured, tick_q16) =
                Block::measure(&run, block, scale.span).ok_or(NoWindow::Edges)?;
            // Rounding to a tick makes a twelfth of its square, in each contrast.
            let clock_noise = ((CONTRASTS as u64 * tick_q16) >> 16) / 12;
            if clock_noise > scale.power / 16 {
                return Err(NoWindow::Clock);
            }
            window.floor += clock_noise + scale.table_noise;
            *place = measured;
        }
        Ok(window)
    }

    /// Energy left where the table holds nothing.
    pub fn energy(&self) -> u64 {
        let energy: u64 = self.blocks.iter().map(Block::energy).sum();
        energy + self.floor
    }

    /// Energy left with the table from its edge `first` on; none as soon as it is above `limit`. The second value counts the
    /// half blocks looked at.
    pub fn residual<E: Entry>(&self, entries: &[E], first: u32, limit: u64) -> (Option<u64>, u32) {
        let mut left = self.floor;
        let mut at = first as usize;
        let mut looked = 0;
        for block in &self.blocks {
            if at >= entries.len() {
                at = at.wrapping_sub(entries.len());
            }
            let (more, halves) = block.residual(entries, at, limit.saturating_sub(left));
            left += more;
            at += BLOCK_EDGES as usize;
            looked += halves;
            if left > limit {
                return (None, looked);
            }
        }
        (Some(left), looked)
    }
}

/// A search through all lines. The quick one abandons places early and bears out only a clear match, the full one weighs all.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hunt {
    full: bool,
    line: u32,
    limit: u64,
    /// Energy that the empty table leaves.
    empty: u64,
    empty_log: Bits,
    best: u64,
    second: u64,
    best_line: u32,
    abandoned: u32,
    weights: WeightSum,
}

/// Half blocks that could be looked at in the time that the weight of a place takes.
const WEIGHING: u32 = 6;

/// What a whole search found.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// The line that fits best.
    pub line: u32,
    /// Evidence that it is the place.
    pub bits: Bits,
    /// Evidence that no line is, negative where some line fits. Only a full search weighs it.
    pub against: Option<Bits>,
}

impl Hunt {
    /// Abandons a place at an eighth of the energy that the pattern itself has: a wrong one leaves twice that energy, and noise
    /// besides.
    pub fn quick<const BLOCKS: usize>(window: &Window<BLOCKS>, scale: &Scale) -> Self {
        let limit = window.floor + BLOCKS as u64 * scale.power / 8;
        Self::new(false, limit, window.energy())
    }

    /// The full search of the same window.
    pub fn full<const BLOCKS: usize>(window: &Window<BLOCKS>) -> Self {
        let empty = window.energy();
        Self::new(true, light(empty, Window::<BLOCKS>::FREEDOM), empty)
    }

    fn new(full: bool, limit: u64, empty: u64) -> Self {
        Self {
            full,
            line: 0,
            limit,
            empty,
            empty_log: log(empty),
            best: u64::MAX,
            second: u64::MAX,
            best_line: 0,
            abandoned: 0,
            weights: WeightSum::NONE,
        }
    }

    /// Looks at lines until the budget of half blocks is used up; tells when all are done.
    pub fn advance<const BLOCKS: usize, E: Entry>(
        &mut self,
        window: &Window<BLOCKS>,
        entries: &[E],
        scale: &Scale,
        budget: &mut u32,
    ) -> Option<Found> {
        let freedom = Bits::from(Window::<BLOCKS>::FREEDOM);
        while self.line < scale.lines() {
            if *budget == 0 {
                return None;
            }
            let (left, looked) = window.residual(entries, 4 * self.line, self.limit);
            *budget = budget.saturating_sub(looked);
            match left {
                None => self.abandoned += 1,
                Some(left) => {
                    if self.full {
                        *budget = budget.saturating_sub(WEIGHING);
                        let bits = (self.empty_log - log(left)) * freedom / 2;
                        self.weights.add(bits);
                    }
                    self.rank(left);
                }
            }
            self.line += 1;
        }
        Some(self.conclude(Window::<BLOCKS>::FREEDOM, scale.lines()))
    }

    fn rank(&mut self, left: u64) {
        if left < self.best {
            self.second = self.best;
            self.best = left;
            self.best_line = self.line;
        } else {
            self.second = self.second.min(left);
        }
    }

    fn conclude(mut self, freedom: u32, lines: u32) -> Found {
        let rival = self.second.min(self.limit).min(self.empty);
        // Every other line weighs at most as much as the rival, and so does each of as many places on another disc.
        let bits = if self.best == u64::MAX {
            0
        } else {
            likelier(self.best, rival, freedom) - count_bits(lines) - BIT
        };
        self.weights.add_light(self.abandoned);
        Found {
            line: self.best_line,
            bits,
            against: self.full.then(|| count_bits(lines) - self.weights.bits()),
        }
    }
}

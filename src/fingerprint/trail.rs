//! The edge path's part: the last intervals of plain motion.

use crate::edge::Direction;
use crate::step::{Flags, Outcome, Step};

/// What may stand in the flags of plain motion.
const STATUS: Flags = Flags::REFERENCED
    .with(Flags::LOCATED)
    .with(Flags::TURN_SUSPECT);

/// A step that an interval before it, or the interval itself, is no good to measure with.
const BROKEN: Flags = Flags::FIRST
    .with(Flags::REVERSED)
    .with(Flags::ILLEGAL)
    .with(Flags::ABRUPT)
    .with(Flags::SPIKE);

/// The last W intervals of motion in one direction without a fault; W is a power of two.
///
/// [`Trail::push`] belongs on the edge path. The background works on a copy, taken where no edge can come in between.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Trail<const W: usize> {
    intervals: [u32; W],
    /// Intervals since the last fault or reversal; the next one goes to this place modulo W.
    count: u32,
    /// The newest edge.
    edge: u32,
    flags: Flags,
    direction: Direction,
    epoch: u32,
}

impl<const W: usize> Trail<W> {
    /// Nothing seen.
    #[must_use]
    pub const fn new() -> Self {
        const { assert!(W.is_power_of_two() && W <= 1 << 16) };
        Self {
            intervals: [0; W],
            count: 0,
            edge: 0,
            flags: Flags::NONE,
            direction: Direction::Forward,
            epoch: 0,
        }
    }

    /// Takes what a decoder made of a sample. On the edge path.
    #[inline]
    pub fn push(&mut self, outcome: &Outcome) {
        match outcome {
            Outcome::Step(step)
                if step.flags == self.flags
                    && step.direction == self.direction
                    && step.advance == 1 =>
            {
                self.push_plain(step);
            }
            _ => self.push_other(outcome),
        }
    }

    #[inline]
    fn push_plain(&mut self, step: &Step) {
        self.intervals[self.count as usize & (W - 1)] = step.interval;
        self.count = self.count.wrapping_add(1);
        self.edge = step.edge;
    }

    #[cold]
    #[inline(never)]
    fn push_other(&mut self, outcome: &Outcome) {
        match outcome {
            Outcome::Idle => {}
            Outcome::Glitch(_) => self.count = 0,
            Outcome::Index(index) => {
                self.renumber(index.flags, index.resync);
                self.flags = index.flags.within(STATUS);
            }
            Outcome::Step(step) => {
                self.renumber(step.flags, step.resync);
                if step.flags.intersects(BROKEN)
                    || step.advance != 1
                    || step.direction != self.direction
                {
                    self.count = 0;
                } else if step.resync == 0 && step.flags.within(STATUS) == self.flags {
                    self.push_plain(step);
                }
                self.flags = step.flags.within(STATUS);
                self.direction = step.direction;
                self.edge = step.edge;
            }
        }
    }

    /// Starts anew where edge numbers get another meaning or come into doubt.
    fn renumber(&mut self, flags: Flags, resync: i32) {
        let new = flags.within(STATUS).without(self.flags);
        if resync != 0 || flags.contains(Flags::FIRST) || new != Flags::NONE {
            self.epoch = self.epoch.wrapping_add(1);
            self.count = 0;
        }
    }

    /// Changes whenever edge numbers before and after can't be compared: at the first edge, when a reference is found or
    /// moved, when the count comes into doubt.
    #[must_use]
    pub const fn epoch(&self) -> u32 {
        self.epoch
    }

    /// Whether edges are numbered from a reference, index or fingerprint.
    #[must_use]
    pub const fn is_referenced(&self) -> bool {
        self.flags.contains(Flags::REFERENCED)
    }

    /// Intervals since the last fault or reversal, modulo 2^32.
    pub(super) const fn count(&self) -> u32 {
        self.count
    }

    /// The newest run of `edges` edges that starts at an edge of class 0.
    pub(super) fn run(&self, edges: u32) -> Option<Run<'_, W>> {
        // Edges newer than the run's end.
        let skipped = match self.direction {
            Direction::Forward => (self.edge + 1) % 4,
            Direction::Reverse => 0_u32.wrapping_sub(self.edge) % 4,
        };
        let needed = edges - 1 + skipped;
        (needed <= self.count && needed as usize <= W).then_some(Run {
            trail: self,
            edges,
            skipped,
        })
    }
}

impl<const W: usize> Default for Trail<W> {
    fn default() -> Self {
        Self::new()
    }
}

/// Edges in a row, read in forward order whichever way the shaft went.
pub(super) struct Run<'a, const W: usize> {
    trail: &'a Trail<W>,
    edges: u32,
    skipped: u32,
}

impl<const W: usize> Run<'_, W> {
    /// The decoder's number of the first edge; `slots` are the edges of a turn, at least as many as those of the run and 4.
    pub fn first(&self, slots: u32) -> u32 {
        let newest = self.trail.edge;
        let first = match self.trail.direction {
            Direction::Forward => newest
                .wrapping_add(slots.wrapping_mul(2))
                .wrapping_sub(self.edges - 1 + self.skipped),
            Direction::Reverse => newest.wrapping_add(self.skipped),
        };
        wrap(first, slots)
    }

    /// Time from edge `index` - 1 of the run to edge `index`, ticks.
    pub fn interval(&self, index: u32) -> u32 {
        let back = match self.trail.direction {
            Direction::Forward => self.skipped + self.edges - index,
            Direction::Reverse => self.skipped + index,
        };
        self.trail.intervals[self.trail.count.wrapping_sub(back) as usize & (W - 1)]
    }
}

/// An edge's number within the turn.
pub(super) fn wrap(edge: u32, slots: u32) -> u32 {
    edge.checked_rem(slots).unwrap_or(0)
}

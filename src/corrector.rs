//! What the servo loop gets: the corrected angle at every edge and, by extrapolation from the last two, between edges.
//!
//! # Time
//! The table's delays say how late each edge is captured. An edge keeps its captured time in whole ticks and, beside it, how late
//! that is in 2^-8 tick, so that nothing is rounded where a tick is long. Extrapolation takes both into account.

mod edge;

use crate::edge::Direction;
use crate::estimate::Anchor;
use crate::interval::ErrorChange;
use crate::shape::Grid;
use crate::step::{Flags, Outcome, Step};
use crate::table::{Delay, Entry, ErrorTable, OfClass};
use crate::units::{Ticks, Turn32, TurnDelta32};

pub use edge::CorrectedEdge;

/// An edge, and what extrapolation from it needs. Its delay follows from its class.
#[derive(Clone, Copy, Debug)]
struct Last {
    ticks: Ticks,
    angle: Turn32,
    moved: TurnDelta32,
    interval: u32,
    flags: Flags,
    direction: Direction,
    number: u32,
}

/// What a step is, held against the one before.
struct Related {
    angle: Turn32,
    /// Way and time from there, as captured.
    moved: TurnDelta32,
    change: ErrorChange,
    interval: u32,
    delay: Delay,
}

const NOTHING: Last = Last {
    ticks: 0,
    angle: Turn32(0),
    moved: TurnDelta32(0),
    interval: 0,
    flags: Flags::NONE,
    direction: Direction::Forward,
    number: 0,
};

/// Flags that decide whether an edge's angle can be subtracted from the one before, and which class that is of.
const RELATION: Flags = Flags::FIRST
    .with(Flags::REVERSED)
    .with(Flags::ILLEGAL)
    .with(Flags::REFERENCED)
    .with(Flags::INDEX);

/// Never a step's relation.
const NO_RELATION: Flags = Flags(u16::MAX);

/// Applies an error table to a decoder's steps. Without a table it hands on the grid's angles.
pub struct Corrector<'a, E: Entry = i16> {
    table: ErrorTable<'a, E>,
    anchor: Anchor,
    /// What the flags of the next step are within [`RELATION`] if it follows the last one plainly.
    related: Flags,
    /// What an edge has from its class in the present direction, by the last two bits of its number.
    classes: [OfClass; 4],
    /// The table's entries once the index is seen, none before.
    entries: &'a [E],
    /// Whether the table was given up.
    released: bool,
    /// Place of the newest edge in the history.
    newest: bool,
    /// Edges known, at most both.
    known: u8,
    /// The edge accepted last, and the one before, to come back to after a glitch.
    history: [Last; 2],
}

impl<'a, E: Entry> Corrector<'a, E> {
    /// Corrects with `table`, whose edge 0 is at `anchor`: all of it applies once the decoder's count starts there too.
    #[must_use]
    pub const fn new(table: ErrorTable<'a, E>, anchor: Anchor) -> Self {
        Self {
            table,
            anchor,
            related: NO_RELATION,
            classes: [OfClass::NONE; 4],
            entries: &[],
            released: false,
            newest: false,
            known: 0,
            history: [NOTHING; 2],
        }
    }

    /// Hands on the grid's angles as they are.
    #[must_use]
    pub const fn uncorrected(grid: Grid) -> Self {
        Self::new(ErrorTable::of_grid(grid), Anchor::Index)
    }

    /// Takes what a decoder made of a sample; `Some` for every accepted edge. On the edge path.
    #[inline]
    pub fn push(&mut self, outcome: &Outcome) -> Option<CorrectedEdge> {
        self.push_for_speed(outcome).map(|(edge, _)| edge)
    }

    /// As [`Self::push`], with what [`Interval::push_delayed`](crate::interval::Interval::push_delayed) takes besides the edge's
    /// [`stretch`](CorrectedEdge::stretch). The difference of errors is not known where edges can't be subtracted.
    #[inline]
    pub fn push_for_speed(&mut self, outcome: &Outcome) -> Option<(CorrectedEdge, ErrorChange)> {
        if let Outcome::Step(step) = outcome {
            return Some(self.push_step(step));
        }
        self.push_other(outcome);
        None
    }

    #[inline]
    fn push_step(&mut self, step: &Step) -> (CorrectedEdge, ErrorChange) {
        let Related {
            angle,
            moved,
            change,
            interval,
            delay,
        } = if self.follows(step.flags) {
            let class = self.classes[step.edge as usize % 4];
            let angle = self.table.angle_with(step.edge, class.offset, self.entries);
            let moved = angle.minus(self.newest().angle);
            Related {
                angle,
                moved,
                change: self.change(self.newest().number, step.edge, moved),
                interval: step.interval,
                delay: class.delay,
            }
        } else {
            self.relate(step)
        };
        self.newest = !self.newest;
        self.history[usize::from(self.newest)] = Last {
            ticks: step.ticks,
            angle,
            moved,
            interval,
            flags: step.flags,
            direction: step.direction,
            number: step.edge,
        };
        let edge = CorrectedEdge {
            ticks: step.ticks,
            angle,
            moved,
            interval,
            late: delay.late,
            stretch: delay.stretch,
            flags: step.flags,
        };
        (edge, change)
    }

    /// Whether a step with these flags follows the last one plainly.
    #[inline]
    pub(crate) fn follows(&self, flags: Flags) -> bool {
        flags.within(RELATION) == self.related
    }

    /// Difference of errors from one edge to another, `moved` away: what the way is short of the grid's.
    #[inline]
    pub(crate) fn change(&self, from: u32, to: u32, moved: TurnDelta32) -> ErrorChange {
        let grid = self.table.grid();
        ErrorChange::from_to(moved, grid.angle(to).minus(grid.angle(from)))
    }

    /// A step that may not follow the one before plainly.
    #[cold]
    #[inline(never)]
    fn relate(&mut self, step: &Step) -> Related {
        self.hold_to_index(step.flags, step.resync);
        let first = step.flags.contains(Flags::FIRST);
        let referenced = self.applies(step.flags);
        let angle = self.table.angle(step.edge, referenced);
        // Across a change of the count or of what is corrected, angles of two edges can't be subtracted.
        let comparable = step.resync == 0 && !first;
        let (moved, change) = match self.recent() {
            Some(last) if comparable && self.applies(last.flags) == referenced => {
                let moved = angle.minus(last.angle);
                (moved, self.change(last.number, step.edge, moved))
            }
            _ => (TurnDelta32(self.grid_steps(step)), ErrorChange::NONE),
        };
        self.known = (self.known + 1).min(2);
        self.expect(step.flags, step.direction);
        let interval = if first { 0 } else { step.interval };
        let delay = self
            .table
            .delay_after(step.edge, step.direction, step.flags);
        Related {
            angle,
            moved,
            change,
            interval,
            delay,
        }
    }

    /// Gets ready for steps that plainly follow one with `flags` in `direction`.
    fn expect(&mut self, flags: Flags, direction: Direction) {
        self.related = NO_RELATION;
        // Six classes take the longer way at every edge: Hall sensors give few.
        if let Some(classes) = self.table.classes_by_bits(direction)
            && self.known == 2
        {
            self.related = flags.within(Flags::REFERENCED);
            self.classes = classes;
            self.entries = if self.applies(flags) {
                self.table.entries()
            } else {
                &[]
            };
        }
    }

    #[cold]
    #[inline(never)]
    fn push_other(&mut self, outcome: &Outcome) {
        match outcome {
            // One edge can be taken back, not several in a row.
            Outcome::Glitch(_) if self.known == 2 => {
                let before = self.history[usize::from(!self.newest)];
                self.history[usize::from(self.newest)] = before;
                self.expect(before.flags, before.direction);
            }
            Outcome::Glitch(_) => self.known = 0,
            Outcome::Index(index) if index.resync != 0 => {
                self.hold_to_index(index.flags, index.resync);
                self.known = 0;
                self.related = NO_RELATION;
            }
            Outcome::Index(_) | Outcome::Idle | Outcome::Step(_) => {}
        }
    }

    /// Stops correcting where an index is not where the fingerprint found it to be.
    fn hold_to_index(&mut self, flags: Flags, resync: i32) {
        if resync != 0 && flags.contains(Flags::INDEX.with(Flags::LOCATED)) {
            self.release();
        }
    }

    /// Stops correcting for good: from here on angles are the grid's. For a table that turned out to be of another disc.
    pub fn release(&mut self) {
        self.table = ErrorTable::of_grid(self.table.grid());
        self.released = true;
        self.related = NO_RELATION;
        // Angles before and after can't be subtracted.
        self.known = 0;
    }

    /// Whether the table was given up: by [`Corrector::release`], or because the first index after
    /// [`crate::decoder::QuadratureDecoder::locate`] came at another place.
    #[must_use]
    pub const fn is_released(&self) -> bool {
        self.released
    }

    /// Whether the whole table applies to an edge with these flags.
    fn applies(&self, flags: Flags) -> bool {
        self.anchor == Anchor::FirstEdge || flags.contains(Flags::REFERENCED)
    }

    #[inline]
    fn newest(&self) -> &Last {
        &self.history[usize::from(self.newest)]
    }

    fn recent(&self) -> Option<&Last> {
        (self.known != 0).then(|| self.newest())
    }

    /// The edge accepted last.
    #[must_use]
    pub fn last(&self) -> Option<CorrectedEdge> {
        let last = self.recent()?;
        let delay = self
            .table
            .delay_after(last.number, last.direction, last.flags);
        Some(CorrectedEdge {
            ticks: last.ticks,
            angle: last.angle,
            moved: last.moved,
            interval: last.interval,
            late: delay.late,
            stretch: delay.stretch,
            flags: last.flags,
        })
    }

    /// Angle at `now`: from the last edge on at the speed of the last interval, but never past the next edge, which would
    /// have been seen. `None` before the first edge. For the control loop; no division.
    #[must_use]
    pub fn angle_at(&self, now: Ticks) -> Option<Turn32> {
        let last = self.last()?;
        Some(self.go_on(&last, self.newest().number, now))
    }

    /// [`Self::angle_at`] from an edge with its number, in the present direction.
    pub(crate) fn go_on(&self, last: &CorrectedEdge, number: u32, now: Ticks) -> Turn32 {
        if last.interval == 0 {
            return last.angle;
        }
        let direction = self.newest().direction;
        let next = self.next_edge(number, direction);
        let way = self
            .table
            .angle(next, self.applies(last.flags))
            .minus(last.angle)
            .0
            .unsigned_abs();
        // An edge that is captured late may have been passed already.
        let limit = i64::from(way) + last.way_in(self.table.delay(next, direction));
        let travel = last.way_until(now).min(limit).max(-i64::from(way)) as i32;
        last.angle
            .plus(TurnDelta32(travel.wrapping_mul(direction.sign())))
    }

    /// The number of the edge that [`Self::last`] has, and its direction.
    #[inline]
    pub(crate) fn place(&self) -> (u32, Direction) {
        let last = self.newest();
        (last.number, last.direction)
    }

    /// Angle of the edge that comes after [`Self::last`].
    pub(crate) fn angle_ahead(&self) -> Turn32 {
        let last = self.newest();
        let next = self.next_edge(last.number, last.direction);
        self.table.angle(next, self.applies(last.flags))
    }

    /// Angle of the edge after `edge` in the same turn, which [`Self::follows`] plainly; `step` is what takes one to the next, 1 or -1.
    #[inline]
    pub(crate) fn angle_beyond(&self, edge: u32, step: i32) -> Turn32 {
        let next = edge.wrapping_add_signed(step);
        let class = self.classes[next as usize % 4];
        self.table.angle_with(next, class.offset, self.entries)
    }

    /// What the delays do to an edge crossed plainly.
    #[inline]
    pub(crate) fn plain_delay(&self, edge: u32) -> Delay {
        self.classes[edge as usize % 4].delay
    }

    /// The table in use.
    pub(crate) const fn table(&self) -> &ErrorTable<'a, E> {
        &self.table
    }

    /// The edge that comes after another.
    pub(crate) fn next_edge(&self, edge: u32, direction: Direction) -> u32 {
        let edges = self.table.shape().edges();
        match direction {
            Direction::Forward if edge.wrapping_add(1) >= edges => 0,
            Direction::Forward => edge + 1,
            Direction::Reverse if edge == 0 => edges - 1,
            Direction::Reverse => edge - 1,
        }
    }

    /// The step's way on the grid, for edges that can't be compared with the one before.
    fn grid_steps(&self, step: &Step) -> i32 {
        let size = self
            .table
            .grid()
            .angle(u32::from(step.advance))
            .0
            .cast_signed();
        size.wrapping_mul(step.direction.sign())
    }
}

#[cfg(test)]
mod tests;

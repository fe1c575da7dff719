//! What the servo loop gets: the corrected angle at every edge and, by extrapolation from the last two, between edges.

use crate::edge::Direction;
use crate::estimate::Anchor;
use crate::recip::Recip;
use crate::shape::Grid;
use crate::step::{Flags, Outcome, Step};
use crate::table::{Entry, ErrorTable};
use crate::units::{Ticks, Turn32, TurnDelta32};

/// One edge, corrected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CorrectedEdge {
    /// Time of the edge.
    pub ticks: Ticks,
    /// Shaft angle. Before the index its origin is where counting began.
    pub angle: Turn32,
    /// Corrected angle moved since the previous edge, negative in reverse, 0 where the direction changed.
    pub moved: TurnDelta32,
    /// Time since the previous edge, ticks; 0 at the first edge.
    pub interval: u32,
    /// Facts about the step: [`Flags::TURN_SUSPECT`] says that the angle may be off by whole edges.
    pub flags: Flags,
}

/// The state that one step changes, and that a glitch takes back.
#[derive(Clone, Copy, Debug)]
struct Last {
    edge: CorrectedEdge,
    number: u32,
    direction: Direction,
    referenced: bool,
}

/// Applies an error table to a decoder's steps. Without a table it hands on the grid's angles.
pub struct Corrector<'a, E: Entry = i16> {
    grid: Grid,
    table: Option<ErrorTable<'a, E>>,
    anchor: Anchor,
    last: Option<Last>,
    before: Option<Last>,
}

impl<'a, E: Entry> Corrector<'a, E> {
    /// Corrects with `table`, whose edge 0 is at `anchor`: all of it applies once the decoder's count starts there too.
    #[must_use]
    pub const fn new(table: ErrorTable<'a, E>, anchor: Anchor) -> Self {
        Self {
            grid: Grid::new(table.shape()),
            table: Some(table),
            anchor,
            last: None,
            before: None,
        }
    }

    /// Hands on the grid's angles as they are.
    #[must_use]
    pub const fn uncorrected(grid: Grid) -> Self {
        Self {
            grid,
            table: None,
            anchor: Anchor::Index,
            last: None,
            before: None,
        }
    }

    /// Takes what a decoder made of a sample; `Some` for every accepted edge. On the edge path.
    #[inline]
    pub fn push(&mut self, outcome: &Outcome) -> Option<CorrectedEdge> {
        match outcome {
            Outcome::Step(step) => Some(self.push_step(step)),
            Outcome::Glitch(_) => {
                self.last = self.before;
                None
            }
            Outcome::Index(index) if index.resync != 0 => {
                self.last = None;
                None
            }
            Outcome::Index(_) | Outcome::Idle => None,
        }
    }

    #[inline]
    fn push_step(&mut self, step: &Step) -> CorrectedEdge {
        let referenced = self.anchor == Anchor::FirstEdge || step.flags.contains(Flags::REFERENCED);
        let angle = self.angle_of(step.edge, referenced);
        // Across a change of the count or of what is corrected, angles of two edges can't be subtracted.
        let comparable = step.resync == 0 && !step.flags.contains(Flags::FIRST);
        let moved = match &self.last {
            Some(last) if comparable && last.referenced == referenced => {
                angle.minus(last.edge.angle)
            }
            _ => TurnDelta32(self.grid_steps(step)),
        };
        let interval = if step.flags.contains(Flags::FIRST) {
            0
        } else {
            step.interval
        };
        let edge = CorrectedEdge {
            ticks: step.ticks,
            angle,
            moved,
            interval,
            flags: step.flags,
        };
        self.before = self.last;
        self.last = Some(Last {
            edge,
            number: step.edge,
            direction: step.direction,
            referenced,
        });
        edge
    }

    /// The edge accepted last.
    #[must_use]
    pub fn last(&self) -> Option<&CorrectedEdge> {
        self.last.as_ref().map(|last| &last.edge)
    }

    /// Angle at `now`: from the last edge on at the speed of the last interval, but never past the next edge, which would
    /// have been seen. `None` before the first edge. For the control loop; no division.
    #[must_use]
    pub fn angle_at(&self, now: Ticks) -> Option<Turn32> {
        let last = self.last.as_ref()?;
        let elapsed = u32::try_from(now.saturating_sub(last.edge.ticks)).unwrap_or(u32::MAX);
        if last.edge.interval == 0 {
            return Some(last.edge.angle);
        }
        let travel = u64::from(last.edge.moved.0.unsigned_abs()) * u64::from(elapsed);
        let travel = Recip::of_u32(last.edge.interval).times(travel);
        let next = self.next_edge(last.number, last.direction);
        let limit = self
            .angle_of(next, last.referenced)
            .minus(last.edge.angle)
            .0
            .unsigned_abs();
        let travel = u32::try_from(travel)
            .unwrap_or(u32::MAX)
            .min(limit)
            .cast_signed();
        Some(
            last.edge
                .angle
                .plus(TurnDelta32(travel.wrapping_mul(last.direction.sign()))),
        )
    }

    #[inline]
    fn angle_of(&self, edge: u32, referenced: bool) -> Turn32 {
        match &self.table {
            Some(table) => table.angle(edge, referenced),
            None => self.grid.angle(edge),
        }
    }

    fn next_edge(&self, edge: u32, direction: Direction) -> u32 {
        let edges = self.grid.shape().edges();
        match direction {
            Direction::Forward if edge.wrapping_add(1) >= edges => 0,
            Direction::Forward => edge + 1,
            Direction::Reverse if edge == 0 => edges - 1,
            Direction::Reverse => edge - 1,
        }
    }

    /// The step's way on the grid, for edges that can't be compared with the one before.
    fn grid_steps(&self, step: &Step) -> i32 {
        let size = self.grid.angle(u32::from(step.advance)).0.cast_signed();
        size.wrapping_mul(step.direction.sign())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{CLASSES_MAX, EncoderShape};

    fn step(edge: u32, ticks: Ticks, direction: Direction) -> Outcome {
        Outcome::Step(Step {
            ticks,
            edge,
            position: edge,
            interval: 1000,
            resync: 0,
            advance: 1,
            flags: Flags::REFERENCED,
            direction,
        })
    }

    const ENTRIES: [i16; 8] = [0, 1000, 0, -1000, 0, 0, 0, 500];

    fn corrector() -> Corrector<'static> {
        let shape = EncoderShape::new(8, 4).unwrap();
        let table = ErrorTable::new(shape, [TurnDelta32(0); CLASSES_MAX], &ENTRIES, 8).unwrap();
        Corrector::new(table, Anchor::Index)
    }

    #[test]
    fn angle_and_way_are_those_of_the_shaft_in_both_directions() {
        let mut corrector = corrector();
        corrector.push(&step(0, 0, Direction::Forward));
        let forward = corrector.push(&step(1, 1000, Direction::Forward)).unwrap();
        assert_eq!(forward.angle, Turn32((1 << 29) - 256_000));
        assert_eq!(forward.moved, TurnDelta32((1 << 29) - 256_000));
        let turned = corrector.push(&step(1, 2000, Direction::Reverse)).unwrap();
        assert_eq!(turned.moved, TurnDelta32(0));
        let back = corrector.push(&step(0, 3000, Direction::Reverse)).unwrap();
        assert_eq!(back.moved, TurnDelta32(-((1 << 29) - 256_000)));
    }

    #[test]
    fn between_edges_the_angle_goes_on_and_stops_at_the_next_edge() {
        let mut corrector = corrector();
        assert_eq!(corrector.angle_at(5), None);
        corrector.push(&step(1, 0, Direction::Forward));
        corrector.push(&step(2, 1000, Direction::Forward));
        let way = (1_u32 << 29) + 256_000;
        let half = corrector.angle_at(1500).unwrap();
        assert!(half.minus(Turn32((1 << 30) + way / 2)).0.abs() <= 2);
        let next = Turn32((3_u32 << 29) + 256_000);
        assert_eq!(corrector.angle_at(1_000_000).unwrap(), next);
        assert_eq!(corrector.angle_at(u64::MAX).unwrap(), next);
        // A clock read before the edge's own time gives the edge.
        assert_eq!(corrector.angle_at(3).unwrap(), Turn32(1 << 30));
    }

    #[test]
    fn a_glitch_takes_the_last_edge_back() {
        let mut corrector = corrector();
        corrector.push(&step(0, 0, Direction::Forward));
        corrector.push(&step(1, 1000, Direction::Forward));
        corrector.push(&Outcome::Glitch(crate::step::Glitch {
            ticks: 1010,
            edge: 1,
            position: 0,
        }));
        assert_eq!(corrector.last().unwrap().ticks, 0);
    }
}

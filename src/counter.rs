//! Position around one turn, wrapped by compare: no modulo, no division.

use crate::edge::Direction;
use crate::step::{MAX_SLOTS, SensorError};

/// Position `0..slots` of a sensor with `slots` edges a turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counter {
    position: u32,
    slots: u32,
}

impl Counter {
    /// A counter at position 0.
    ///
    /// # Errors
    /// [`SensorError::Slots`] for no slots or more than [`MAX_SLOTS`].
    pub const fn new(slots: u32) -> Result<Self, SensorError> {
        if slots == 0 || slots > MAX_SLOTS {
            return Err(SensorError::Slots);
        }
        Ok(Self { position: 0, slots })
    }

    /// Present position.
    #[inline]
    #[must_use]
    pub const fn position(&self) -> u32 {
        self.position
    }

    /// Edges in a turn.
    #[inline]
    #[must_use]
    pub const fn slots(&self) -> u32 {
        self.slots
    }

    /// Moves by one edge and returns the edge crossed.
    #[inline]
    pub const fn step(&mut self, direction: Direction) -> u32 {
        match direction {
            Direction::Forward => {
                let next = self.position + 1;
                self.position = if next == self.slots { 0 } else { next };
                self.position
            }
            Direction::Reverse => {
                let crossed = self.position;
                self.position = if crossed == 0 {
                    self.slots - 1
                } else {
                    crossed - 1
                };
                crossed
            }
        }
    }

    /// [`Counter::step`] where it does not go round the turn's end.
    #[inline]
    pub(crate) const fn step_within(&mut self, direction: Direction) -> u32 {
        // Without a branch: the edge is the new position going forward, the old one in reverse.
        let reverse = direction as u32;
        let edge = self.position.wrapping_sub(reverse).wrapping_add(1);
        self.position = edge.wrapping_sub(reverse);
        edge
    }

    /// Moves by `edges` and returns the last edge crossed. Takes `edges` steps: meant for a few.
    pub const fn advance(&mut self, direction: Direction, edges: u16) -> u32 {
        let mut crossed = self.position;
        let mut left = edges;
        while left > 0 {
            crossed = self.step(direction);
            left -= 1;
        }
        crossed
    }

    /// Sets the position, which must be below `slots` (a larger one is taken as 0), and returns the shortest signed way there.
    pub const fn set(&mut self, position: u32) -> i32 {
        let target = if position < self.slots { position } else { 0 };
        let way = target.cast_signed() - self.position.cast_signed();
        self.position = target;
        let turn = self.slots.cast_signed();
        if way > turn / 2 {
            way - turn
        } else if way < -(turn / 2) {
            way + turn
        } else {
            way
        }
    }

    /// The edge that was crossed to come to the present position in `direction`.
    #[inline]
    #[must_use]
    pub const fn edge_behind(&self, direction: Direction) -> u32 {
        let next = self.position + 1;
        match direction {
            Direction::Forward => self.position,
            Direction::Reverse if next == self.slots => 0,
            Direction::Reverse => next,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_edge_is_crossed_there_and_back() {
        let mut counter = Counter::new(8).unwrap();
        counter.set(7);
        assert_eq!(counter.step(Direction::Forward), 0);
        assert_eq!(counter.step(Direction::Reverse), 0);
        assert_eq!(counter.position(), 7);
        assert_eq!(counter.edge_behind(Direction::Reverse), 0);
    }

    #[test]
    fn steps_within_the_turn_are_those_of_any_step() {
        for direction in [Direction::Forward, Direction::Reverse] {
            let mut counter = Counter::new(8).unwrap();
            counter.set(4);
            let mut other = counter;
            for _ in 0..3 {
                assert_eq!(counter.step_within(direction), other.step(direction));
                assert_eq!(counter, other);
            }
        }
    }

    #[test]
    fn setting_tells_the_shortest_way() {
        let mut counter = Counter::new(8).unwrap();
        counter.set(6);
        assert_eq!(counter.set(1), 3);
        assert_eq!(counter.set(6), -3);
        assert_eq!(counter.set(99), 2);
        assert_eq!(counter.position(), 0);
    }

    #[test]
    fn no_slots_and_too_many_are_refused() {
        assert_eq!(Counter::new(0), Err(SensorError::Slots));
        assert_eq!(Counter::new(MAX_SLOTS + 1), Err(SensorError::Slots));
    }
}

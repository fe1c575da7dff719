//! Three Hall sensors: six states a pole pair, forward 001, 011, 010, 110, 100, 101 (A, B, C).
//!
//! There is no index: position counts from pole pair 0 wherever the shaft starts. Its state within the pole pair, position
//! mod 6, always agrees with the levels; after a fault the pole pair may be another one than before. Such steps carry
//! [`Flags::TURN_SUSPECT`] for one turn, after which whoever keeps a pattern of the turn has to align it anew.
//!
//! | event | what comes next | what is done |
//! |---|---|---|
//! | 1 to 3 edges lost | a jump over 1 to 3 states | steps on in settled motion, else the shorter way, suspect |
//! | 4 edges lost | a step back, no slowing down | abrupt reversal, suspect |
//! | 5 edges lost | the same levels | suspect |
//! | 6 edges lost | a step on after 7 intervals | interval spike, suspect |
//! | all sensors alike | 000 or 111 | illegal, no step, suspect |

use crate::counter::Counter;
use crate::edge::{Direction, Levels, Sample};
use crate::motion::Motion;
use crate::step::{Faults, Flags, MAX_SLOTS, Outcome, SensorError, Step, count};

/// State 0..6 of the sensors in forward order, none for 000 and 111.
#[inline]
#[must_use]
pub const fn state_of(levels: Levels) -> Option<u32> {
    // Bit 0 is A, 1 is B, 2 is C.
    match levels.0 & 7 {
        0b100 => Some(0),
        0b110 => Some(1),
        0b010 => Some(2),
        0b011 => Some(3),
        0b001 => Some(4),
        0b101 => Some(5),
        _ => None,
    }
}

/// Decoder state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HallDecoder {
    motion: Motion,
    counter: Counter,
    faults: Faults,
    /// State the sensors showed last, 0..6.
    state: u32,
    /// Edges for which the turn stays suspect.
    suspect: u32,
    started: bool,
    moved: bool,
}

impl HallDecoder {
    /// A decoder for a motor of `pole_pairs`: 6 edges each.
    ///
    /// # Errors
    /// [`SensorError::Slots`] for no pole pairs or more than 2^28 edges.
    pub const fn new(pole_pairs: u32) -> Result<Self, SensorError> {
        if pole_pairs > MAX_SLOTS / 6 {
            return Err(SensorError::Slots);
        }
        let counter = match Counter::new(pole_pairs * 6) {
            Ok(counter) => counter,
            Err(error) => return Err(error),
        };
        Ok(Self {
            motion: Motion::new(),
            counter,
            faults: Faults::new(),
            state: 0,
            suspect: 0,
            started: false,
            moved: false,
        })
    }

    /// Present position, `0..6 pole_pairs`.
    #[inline]
    #[must_use]
    pub const fn position(&self) -> u32 {
        self.counter.position()
    }

    /// Edges in a turn.
    #[inline]
    #[must_use]
    pub const fn slots(&self) -> u32 {
        self.counter.slots()
    }

    /// Whether a fault of the last turn may have moved the count by pole pairs.
    #[inline]
    #[must_use]
    pub const fn is_uncertain(&self) -> bool {
        self.suspect != 0
    }

    /// Faults so far.
    #[inline]
    #[must_use]
    pub const fn faults(&self) -> &Faults {
        &self.faults
    }

    /// Takes one sample: levels of A, B and C after a change.
    #[inline]
    pub fn push(&mut self, sample: Sample) -> Outcome {
        let Some(state) = state_of(sample.levels) else {
            count(&mut self.faults.illegal);
            self.suspect();
            return Outcome::Idle;
        };
        if !self.started {
            self.started = true;
            self.state = state;
            self.counter.set(state);
            self.motion.last = sample.ticks;
            return Outcome::Idle;
        }
        let ahead = if state >= self.state {
            state - self.state
        } else {
            state + 6 - self.state
        };
        self.state = state;
        match ahead {
            0 => self.repeat(sample),
            1 => self.step(sample, Direction::Forward, 1),
            5 => self.step(sample, Direction::Reverse, 1),
            _ => {
                let (direction, advance) = self.likely_jump(ahead);
                self.jump(sample, direction, advance)
            }
        }
    }

    fn repeat(&mut self, sample: Sample) -> Outcome {
        count(&mut self.faults.repeated);
        let interval = self.motion.interval(sample.ticks);
        if self.moved && !self.motion.is_harmless_repeat(interval) {
            self.suspect();
        }
        Outcome::Idle
    }

    /// Way to a state `ahead` (2 to 4): on in settled motion, else the shorter way.
    fn likely_jump(&self, ahead: u32) -> (Direction, u16) {
        let settled = self.motion.settled_direction();
        let direction = match ahead {
            _ if self.motion.is_settled() => settled,
            2 => Direction::Forward,
            4 => Direction::Reverse,
            _ => settled,
        };
        let edges = match direction {
            Direction::Forward => ahead,
            Direction::Reverse => 6 - ahead,
        };
        (direction, edges as u16)
    }

    fn jump(&mut self, sample: Sample, direction: Direction, advance: u16) -> Outcome {
        count(&mut self.faults.illegal);
        let outcome = self.step(sample, direction, advance);
        self.suspect();
        match outcome {
            Outcome::Step(step) => Outcome::Step(Step {
                flags: step.flags.with(Flags::ILLEGAL).with(Flags::TURN_SUSPECT),
                ..step
            }),
            other => other,
        }
    }

    #[inline]
    fn step(&mut self, sample: Sample, direction: Direction, advance: u16) -> Outcome {
        let mut interval = self.motion.interval(sample.ticks);
        let mut flags = Flags::NONE;
        if !self.moved {
            self.moved = true;
            self.motion.direction = direction;
            flags = Flags::FIRST;
            interval = u32::MAX;
        } else if direction != self.motion.direction {
            flags = Flags::REVERSED;
            let abrupt = self.motion.is_abrupt(interval);
            self.motion.reverse();
            if abrupt {
                count(&mut self.faults.abrupt_reversal);
                self.suspect();
                flags = flags.with(Flags::ABRUPT);
            }
        } else if self.motion.is_spike(interval / 5 * 3) {
            // Six lost edges make seven intervals; cogging alone reaches three, so the limit is five here.
            count(&mut self.faults.interval_spike);
            self.suspect();
            flags = Flags::SPIKE;
        }
        self.motion.push(sample.ticks, interval);
        let edge = self.counter.advance(direction, advance);
        if self.suspect != 0 {
            self.suspect -= 1;
            flags = flags.with(Flags::TURN_SUSPECT);
        }
        Outcome::Step(Step {
            ticks: sample.ticks,
            edge,
            position: self.counter.position(),
            interval,
            resync: 0,
            advance,
            flags,
            direction,
        })
    }

    fn suspect(&mut self) {
        self.suspect = self.counter.slots();
        self.motion.unsettle();
    }
}

#[cfg(test)]
mod tests;

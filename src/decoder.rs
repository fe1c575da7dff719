//! Quadrature decoder: A/B/Z samples to steps, direction, faults and the index.
//!
//! Position k is the state after forward edge k: k mod 4 = 0 is (A, B) = (1, 0), 1 is (1, 1), 2 is (0, 1), 3 is (0, 0). This
//! holds before and after the index. The index fires when Z is high in `index_state`, on entry to that condition by
//! whichever channel, in both directions; it marks the position below 4 with that state.
//!
//! # What lost and spurious edges look like
//! Out of steady motion (eight edges of history, edge errors up to 30 % of a step):
//!
//! | event | what comes next | what is done |
//! |---|---|---|
//! | 1 row lost | A and B change together | two steps in the settled direction, uncertain |
//! | 2 rows lost | a step back after 3 intervals, no slowing down | abrupt reversal, uncertain |
//! | 3 rows lost | the same levels after 4 intervals | uncertain |
//! | 4 rows lost | a step on after 5 intervals, then a usual one | interval spike, uncertain at the second |
//! | 1 or 2 spurious rows | steps there and back, a repeated row, or one of the above | count right, or uncertain |
//! | short pulse | an edge crossed back within the gate | both withdrawn, nothing uncertain |
//!
//! *Uncertain* is [`Flags::TURN_SUSPECT`]; it stays until an index agrees with the count
//! after eight edges in one direction. An index that does not agree
//! moves the count, is booked as lost or extra edges and leaves the flag set, as it may itself be the fault.
//!
//! # What cannot be seen
//! - Multiples of four edges lost at or close to a standstill, at a reversal or within eight edges after one: the times then
//!   allow true motion as well. The next index finds them.
//! - Sixteen typical intervals or more without an edge count as a stop, whatever was lost in it.
//! - Four spurious edges in a row in the direction of motion, before the index.
//! - Whole turns lost, and a first index that is false (the second one finds it).
//!
//! Z must be narrower than one line, or the index fires twice in a pass.

use crate::counter::Counter;
use crate::edge::{Direction, Levels, Sample};
use crate::motion::Motion;
use crate::step::{Faults, Flags, Glitch, Outcome, Reference, SensorError, Step, count};
use crate::units::Ticks;

/// What the encoder is; fixed for a decoder's life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DecoderConfig {
    /// Grating lines M; a turn has 4M edges.
    pub lines: u32,
    /// Levels of A and B (other bits ignored) in which a high Z marks line 0. (1, 0), the state after edge 0, by default.
    pub index_state: Levels,
    /// A pulse shorter than the typical interval times 2^-gate is a glitch. 3 by default; 2 to 31.
    pub glitch_gate: u32,
}

impl DecoderConfig {
    /// The usual settings for an encoder of `lines` lines.
    #[must_use]
    pub const fn new(lines: u32) -> Self {
        Self {
            lines,
            index_state: Levels(Levels::A),
            glitch_gate: 3,
        }
    }
}

/// Edge class of the forward edge that leads to the levels: 0 A rise, 1 B rise, 2 A fall, 3 B fall.
#[inline]
#[must_use]
pub const fn class_of(levels: Levels) -> u32 {
    // Two bits for each value of (B, A): 00 -> 3, 01 -> 0, 10 -> 2, 11 -> 1.
    (0b01_10_00_11 >> ((levels.0 & 3) * 2)) & 3
}

/// Decoder state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct QuadratureDecoder {
    motion: Motion,
    counter: Counter,
    faults: Faults,
    index_class: u32,
    gate: u32,
    /// REFERENCED and TURN_SUSPECT as they stand.
    status: Flags,
    /// Flags of the last step, to take them back with it.
    last_flags: Flags,
    /// Whether TURN_SUSPECT stood before the last step.
    suspect_before: bool,
    /// Limit for the interval after a suspected spike, 0 if there is none.
    spike_limit: u32,
    /// Z as it was last.
    z: bool,
    at_index: bool,
    started: bool,
    moved: bool,
}

impl QuadratureDecoder {
    /// A decoder that has seen nothing.
    ///
    /// # Errors
    /// [`SensorError::Slots`] for no lines or more than 2^26, [`SensorError::Gate`] for a gate out of range.
    pub const fn new(config: DecoderConfig) -> Result<Self, SensorError> {
        if config.glitch_gate < 2 || config.glitch_gate > 31 {
            return Err(SensorError::Gate);
        }
        let counter = match Counter::new(config.lines.saturating_mul(4)) {
            Ok(counter) => counter,
            Err(error) => return Err(error),
        };
        Ok(Self {
            motion: Motion::new(),
            counter,
            faults: Faults::new(),
            index_class: class_of(config.index_state),
            gate: config.glitch_gate,
            status: Flags::NONE,
            last_flags: Flags::NONE,
            suspect_before: false,
            spike_limit: 0,
            z: false,
            at_index: false,
            started: false,
            moved: false,
        })
    }

    /// Present position, `0..4 M`.
    #[inline]
    #[must_use]
    pub const fn position(&self) -> u32 {
        self.counter.position()
    }

    /// Edges in a turn, 4 M.
    #[inline]
    #[must_use]
    pub const fn slots(&self) -> u32 {
        self.counter.slots()
    }

    /// Present direction.
    #[inline]
    #[must_use]
    pub const fn direction(&self) -> Direction {
        self.motion.direction
    }

    /// Whether the index has been seen.
    #[inline]
    #[must_use]
    pub const fn is_referenced(&self) -> bool {
        self.status.contains(Flags::REFERENCED)
    }

    /// Whether the count may be wrong since the last index.
    #[inline]
    #[must_use]
    pub const fn is_uncertain(&self) -> bool {
        self.status.contains(Flags::TURN_SUSPECT)
    }

    /// Faults so far.
    #[inline]
    #[must_use]
    pub const fn faults(&self) -> &Faults {
        &self.faults
    }

    /// Takes one sample. Samples come in order of time; one that does not counts as an interval of 0.
    #[inline]
    pub fn push(&mut self, sample: Sample) -> Outcome {
        let class = class_of(sample.levels);
        let turned = class.wrapping_sub(self.counter.position()) & 3;
        let on = turned == self.turn_of_direction();
        if !on || !self.moved || self.spike_limit != 0 {
            return self.push_watchful(sample, class, turned);
        }
        self.step_on(sample, class)
    }

    /// Whatever is not one more step in the same direction: the first samples, changes of Z, reversals, faults, and the step
    /// after a long interval.
    #[cold]
    #[inline(never)]
    fn push_watchful(&mut self, sample: Sample, class: u32, turned: u32) -> Outcome {
        if !self.started {
            self.started = true;
            self.counter.set(class);
            self.motion.last = sample.ticks;
            return self.stay_index(sample, class);
        }
        if !self.moved && turned != 0 {
            return self.first_step(sample, class, turned);
        }
        if self.spike_limit != 0 && turned != 0 {
            let interval = self.motion.interval(sample.ticks);
            if turned != self.turn_of_direction() || interval < self.spike_limit {
                count(&mut self.faults.interval_spike);
                self.suspect();
                self.spike_limit = 0;
                return match self.push(sample) {
                    Outcome::Step(step) => Outcome::Step(Step {
                        flags: step.flags.with(Flags::SPIKE),
                        ..step
                    }),
                    other => other,
                };
            }
            self.spike_limit = 0;
        }
        match turned {
            0 => self.stay(sample, class),
            2 => self.jump(sample, class),
            _ if turned == self.turn_of_direction() => self.step_on(sample, class),
            _ => self.step_back(sample, class),
        }
    }

    #[inline]
    fn turn_of_direction(&self) -> u32 {
        match self.motion.direction {
            Direction::Forward => 1,
            Direction::Reverse => 3,
        }
    }

    fn first_step(&mut self, sample: Sample, class: u32, turned: u32) -> Outcome {
        self.moved = true;
        if turned == 3 {
            self.motion.direction = Direction::Reverse;
        }
        let mut flags = Flags::FIRST;
        if turned == 2 {
            count(&mut self.faults.illegal);
            self.suspect();
            flags = flags.with(Flags::ILLEGAL);
        }
        let advance = if turned == 2 { 2 } else { 1 };
        self.motion.push(sample.ticks, u32::MAX);
        self.accept(sample, class, u32::MAX, advance, flags)
    }

    /// One more step in the same direction.
    #[inline]
    fn step_on(&mut self, sample: Sample, class: u32) -> Outcome {
        let interval = self.motion.interval(sample.ticks);
        if self.motion.is_long(interval) && self.motion.is_spike(interval) {
            self.spike_limit = self.motion.steady_limit();
        }
        self.suspect_before = self.is_uncertain();
        self.motion.push(sample.ticks, interval);
        self.accept(sample, class, interval, 1, Flags::NONE)
    }

    /// A step against the direction of motion: a glitch, a reversal or lost edges.
    #[cold]
    #[inline(never)]
    fn step_back(&mut self, sample: Sample, class: u32) -> Outcome {
        let interval = self.motion.interval(sample.ticks);
        let gate = self.motion.typical_before_last() >> self.gate;
        if interval < gate
            && self
                .motion
                .withdraw(self.last_flags.contains(Flags::REVERSED))
        {
            return self.withdraw_pair(sample, class);
        }
        let mut flags = Flags::REVERSED;
        let suspect_before = self.is_uncertain();
        let abrupt = self.motion.is_abrupt(interval);
        self.motion.reverse();
        if abrupt {
            count(&mut self.faults.abrupt_reversal);
            self.suspect();
            flags = flags.with(Flags::ABRUPT);
        }
        self.suspect_before = suspect_before;
        self.motion.push(sample.ticks, interval);
        self.accept(sample, class, interval, 1, flags)
    }

    fn withdraw_pair(&mut self, sample: Sample, class: u32) -> Outcome {
        count(&mut self.faults.glitch);
        if self.last_flags.contains(Flags::ABRUPT) {
            self.faults.abrupt_reversal = self.faults.abrupt_reversal.saturating_sub(1);
            if !self.suspect_before {
                self.status = self.status.without(Flags::TURN_SUSPECT);
            }
        }
        self.last_flags = Flags::NONE;
        self.spike_limit = 0;
        // Across the same edge again, whichever way the first crossing went.
        let back = if class.wrapping_sub(self.counter.position()) & 3 == 1 {
            Direction::Forward
        } else {
            Direction::Reverse
        };
        let edge = self.counter.step(back);
        self.z = sample.levels.z();
        self.at_index = self.z && class == self.index_class;
        Outcome::Glitch(Glitch {
            ticks: sample.ticks,
            edge,
            position: self.counter.position(),
        })
    }

    /// A and B changed together.
    #[cold]
    #[inline(never)]
    fn jump(&mut self, sample: Sample, class: u32) -> Outcome {
        count(&mut self.faults.illegal);
        let interval = self.motion.interval(sample.ticks);
        let mut flags = Flags::ILLEGAL;
        if self.motion.settled_direction() != self.motion.direction {
            self.motion.reverse();
            flags = flags.with(Flags::REVERSED);
        }
        self.suspect();
        // The lost edge is put half way, so that typical intervals stay typical.
        let middle = self.motion.last.wrapping_add(Ticks::from(interval / 2));
        self.motion.push(middle, interval / 2);
        self.motion.push(sample.ticks, interval / 2);
        self.accept(sample, class, interval, 2, flags)
    }

    /// A and B as before: a change of Z, or no change at all.
    fn stay(&mut self, sample: Sample, class: u32) -> Outcome {
        let interval = self.motion.interval(sample.ticks);
        let late = if sample.levels.z() == self.z {
            count(&mut self.faults.repeated);
            self.moved && !self.motion.is_harmless_repeat(interval)
        } else {
            // Z rows come half an interval after an edge; one that comes late may follow a whole lost line.
            self.motion.is_late(interval)
        };
        if late {
            self.suspect();
        }
        self.stay_index(sample, class)
    }

    fn stay_index(&mut self, sample: Sample, class: u32) -> Outcome {
        self.z = sample.levels.z();
        let at_index = self.z && class == self.index_class;
        let entered = at_index && !self.at_index;
        self.at_index = at_index;
        if !entered {
            return Outcome::Idle;
        }
        let (resync, flags) = self.index();
        Outcome::Index(Reference {
            ticks: sample.ticks,
            position: self.counter.position(),
            resync,
            flags,
        })
    }

    /// Moves the position and looks for the index.
    #[inline]
    fn accept(
        &mut self,
        sample: Sample,
        class: u32,
        interval: u32,
        advance: u16,
        flags: Flags,
    ) -> Outcome {
        let direction = self.motion.direction;
        let mut edge = self.counter.step(direction);
        if advance == 2 {
            edge = self.counter.step(direction);
        }
        let mut resync = 0;
        let mut flags = flags;
        self.z = sample.levels.z();
        let at_index = self.z && class == self.index_class;
        if at_index && !self.at_index {
            let (moved, found) = self.index();
            resync = moved;
            flags = flags.with(found);
            edge = self.counter.edge_behind(direction);
        } else {
            flags = flags.with(self.status);
        }
        self.at_index = at_index;
        self.last_flags = flags;
        Outcome::Step(Step {
            ticks: sample.ticks,
            edge,
            position: self.counter.position(),
            interval,
            resync,
            advance,
            flags,
            direction,
        })
    }

    /// The index marks the present state: references the position, or holds the count against it.
    #[cold]
    #[inline(never)]
    fn index(&mut self) -> (i32, Flags) {
        let moved = self.counter.set(self.index_class);
        if !self.is_referenced() {
            self.status = Flags::REFERENCED;
            return (0, self.status.with(Flags::INDEX));
        }
        if moved == 0 {
            let found = self.status.with(Flags::INDEX);
            // Among spurious rows a spurious index could agree with a wrong count.
            if self.motion.is_settled() {
                self.status = Flags::REFERENCED;
                self.suspect_before = false;
                self.spike_limit = 0;
            }
            return (0, found);
        }
        self.faults
            .book_resync(moved, self.motion.settled_direction());
        self.suspect();
        (moved, self.status.with(Flags::INDEX))
    }

    #[inline]
    fn suspect(&mut self) {
        self.status = self.status.with(Flags::TURN_SUSPECT);
        self.suspect_before = true;
        self.motion.unsettle();
    }
}

#[cfg(test)]
mod tests;

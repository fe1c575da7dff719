//! The decoder's rare paths: start, changes of Z, reversals, glitches, faults and the index.

use super::plain::Plain;
use super::{QuadratureDecoder, class_of};
use crate::edge::{Direction, Sample};
use crate::step::{Flags, Glitch, Outcome, Reference, Step, count};
use crate::units::Ticks;

impl QuadratureDecoder {
    /// Whatever is not a plain step: the first samples, changes of Z and steps while it is high, reversals, faults, the step
    /// that ends a turn, and steps before motion is steady.
    #[cold]
    #[inline(never)]
    pub(crate) fn push_watchful(&mut self, sample: Sample) -> Outcome {
        let outcome = self.take(sample);
        self.next = self.foresee();
        outcome
    }

    /// The plain step that may follow.
    fn foresee(&self) -> Plain {
        // A plain step leaves these as they are.
        let quiet = self.moved
            && !self.z
            && self.spike_limit == 0
            && self.last_flags == self.status
            && self.suspect_before == self.is_uncertain();
        if quiet && self.motion.is_full() {
            Plain::after(
                &self.counter,
                self.motion.direction,
                self.status,
                self.motion.quick_limit(),
            )
        } else {
            Plain::NONE
        }
    }

    /// Takes a sample of any kind.
    fn take(&mut self, sample: Sample) -> Outcome {
        let class = class_of(sample.levels);
        let turned = class.wrapping_sub(self.counter.position()) & 3;
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
                return match self.take(sample) {
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

    pub(super) fn stay_index(&mut self, sample: Sample, class: u32) -> Outcome {
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

    /// The index marks the present state: references the position, or holds the count against it.
    #[cold]
    #[inline(never)]
    pub(super) fn index(&mut self) -> (i32, Flags) {
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
        let found = self.status.with(Flags::INDEX);
        self.status = self.status.without(Flags::LOCATED);
        (moved, found)
    }

    #[inline]
    pub(super) fn suspect(&mut self) {
        self.status = self.status.with(Flags::TURN_SUSPECT);
        self.suspect_before = true;
        self.motion.unsettle();
    }
}

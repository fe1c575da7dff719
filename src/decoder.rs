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
//! Rows of which the driver knows that they are missing are told by [`QuadratureDecoder::missed`]: uncertain, whatever comes next.
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
//!
//! # Cost
//! One more step of settled motion while Z is low is told by three compares and done inline; everything else is out of line.
//! The table in the library's head has the count.

mod plain;
mod rare;

use crate::counter::Counter;
use crate::edge::{Direction, Levels, Sample};
use crate::motion::Motion;
use crate::step::{Faults, Flags, Outcome, SensorError, Step, count};
use crate::units::Ticks;
use plain::Plain;

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
    /// What the next sample must be like to need no second look.
    next: Plain,
    counter: Counter,
    motion: Motion,
    faults: Faults,
    index_class: u32,
    gate: u32,
    /// REFERENCED, LOCATED and TURN_SUSPECT as they stand.
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
            next: Plain::NONE,
            counter,
            motion: Motion::new(),
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

    /// Moves the count forward by `offset` edges, to where the fingerprint found the shaft: from here on positions are angles of
    /// the disc, as after an index, and no doubt from before stands. Steps say [`Flags::LOCATED`] until the index comes. One that
    /// agrees changes nothing else; one that does not moves the count, which stays in doubt until the next. False, with nothing
    /// done, where a reference is known already or the offset is not of whole lines. Divides, so not for the edge path.
    pub fn locate(&mut self, offset: u32) -> bool {
        if self.is_referenced() || !self.moved || !offset.is_multiple_of(4) {
            return false;
        }
        let slots = self.counter.slots();
        self.counter
            .set((self.counter.position() + offset % slots) % slots);
        self.status = Flags::REFERENCED.with(Flags::LOCATED);
        self.suspect_before = false;
        self.spike_limit = 0;
        self.next = Plain::NONE;
        true
    }

    /// Whether the index has been seen, or the fingerprint found.
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

    /// Samples are missing here, an unknown number: counts it and doubts the count until an index agrees.
    ///
    /// ```
    /// use quadcal::decoder::{DecoderConfig, QuadratureDecoder};
    ///
    /// let mut decoder = QuadratureDecoder::new(DecoderConfig::new(250)).unwrap();
    /// decoder.missed();
    /// assert!(decoder.is_uncertain() && decoder.faults().missed == 1);
    /// ```
    #[cold]
    pub fn missed(&mut self) {
        count(&mut self.faults.missed);
        self.suspect();
        self.watch();
    }

    /// Takes one sample. Samples come in order of time; one that does not counts as an interval of 0.
    #[inline]
    pub fn push(&mut self, sample: Sample) -> Outcome {
        match self.push_plain(sample) {
            Some(step) => Outcome::Step(step),
            None => self.push_watchful(sample),
        }
    }

    /// Takes a sample if it is a plain step; else nothing is done.
    #[inline(always)]
    pub(crate) fn push_plain(&mut self, sample: Sample) -> Option<Step> {
        let elapsed = sample.ticks.wrapping_sub(self.motion.last);
        let position = self.counter.position();
        if !self.next.is(sample.levels, elapsed, position) {
            return None;
        }
        let direction = self.motion.direction;
        let edge = self.counter.step_within(direction);
        self.next.pass(self.motion.push_steady(sample.ticks));
        Some(Step {
            ticks: sample.ticks,
            edge,
            position: self.counter.position(),
            interval: elapsed as u32,
            resync: 0,
            advance: self.next.advance,
            flags: self.next.flags,
            direction,
        })
    }

    /// Flags of a plain step that may follow.
    pub(crate) fn plain_flags(&self) -> Flags {
        self.next.flags
    }

    /// Lets no sample be a plain step before the next closer look.
    pub(crate) fn watch(&mut self) {
        self.next = Plain::NONE;
    }

    /// Lets no plain step cross a turn's last edge, so that the one after it has the next number or the one before.
    pub(crate) fn watch_last_edge(&mut self) {
        let last = self.slots() - 1;
        if self.next.seam == last && self.position() != last {
            self.next.seam = last - 1;
        }
    }

    /// The plain step `back` steps ago, at most seven; every step since was one as well, and a closer look has not followed.
    pub(crate) fn past_plain(&self, back: u32) -> Step {
        let direction = self.motion.direction;
        // Plain steps do not go round the turn's end.
        let then = |place: u32| match direction {
            Direction::Forward => place.wrapping_sub(back),
            Direction::Reverse => place.wrapping_add(back),
        };
        Step {
            ticks: self
                .motion
                .last
                .wrapping_sub(Ticks::from(self.motion.between(0, back))),
            edge: then(self.counter.edge_behind(direction)),
            position: then(self.counter.position()),
            interval: self.motion.between(back, back + 1),
            resync: 0,
            advance: self.next.advance,
            flags: self.next.flags,
            direction,
        }
    }

    #[inline]
    fn turn_of_direction(&self) -> u32 {
        match self.motion.direction {
            Direction::Forward => 1,
            Direction::Reverse => 3,
        }
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
}

#[cfg(test)]
pub(crate) mod tests;

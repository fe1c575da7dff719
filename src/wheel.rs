//! One channel: a toothed wheel, or magnets passing a sensor; possibly with missing teeth as the reference.
//!
//! Slots are tooth pitches, or half pitches where both edges count; missing teeth keep their slots. Direction can't be seen
//! and is always forward. Times are taken from rising edge to rising edge, so the tooth's width does not matter.
//!
//! With missing teeth the gap is the index: the first tooth after it is slot 0. An interval is the gap when it is longer
//! than missing + 1/2 times the one before, so that one lost tooth is no gap of two. (It is a gap of one: on such a wheel a
//! lost tooth shows as a gap at the wrong place.) A gap anywhere but at the end of the count is booked as lost or extra edges, resynchronised and flagged, as is a turn that ends without one.
//!
//! Without missing teeth position counts from the first edge. In steady motion an interval of 1.6 pitches or more is taken
//! as lost pulses (up to fourteen, booked as lost), and one below the glitch gate as a spurious pulse; the slots are suspect
//! for one turn. Motion stays steady as if they had come, so that the next ones that are lost are counted as well. Lost
//! pulses in unsteady motion can't be seen.

mod config;

/// Pulses lost one after the other that are counted; more of them are a standstill.
const LOST: u16 = 14;

use crate::counter::Counter;
use crate::edge::{Direction, Sample};
use crate::motion::Motion;
use crate::step::{Faults, Flags, Glitch, Outcome, SensorError, Step, count};
use crate::units::Ticks;

pub use config::WheelConfig;

/// Decoder state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WheelDecoder {
    config: WheelConfig,
    counter: Counter,
    /// Rising edges only, in pitches.
    motion: Motion,
    faults: Faults,
    /// Time of the last edge of either kind.
    last: Ticks,
    /// Last pitch that was no gap, ticks; 0 before there is one.
    pitch: u32,
    /// Edges for which the turn stays suspect without an index.
    suspect: u32,
    status: Flags,
    high: bool,
    started: bool,
}

impl WheelDecoder {
    /// A decoder that has seen nothing.
    ///
    /// # Errors
    /// [`SensorError`] for a wheel that can't be.
    pub const fn new(config: WheelConfig) -> Result<Self, SensorError> {
        let counter = match config.counter() {
            Ok(counter) => counter,
            Err(error) => return Err(error),
        };
        Ok(Self {
            config,
            counter,
            motion: Motion::new(),
            faults: Faults::new(),
            last: 0,
            pitch: 0,
            suspect: 0,
            status: Flags::NONE,
            high: false,
            started: false,
        })
    }

    /// Present position in slots.
    #[inline]
    #[must_use]
    pub const fn position(&self) -> u32 {
        self.counter.position()
    }

    /// Slots in a turn.
    #[inline]
    #[must_use]
    pub const fn slots(&self) -> u32 {
        self.counter.slots()
    }

    /// Whether the count may be wrong.
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

    /// Takes one sample of channel A.
    pub fn push(&mut self, sample: Sample) -> Outcome {
        let high = sample.levels.a();
        if self.config.both_edges {
            let repeated = self.started && high == self.high;
            self.high = high;
            if repeated {
                count(&mut self.faults.repeated);
                self.suspect();
                return Outcome::Idle;
            }
        }
        match (high, self.started) {
            (true, true) => self.rise(sample),
            (true, false) => self.first(sample),
            (false, true) if self.config.both_edges => self.accept(sample, 1, 0, Flags::NONE),
            (false, _) => Outcome::Idle,
        }
    }

    fn first(&mut self, sample: Sample) -> Outcome {
        self.started = true;
        self.counter.set(self.counter.slots() - 1);
        self.motion.push(sample.ticks, u32::MAX);
        let outcome = self.accept(sample, 1, 0, Flags::FIRST);
        match outcome {
            Outcome::Step(step) => Outcome::Step(Step {
                interval: u32::MAX,
                ..step
            }),
            other => other,
        }
    }

    /// Edges of one pitch.
    const fn pitch_edges(&self) -> u16 {
        if self.config.both_edges { 2 } else { 1 }
    }

    fn rise(&mut self, sample: Sample) -> Outcome {
        let pitch = self.motion.interval(sample.ticks);
        if pitch < self.pitch >> self.config.glitch_gate {
            return self.withdraw(sample);
        }
        if self.config.missing > 0 && self.is_gap(pitch) {
            return self.gap(sample, pitch);
        }
        let lost = if self.config.missing == 0 {
            self.lost(pitch)
        } else {
            0
        };
        if lost > 0 {
            self.faults.lost = self
                .faults
                .lost
                .saturating_add(u32::from(lost * self.pitch_edges()));
            self.suspect();
            self.motion.push_lost(lost, self.pitch);
            self.motion
                .push(sample.ticks, self.motion.interval(sample.ticks));
            return self.accept(sample, 1 + lost * self.pitch_edges(), 0, Flags::SPIKE);
        }
        self.pitch = pitch;
        self.motion.push(sample.ticks, pitch);
        let outcome = self.accept(sample, 1, 0, Flags::NONE);
        // The count must not run into the missing teeth.
        if self.config.missing > 0 && self.status.contains(Flags::REFERENCED) {
            let gap = u32::from(self.config.missing * self.pitch_edges());
            if self.counter.position() + gap >= self.counter.slots() {
                self.suspect();
            }
        }
        outcome
    }

    /// A pulse under the gate. With both edges the tooth's fall in between was reported and is withdrawn.
    fn withdraw(&mut self, sample: Sample) -> Outcome {
        count(&mut self.faults.glitch);
        if !self.config.both_edges {
            return Outcome::Idle;
        }
        let edge = self.counter.step(Direction::Reverse);
        self.last = self.motion.last;
        Outcome::Glitch(Glitch {
            ticks: sample.ticks,
            edge,
            position: self.counter.position(),
        })
    }

    fn is_gap(&self, pitch: u32) -> bool {
        let limit = u64::from(self.pitch) * (u64::from(self.config.missing) * 2 + 1);
        self.pitch != 0 && u64::from(pitch) * 2 > limit
    }

    fn gap(&mut self, sample: Sample, pitch: u32) -> Outcome {
        // Slot 0 follows; the pitch before the gap stays the measure.
        self.motion.push(sample.ticks, pitch);
        let gap = self.config.missing * self.pitch_edges();
        let advance = 1 + gap;
        self.counter.advance(Direction::Forward, gap);
        let expected = self.counter.slots() - 1;
        let resync = self.counter.set(expected);
        let before = self.status;
        if !before.contains(Flags::REFERENCED) {
            self.status = Flags::REFERENCED;
            return self.accept(sample, advance, 0, Flags::INDEX);
        }
        if resync == 0 {
            self.status = Flags::REFERENCED;
            return self.accept(sample, advance, 0, Flags::INDEX.with(before));
        }
        self.faults.book_resync(resync, Direction::Forward);
        self.suspect();
        self.accept(sample, advance, resync, Flags::INDEX)
    }

    /// Pulses missing before this one, in steady motion.
    fn lost(&self, pitch: u32) -> u16 {
        let (tenths, last) = (u64::from(pitch) * 10, u64::from(self.pitch));
        if !self.motion.is_steady() || tenths < last * 16 {
            return 0;
        }
        let longest = (1..=LOST).find(|lost| tenths < last * u64::from(lost * 10 + 15));
        longest.unwrap_or(0)
    }

    /// Counts the last of `advance` slots; the ones before are the gap's or lost ones.
    fn accept(&mut self, sample: Sample, advance: u16, resync: i32, flags: Flags) -> Outcome {
        let passed = if flags.contains(Flags::SPIKE) {
            advance - 1
        } else {
            0
        };
        self.counter.advance(Direction::Forward, passed);
        let edge = self.counter.step(Direction::Forward);
        let elapsed = sample.ticks.saturating_sub(self.last);
        self.last = sample.ticks;
        let flags = flags.with(self.status);
        if self.suspect != 0 {
            self.suspect -= 1;
            if self.suspect == 0 {
                self.status = self.status.without(Flags::TURN_SUSPECT);
            }
        }
        Outcome::Step(Step {
            ticks: sample.ticks,
            edge,
            position: edge,
            interval: u32::try_from(elapsed).unwrap_or(u32::MAX),
            resync,
            advance,
            flags,
            direction: Direction::Forward,
        })
    }

    fn suspect(&mut self) {
        self.status = self.status.with(Flags::TURN_SUSPECT);
        if self.config.missing == 0 {
            self.suspect = self.counter.slots();
        } else {
            self.motion.unsettle();
        }
    }
}

#[cfg(test)]
mod tests;

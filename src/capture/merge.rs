//! Streams of captures to one series of samples.

use super::{CaptureSource, Change, Channel, Event, Latch, Loss};
use crate::edge::{Levels, Sample};
use crate::step::count;
use crate::timebase::Timebase;
use crate::units::Ticks;

/// All channels.
const ALL: u8 = Levels::A | Levels::B | Levels::Z;

/// Channels without which nothing can be counted. While Z is not known it is given as low.
const COUNTED: u8 = Levels::A | Levels::B;

/// Drains a chip's captures: samples for a decoder, in order of time, with 64-bit times. `BITS` is the timer's width.
///
/// Draining takes no division, no floating point and no allocation, and cannot panic. [`CaptureSource`] has an example.
pub struct Captures<S, const BITS: u32 = 32> {
    source: S,
    timebase: Timebase<BITS>,
    /// The counter at the last look; none before the first.
    before: Option<u32>,
    /// Pins at the last look, if they can be held against captures.
    pins: Option<Levels>,
    levels: Levels,
    /// Channels whose level is known.
    known: u8,
    /// Channels whose pin has to bear out at the next look what it said at the last one.
    odd: u8,
    /// Streams whose oldest capture was out of time at the last look, a bit each.
    doubted: u8,
    /// Whether B changed after A.
    b_last: bool,
    /// Whether a decoder knows where levels began.
    started: bool,
    missed: u32,
}

impl<S: CaptureSource, const BITS: u32> Captures<S, BITS> {
    const MASK: u32 = u32::MAX >> (32 - BITS);

    /// Captures of a source that has just started: its timer has not wrapped yet.
    pub const fn new(source: S) -> Self {
        const { assert!(S::STREAMS == 1 || S::STREAMS == 3, "1 or 3 streams") };
        Self {
            source,
            timebase: Timebase::new(),
            before: None,
            pins: None,
            levels: Levels(0),
            known: 0,
            odd: 0,
            doubted: 0,
            b_last: false,
            started: false,
            missed: 0,
        }
    }

    /// The time now, ticks, for [`Encoder::now`](crate::encoder::Encoder::now). Not while a drain is under way.
    #[inline]
    pub fn now(&mut self) -> Ticks {
        let (counter, overflowed) = self.source.clock();
        self.timebase.now(counter, overflowed)
    }

    /// Times that captures were missing so far; saturates.
    #[must_use]
    pub const fn missed(&self) -> u32 {
        self.missed
    }

    /// The source, for what else its driver can do. Whoever looks or takes through it loses captures.
    pub const fn source(&mut self) -> &mut S {
        &mut self.source
    }

    /// Gives every capture that hardware has had time to hand over, oldest first, and what is missing. At least every half period of the
    /// timer, and before the hardware's memory is full.
    #[inline]
    pub fn drain(&mut self, mut give: impl FnMut(Event)) {
        let look = self.source.look();
        let now = self.timebase.now(look.counter, look.overflowed);
        if look.overflowed {
            self.timebase.overflow();
        }
        let settle = self.source.settle().max(1);
        let mut heads = [0; 3];
        for (stream, head) in heads.iter_mut().enumerate().take(S::STREAMS) {
            *head = Self::age(look.counter, self.source.oldest(stream));
        }
        // No capture can be older: the last drain would have taken it.
        let mut oldest = Self::MASK;
        let lost = look.over_captured | look.overrun;
        if let Some(before) = self.before {
            let elapsed = look.counter.wrapping_sub(before) & Self::MASK;
            oldest = elapsed.saturating_add(settle);
            if let Some(pins) = self.pins
                && lost == 0
            {
                let quiet = Self::quiet(heads, elapsed, settle);
                let differ = self.levels.0 ^ pins.0;
                if quiet & (differ | self.odd | !self.known) != 0 {
                    let then = now.saturating_sub(Ticks::from(oldest));
                    self.follow_pins(pins, quiet, then, &mut give);
                }
            }
        }
        self.before = Some(look.counter);
        // A loss may have come after the pins were read, and an overrun takes captures away that could tell an edge near them.
        self.pins = look.levels.filter(|_| lost == 0);
        if look.over_captured != 0 {
            self.lose(Loss::OverCapture, look.over_captured, &mut give);
        }
        if look.overrun != 0 {
            self.lose(Loss::Overrun, look.overrun, &mut give);
        }
        let mut doubted = 0;
        loop {
            let (stream, age) = self.first(heads);
            if age < settle {
                break;
            }
            if age > oldest {
                // Memory that DMA has counted but not written yet holds an old capture. At the next look it holds the new one; if it
                // does not, a capture came later than the source says.
                let bit = 1 << stream;
                if self.doubted & bit == 0 {
                    doubted |= bit;
                    let [a, b, z] = heads;
                    heads = match stream {
                        0 => [0, b, z],
                        1 => [a, 0, z],
                        _ => [a, b, 0],
                    };
                    continue;
                }
                self.lose(Loss::Overrun, ALL, &mut give);
                oldest = Self::MASK;
            }
            // A number that the compiler knows makes each of these a few instructions.
            let [a, b, z] = &mut heads;
            let taken = match stream {
                0 => self.take(0, a, look.counter),
                1 => self.take(1, b, look.counter),
                _ => self.take(2, z, look.counter),
            };
            if taken & self.known != 0 && self.started && self.known & COUNTED == COUNTED {
                give(Event::Change(Sample {
                    ticks: now.wrapping_sub(Ticks::from(age)),
                    levels: Levels(self.levels.0 & self.known),
                }));
            }
        }
        self.doubted = doubted;
    }

    /// Takes a stream's oldest capture and looks at the one after it. Returns the channels that may have changed.
    #[inline(always)]
    fn take(&mut self, stream: usize, head: &mut u32, counter: u32) -> u8 {
        let taken = self.source.take(stream);
        *head = Self::age(counter, self.source.oldest(stream));
        taken.map_or(0, |latch| self.apply(latch.change))
    }

    /// Ticks from a capture to the look; 0 where there is none or it was made after the look.
    #[inline]
    fn age(counter: u32, latch: Option<Latch>) -> u32 {
        let Some(latch) = latch else {
            return 0;
        };
        let age = counter.wrapping_sub(latch.raw) & Self::MASK;
        if age > Self::MASK / 2 { 0 } else { age }
    }

    /// The stream of the oldest capture, and its age.
    #[inline]
    const fn first(&self, heads: [u32; 3]) -> (usize, u32) {
        let [a, b, z] = heads;
        let (stream, age) = if a > b || (a == b && self.b_last) {
            (0, a)
        } else {
            (1, b)
        };
        if z > age || (z == age && self.levels.z()) {
            (2, z)
        } else {
            (stream, age)
        }
    }

    #[inline]
    const fn apply(&mut self, change: Change) -> u8 {
        match change {
            Change::Of(channel) => {
                self.levels.0 ^= channel.bit();
                match channel {
                    Channel::A => self.b_last = false,
                    Channel::B => self.b_last = true,
                    Channel::Z => {}
                }
                channel.bit()
            }
            Change::To(levels) => {
                self.levels = levels;
                self.known = ALL;
                self.started = true;
                ALL
            }
        }
    }

    /// Channels without an edge around the last look, so that its pins are what is rebuilt from the captures before it.
    #[inline]
    fn quiet(heads: [u32; 3], elapsed: u32, settle: u32) -> u8 {
        // Edges before the look were to be in their streams at this one.
        if elapsed < 2 * settle {
            return 0;
        }
        let [a, b, z] = heads;
        let since = elapsed - settle;
        let free = |age: u32, channels: u8| if age < since { channels } else { 0 };
        if S::STREAMS == 1 {
            free(a, ALL)
        } else {
            free(a, Levels::A) | free(b, Levels::B) | free(z, Levels::Z)
        }
    }

    /// Holds the pins of the last look, at which the channels `quiet` had no edge, against the rebuilt levels. A channel has to differ
    /// twice: once may be a pulse that the input filter swallows.
    #[cold]
    #[inline(never)]
    fn follow_pins(&mut self, pins: Levels, quiet: u8, then: Ticks, give: &mut impl FnMut(Event)) {
        let new = quiet & !self.known;
        let differ = (self.levels.0 ^ pins.0) & quiet;
        let wrong = differ & self.odd;
        self.levels.0 ^= wrong | (differ & new);
        self.odd = (self.odd & !quiet) | (differ & !wrong) | new;
        self.known |= new;
        if wrong != 0 {
            count(&mut self.missed);
            give(Event::Missed(Loss::Levels));
        }
        if self.known == ALL && !self.started {
            self.started = true;
            give(Event::Change(Sample {
                ticks: then,
                levels: self.levels,
            }));
        }
    }

    /// The levels of `channels` are not known any more.
    #[cold]
    #[inline(never)]
    fn lose(&mut self, loss: Loss, channels: u8, give: &mut impl FnMut(Event)) {
        self.known &= !channels;
        self.odd &= !channels;
        count(&mut self.missed);
        give(Event::Missed(loss));
    }
}

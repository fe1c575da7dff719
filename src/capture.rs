//! Captures out of any chip's hardware, drained a batch at a time: the trait that a chip's driver implements, and what makes samples
//! for a decoder of them.
//!
//! Hardware latches a free-running timer at each edge and keeps the latches: DMA in a stream of its own for each channel, a state
//! machine in a queue. [`Captures`] drains them every control period, or less often. It merges the streams by time, also over the timer's
//! wrap, rebuilds the levels that DMA does not tell, and checks them against the pins. A drive that has an interrupt at each edge
//! needs none of it: [`Encoder::edge`](crate::encoder::Encoder::edge) takes its captures.
//!
//! # Order of edges
//! - Captures come out in order of time, whatever stream they are in. Ones younger than the time that hardware takes
//!   ([`CaptureSource::settle`]) wait for the next drain, as an older one of another channel may not be there yet.
//! - A and B captured at the same tick: the one goes first that goes on in the direction of motion.
//! - Z captured at the same tick as A or B: its end goes first and its begin last, so that Z is never high in a state too many.
//!
//! # Losses
//! | [`Loss`] | how it is seen | what is done |
//! |---|---|---|
//! | `OverCapture` | the timer's flag: a latch was overwritten before it was fetched | the batch is left out, if it was of A or B |
//! | `Overrun` | captures were overwritten before they were drained, or came later than hardware may take | the same |
//! | `Levels` | pins and rebuilt levels differ at two looks, no edge being near | levels are those of the pins from there on |
//!
//! Each is told before the samples that it makes doubtful; [`Encoder::take`](crate::encoder::Encoder::take) hands it to the decoder, which
//! counts it ([`Faults::missed`](crate::step::Faults::missed)) and doubts the count until the index.
//!
//! After a batch was left out, samples go on from the next look on whose pins were read with no edge near, for each channel that lost some.
//! Z is low until then. `Levels` is found one drain after the second look: pins are compared once it is known that no edge was under way.
//! One look alone may have met a pulse that the input filter swallows.

mod merge;

use crate::edge::{Levels, Sample};

pub use merge::Captures;

/// Channel of a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Channel {
    /// A.
    A,
    /// B.
    B,
    /// The index.
    Z,
}

impl Channel {
    /// Its bit in [`Levels`].
    ///
    /// ```
    /// use quadcal::capture::Channel;
    /// use quadcal::edge::Levels;
    ///
    /// assert_eq!(Channel::Z.bit(), Levels::Z);
    /// ```
    #[inline]
    #[must_use]
    pub const fn bit(self) -> u8 {
        match self {
            Self::A => Levels::A,
            Self::B => Levels::B,
            Self::Z => Levels::Z,
        }
    }
}

/// What a capture tells of the levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Change {
    /// This channel changed.
    Of(Channel),
    /// The levels are these since.
    To(Levels),
}

/// One capture as hardware keeps it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Latch {
    /// The latched counter, ticks, 0 to 2^`BITS` - 1.
    pub raw: u32,
    /// What changed.
    pub change: Change,
}

/// What hardware says when it is looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Look {
    /// The counter, ticks, 0 to 2^`BITS` - 1.
    pub counter: u32,
    /// Whether the timer wrapped since the last look: its flag, read after the counter and cleared if it was set.
    pub overflowed: bool,
    /// Levels of the pins, read just before the counter; none where an interrupt came in between.
    pub levels: Option<Levels>,
    /// Channels of which a latch was overwritten since the last look, read after the counter; bits as in [`Levels`].
    pub over_captured: u8,
    /// Channels whose stream was overwritten before it was drained, or has stopped; bits as in [`Levels`]. The stream is empty now.
    pub overrun: u8,
}

/// Captures that hardware has made and keeps: what a chip's driver implements.
///
/// # Contract
/// - [`Self::look`] comes at least every half period of the timer.
/// - A stream is in order of time. What [`Self::oldest`] hands out was captured before the last look ended; a look's counter is read before
///   the streams' ends.
///
/// ```
/// use std::collections::VecDeque;
///
/// use quadcal::capture::{CaptureSource, Captures, Change, Latch, Look};
/// use quadcal::edge::Levels;
/// use quadcal::encoder::{Encoder, EncoderConfig};
///
/// /// A state machine that queues time and levels at each change.
/// struct Queue {
///     queue: VecDeque<(u32, Levels)>,
///     counter: u32,
///     levels: Levels,
/// }
///
/// impl CaptureSource for Queue {
///     const STREAMS: usize = 1;
///
///     fn settle(&self) -> u32 {
///         10
///     }
///
///     fn clock(&mut self) -> (u32, bool) {
///         (self.counter, false)
///     }
///
///     fn look(&mut self) -> Look {
///         Look { counter: self.counter, levels: Some(self.levels), ..Look::default() }
///     }
///
///     fn oldest(&mut self, _stream: usize) -> Option<Latch> {
///         let &(raw, levels) = self.queue.front()?;
///         Some(Latch { raw, change: Change::To(levels) })
///     }
///
///     fn take(&mut self, stream: usize) -> Option<Latch> {
///         let taken = self.oldest(stream);
///         self.queue.pop_front();
///         taken
///     }
/// }
///
/// let mut queue = Queue { queue: VecDeque::new(), counter: 500, levels: Levels(0) };
/// // 60 r/min forward with 250 lines, at 1 MHz: 1000 ticks an edge.
/// for k in 1..41 {
///     queue.levels = Levels([0, 1, 3, 2][k as usize % 4]);
///     queue.counter = 1000 * k;
///     queue.queue.push_back((queue.counter, queue.levels));
/// }
/// queue.counter += 500;
///
/// let mut captures: Captures<Queue> = Captures::new(queue);
/// let mut encoder: Encoder = Encoder::new(EncoderConfig::new(250, 100_000), None).unwrap();
/// // The control loop, once a period.
/// captures.drain(|event| {
///     encoder.take(event);
/// });
/// assert!((encoder.speed_at(captures.now()).rpm(1e6) - 60.0).abs() < 1e-6);
/// assert_eq!(encoder.faults().total(), 0);
/// ```
pub trait CaptureSource {
    /// How captures are kept: 1 for one stream of all channels, 3 for a stream of each, in the order A, B, Z.
    const STREAMS: usize;

    /// Ticks after which an edge at a pin is certainly in its stream: input filter, DMA and the reads of a look together; at most an
    /// eighth of the timer's period.
    fn settle(&self) -> u32;

    /// The counter, and the overflow flag read after it. Nothing is cleared.
    fn clock(&mut self) -> (u32, bool);

    /// Looks at the hardware and ends a batch.
    fn look(&mut self) -> Look;

    /// The oldest capture of a stream, which stays.
    fn oldest(&mut self, stream: usize) -> Option<Latch>;

    /// Takes a stream's oldest capture out.
    fn take(&mut self, stream: usize) -> Option<Latch>;
}

/// Why captures are missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Loss {
    /// A latch was overwritten before it was fetched.
    OverCapture,
    /// Captures were overwritten before they were drained, or came too late.
    Overrun,
    /// The rebuilt levels are not those of the pins.
    Levels,
}

/// What [`Captures::drain`] gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Event {
    /// Levels changed; the first one only says where they began.
    Change(Sample),
    /// Captures are missing between the last change and the next one.
    Missed(Loss),
}

#[cfg(test)]
pub(crate) mod tests;

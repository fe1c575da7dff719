//! A source in which tests lay captures by hand.

use std::collections::VecDeque;

use crate::capture::{CaptureSource, Change, Channel, Latch, Look};
use crate::edge::Levels;

/// Ticks that hardware takes.
pub const SETTLE: u32 = 20;

/// Three streams of a timer of `BITS` bits.
pub struct Streams<const BITS: u32> {
    /// Time now.
    pub ticks: u64,
    /// Wraps that were told.
    wraps: u64,
    pub look: Look,
    pub streams: [VecDeque<u32>; 3],
}

impl<const BITS: u32> Default for Streams<BITS> {
    fn default() -> Self {
        Self {
            ticks: 0,
            wraps: 0,
            look: Look {
                levels: Some(Levels(0)),
                ..Look::default()
            },
            streams: Default::default(),
        }
    }
}

impl<const BITS: u32> Streams<BITS> {
    pub const fn raw(ticks: u64) -> u32 {
        (ticks & (u64::MAX >> (64 - BITS))) as u32
    }

    pub fn lay(&mut self, channel: Channel, ticks: u64) {
        self.streams[channel as usize].push_back(Self::raw(ticks));
    }
}

impl<const BITS: u32> CaptureSource for Streams<BITS> {
    const STREAMS: usize = 3;

    fn settle(&self) -> u32 {
        SETTLE
    }

    fn clock(&mut self) -> (u32, bool) {
        (Self::raw(self.ticks), self.ticks >> BITS > self.wraps)
    }

    fn look(&mut self) -> Look {
        let (counter, overflowed) = self.clock();
        self.wraps += u64::from(overflowed);
        let look = Look {
            counter,
            overflowed,
            ..self.look
        };
        self.look.over_captured = 0;
        self.look.overrun = 0;
        look
    }

    fn oldest(&mut self, stream: usize) -> Option<Latch> {
        let raw = *self.streams[stream].front()?;
        let channel = [Channel::A, Channel::B, Channel::Z][stream];
        Some(Latch {
            raw,
            change: Change::Of(channel),
        })
    }

    fn take(&mut self, stream: usize) -> Option<Latch> {
        let taken = self.oldest(stream);
        self.streams[stream].pop_front();
        taken
    }
}

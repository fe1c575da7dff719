//! The driver: sets timer and DMA up, and hands their captures on.

use core::marker::PhantomData;

use super::chip::Chip;
use super::filter::Filter;
use super::registers::{Registers, timer};
use crate::capture::{CaptureSource, Change, Channel, Latch, Look};
use crate::edge::Levels;

/// Ticks from a capture to its word in memory, and those of a look's reads, on a busy bus.
const LATENCY: u32 = 64;

/// Ticks within which pins and counter are read, unless an interrupt comes in between.
const TOGETHER: u32 = LATENCY / 2;

/// Why capturing can't start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StartError {
    /// The timer does not keep a period of 32 bits: it has no clock, or is another one.
    Timer,
    /// DMA that ran before does not stop.
    Dma,
}

/// One channel's circular memory.
#[derive(Clone, Copy, Default)]
struct Ring {
    /// The next word to take.
    read: usize,
    /// The word that DMA was to write next at the last look.
    end: usize,
    /// The word before `read`, as it was taken: it changes when DMA comes round.
    last: u32,
}

/// Captures of TIM2 on the chip `C`, in the memory of `R`: a source for [`Captures`](crate::capture::Captures).
pub struct DmaCapture<R, C> {
    registers: R,
    settle: u32,
    rings: [Ring; 3],
    chip: PhantomData<C>,
}

const fn channel(stream: usize) -> Channel {
    match stream {
        0 => Channel::A,
        1 => Channel::B,
        _ => Channel::Z,
    }
}

impl<R: Registers, C: Chip> DmaCapture<R, C> {
    const LAST: usize = {
        assert!(
            R::LATCHES.is_power_of_two() && R::LATCHES >= 8 && R::LATCHES <= 1 << 15,
            "a power of two from 8 to 32,768"
        );
        R::LATCHES - 1
    };

    /// Sets clocks, pins, timer and DMA up, and starts. The timer counts from 0 at its full clock.
    ///
    /// # Errors
    /// [`StartError`]; the timer does not run then.
    pub fn start(mut registers: R, filter: Filter) -> Result<Self, StartError> {
        C::connect(&mut registers);
        registers.write(timer::CR1, 0);
        registers.write(timer::DIER, 0);
        // Inputs are chosen while channels are off.
        registers.write(timer::CCER, 0);
        registers.write(timer::PSC, 0);
        registers.write(timer::ARR, u32::MAX);
        if registers.read(timer::ARR) != u32::MAX {
            return Err(StartError::Timer);
        }
        let input = timer::DIRECT | filter.code() << timer::FILTER_AT;
        registers.write(timer::CCMR1, input | input << timer::SECOND_AT);
        registers.write(timer::CCMR2, input);
        registers.write(timer::EGR, timer::UG);
        let mut rings = [Ring::default(); 3];
        for (stream, ring) in rings.iter_mut().enumerate() {
            ring.last = registers.latched(channel(stream), Self::LAST);
        }
        C::start(&mut registers)?;
        registers.write(timer::DIER, timer::REQUESTS);
        registers.write(timer::CCER, timer::BOTH_EDGES);
        registers.write(timer::SR, 0);
        registers.write(timer::CR1, timer::CEN);
        Ok(Self {
            registers,
            settle: filter.ticks() + LATENCY,
            rings,
            chip: PhantomData,
        })
    }

    /// The registers. Kept from all but tests: whoever has them can do anything.
    #[cfg(test)]
    pub(super) fn registers(&mut self) -> &mut R {
        &mut self.registers
    }
}

impl<R: Registers, C: Chip> CaptureSource for DmaCapture<R, C> {
    const STREAMS: usize = 3;

    #[inline]
    fn settle(&self) -> u32 {
        self.settle
    }

    #[inline]
    fn clock(&mut self) -> (u32, bool) {
        let counter = self.registers.read(timer::CNT);
        let status = self.registers.read(timer::SR);
        (counter, status & timer::UIF != 0)
    }

    #[inline]
    fn look(&mut self) -> Look {
        let before = self.registers.read(timer::CNT);
        let pins = self.registers.read(C::PINS);
        let counter = self.registers.read(timer::CNT);
        let status = self.registers.read(timer::SR);
        let over_captured = (status >> timer::OVER_CAPTURES_AT) & 7;
        let seen = (status & timer::UIF) | over_captured << timer::OVER_CAPTURES_AT;
        if seen != 0 {
            // Flags are cleared by a 0; a 1 leaves them, ones that came meanwhile too.
            self.registers.write(timer::SR, !seen);
        }
        let mut overrun = 0;
        for ((stream, ring), remaining) in self.rings.iter_mut().enumerate().zip(C::REMAINING) {
            let remaining = self.registers.read(remaining) as usize;
            ring.end = R::LATCHES.wrapping_sub(remaining) & Self::LAST;
            let waiting = ring.end.wrapping_sub(ring.read) & Self::LAST;
            let before = ring.read.wrapping_sub(1) & Self::LAST;
            let last = self.registers.latched(channel(stream), before);
            if last != ring.last || waiting > R::LATCHES / 2 {
                overrun |= channel(stream).bit();
                ring.read = ring.end;
                let before = ring.end.wrapping_sub(1) & Self::LAST;
                ring.last = self.registers.latched(channel(stream), before);
            }
        }
        let together = counter.wrapping_sub(before) <= TOGETHER;
        Look {
            counter,
            overflowed: status & timer::UIF != 0,
            levels: together.then_some(Levels((pins & 7) as u8)),
            over_captured: over_captured as u8,
            overrun,
        }
    }

    #[inline(always)]
    fn oldest(&mut self, stream: usize) -> Option<Latch> {
        let ring = self.rings.get(stream)?;
        if ring.read == ring.end {
            return None;
        }
        let channel = channel(stream);
        Some(Latch {
            raw: self.registers.latched(channel, ring.read),
            change: Change::Of(channel),
        })
    }

    #[inline(always)]
    fn take(&mut self, stream: usize) -> Option<Latch> {
        let latch = self.oldest(stream)?;
        let ring = self.rings.get_mut(stream)?;
        ring.last = latch.raw;
        ring.read = ring.read.wrapping_add(1) & Self::LAST;
        Some(latch)
    }
}

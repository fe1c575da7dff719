//! The driver: sets machines and DMA up, and hands their captures on.

use core::marker::PhantomData;

use super::chip::Chip;
use super::program::{self, Course};
use super::registers::{PINS, Registers, dma, pio};
use crate::capture::{CaptureSource, Change, Latch, Look};
use crate::edge::Levels;

/// Ticks from a change at a pin to its word in memory, and those of a look's accesses, on a busy bus: 192 cycles.
const LATENCY: u32 = 32;

/// Ticks within which pins and count are read, unless an interrupt comes in between.
const TOGETHER: u32 = LATENCY / 2;

/// Looks for an answer, which comes within 19 cycles: a machine that does not answer then has stopped.
const PATIENCE: u32 = 32;

/// Words in a queue of machine 1.
const QUEUE: u32 = 4;

/// All levels.
const ALL: u8 = Levels::A | Levels::B | Levels::Z;

/// Pad: bits that go (isolation, pull-down) and come (no output, input, pull-up for open collectors, Schmitt trigger).
const PAD_CLEAR: u32 = 1 << 8 | 1 << 2;
const PAD_SET: u32 = 1 << 7 | 1 << 6 | 1 << 3 | 1 << 1;

/// Why capturing can't start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StartError {
    /// There are no such three pins: the first one is 0 to 27.
    Pins,
    /// The memory does not begin at a multiple of its size.
    Memory,
    /// PIO0, DMA or the pads do not come out of reset.
    Reset,
    /// DMA that ran before does not stop.
    Dma,
}

/// Captures by PIO0 of the chip `C`, in the memory of `R`: a source for [`Captures`](crate::capture::Captures) with
/// [`BITS`](super::BITS) bits.
pub struct PioCapture<R, C> {
    registers: R,
    first_pin: u32,
    /// The next word to take, and the one that DMA was to write next at the last look.
    read: usize,
    end: usize,
    /// The word before `read`, as it was taken: it changes when DMA comes round.
    last: u32,
    /// The count at the last look.
    seen: u32,
    /// Whether words from before a loss may still come.
    unclean: bool,
    chip: PhantomData<C>,
}

impl<R: Registers, C: Chip> PioCapture<R, C> {
    const LAST: usize = {
        assert!(
            R::WORDS.is_power_of_two() && R::WORDS >= 16 && R::WORDS <= 1 << 13,
            "a power of two from 16 to 8,192"
        );
        R::WORDS - 1
    };

    /// Sets pads, machines and DMA up, and starts. A, B and Z are the pins from `first_pin` on, 0 to 27. The count begins at 0. Machines 0 and 1
    /// of PIO0, its first 19 instructions and DMA's channels 0 and 1 are taken; others may be in use already.
    ///
    /// # Errors
    /// [`StartError`]; nothing captures then.
    pub fn start(mut registers: R, first_pin: u32) -> Result<Self, StartError> {
        if first_pin > 27 {
            return Err(StartError::Pins);
        }
        if !registers.memory().is_multiple_of(4 * R::WORDS as u32) {
            return Err(StartError::Memory);
        }
        release::<R, C>(&mut registers)?;
        let others = registers.read(pio::CTRL) & 0xF & !pio::BOTH;
        registers.write(pio::CTRL, others);
        stop_dma::<R, C>(&mut registers)?;
        for pin in first_pin..first_pin + 3 {
            let pad = C::pad(pin);
            let value = registers.read(pad);
            registers.write(pad, (value & !PAD_CLEAR) | PAD_SET);
        }
        for (index, word) in (0..).zip(program::WORDS) {
            registers.write(pio::instruction(index), word.into());
        }
        // Before the set-up, as it clears ISR.
        registers.write(pio::CTRL, others | pio::BOTH << pio::RESTART_AT);
        let pins = first_pin << pio::FIRST_PIN_AT;
        set_up(&mut registers, 0, &program::CAPTURES, pio::LONG_QUEUE, pins);
        set_up(&mut registers, 1, &program::TELLS, 0, 0);
        registers.write(pio::FDEBUG, pio::NO_ROOM);
        let last = registers.word(Self::LAST);
        start_dma::<R, C>(&mut registers);
        // In one write, so that both count alike.
        let both = pio::BOTH | pio::BOTH << pio::CLOCK_RESTART_AT;
        registers.write(pio::CTRL, others | both);
        Ok(Self {
            registers,
            first_pin,
            read: 0,
            end: 0,
            last,
            seen: 0,
            unclean: false,
            chip: PhantomData,
        })
    }

    /// Asks machine 1 for the count; none where it has stopped.
    #[inline]
    fn count(&mut self) -> Option<u32> {
        let registers = &mut self.registers;
        // Answers to questions that were given up.
        for _ in 0..QUEUE {
            if registers.read(pio::FSTAT) & pio::NO_ANSWER != 0 {
                break;
            }
            registers.read(pio::RXF1);
        }
        registers.write(pio::TXF1, 0);
        for _ in 0..PATIENCE {
            if registers.read(pio::FSTAT) & pio::NO_ANSWER == 0 {
                return Some(program::count(registers.read(pio::RXF1)));
            }
        }
        None
    }

    /// Where DMA writes next. The channels take turns, and the one that rests stands at the memory's begin: if the second one is under way,
    /// the first one has ended by now, whatever was read of it.
    #[inline]
    fn written(&mut self) -> usize {
        let begin = self.registers.memory();
        let [first, second] = dma::WRITTEN.map(|written| {
            let bytes = self.registers.read(written).wrapping_sub(begin);
            (bytes >> 2) as usize & Self::LAST
        });
        if second == 0 { first } else { second }
    }

    /// The oldest word.
    #[inline(always)]
    fn word(&mut self) -> Option<u32> {
        (self.read != self.end).then(|| self.registers.word(self.read))
    }

    /// Leaves everything out that is in memory.
    #[cold]
    fn skip(&mut self) {
        self.read = self.end;
        self.last = self.registers.word(self.end.wrapping_sub(1) & Self::LAST);
    }

    /// The registers. Kept from all but tests: whoever has them can do anything.
    #[cfg(test)]
    pub(super) fn registers(&mut self) -> &mut R {
        &mut self.registers
    }
}

/// A capture of a word: the count above, the levels in the lower three bits.
#[inline(always)]
const fn latch(word: u32) -> Latch {
    Latch {
        raw: program::count(word >> 3),
        change: Change::To(Levels(word as u8 & ALL)),
    }
}

/// Takes the blocks out of reset.
fn release<R: Registers, C: Chip>(registers: &mut R) -> Result<(), StartError> {
    let value = registers.read(C::RESETS);
    registers.write(C::RESETS, value & !C::BLOCKS);
    if (0..1000).all(|_| registers.read(C::RESET_DONE) & C::BLOCKS != C::BLOCKS) {
        return Err(StartError::Reset);
    }
    Ok(())
}

/// Stops both channels, which a program before may have left running.
fn stop_dma<R: Registers, C: Chip>(registers: &mut R) -> Result<(), StartError> {
    for channel in 0..2 {
        let [.., control] = dma::channel(channel);
        registers.write(control, 0);
    }
    registers.write(C::ABORT, dma::BOTH);
    // A transfer under way is finished first.
    if (0..1000).all(|_| registers.read(C::ABORT) & dma::BOTH != 0) {
        return Err(StartError::Dma);
    }
    Ok(())
}

/// Two channels that start each other, as a channel's count ends some time. Each goes once round the memory.
fn start_dma<R: Registers, C: Chip>(registers: &mut R) {
    let ring = (4 * R::WORDS).trailing_zeros();
    let memory = registers.memory();
    // The first one is started last.
    for channel in [1, 0] {
        let [from, to, count, start, control] = dma::channel(channel);
        registers.write(from, pio::RXF0.address());
        registers.write(to, memory);
        registers.write(count, R::WORDS as u32);
        let how = if channel == 0 { start } else { control };
        registers.write(how, C::control(dma::REQUEST, 1 - channel, ring));
    }
}

/// Sets a machine up that does not run.
fn set_up<R: Registers>(registers: &mut R, machine: u32, course: &Course, queue: u32, pins: u32) {
    let [clock, control, shift, execute, mapping] = pio::machine(machine);
    registers.write(clock, pio::WHOLE_CLOCK);
    let wrap = course.bottom << pio::BOTTOM_AT | course.top << pio::TOP_AT;
    registers.write(control, pio::NO_QUESTION | wrap);
    // Queues are emptied by joining them and taking them apart.
    registers.write(shift, pio::SHIFT | (queue ^ pio::LONG_QUEUE));
    registers.write(shift, pio::SHIFT | queue);
    registers.write(mapping, pins);
    for instruction in [
        program::ISR_ONES,
        program::X_ONES,
        program::Y_ONES,
        course.entry,
    ] {
        registers.write(execute, instruction);
    }
}

impl<R: Registers, C: Chip> CaptureSource for PioCapture<R, C> {
    const STREAMS: usize = 1;

    #[inline]
    fn settle(&self) -> u32 {
        LATENCY
    }

    #[inline]
    fn clock(&mut self) -> (u32, bool) {
        let counter = self.count().unwrap_or(self.seen);
        (counter, counter < self.seen)
    }

    #[inline]
    fn look(&mut self) -> Look {
        let before = self.count();
        let pins = self.registers.read(PINS) >> self.first_pin;
        let counter = self.count();
        let no_room = self.registers.read(pio::FDEBUG) & pio::NO_ROOM != 0;
        if no_room {
            self.registers.write(pio::FDEBUG, pio::NO_ROOM);
        }
        let waiting = self.registers.read(pio::FSTAT) & pio::NO_CAPTURE == 0;
        self.end = self.written();
        // The queue keeps what was before a loss, and memory gets it later: what comes until the queue has been empty is not whole.
        let lost = no_room || self.unclean;
        self.unclean = no_room || (lost && waiting);
        let filled = self.end.wrapping_sub(self.read) & Self::LAST;
        let before_read = self.read.wrapping_sub(1) & Self::LAST;
        let lapped = self.registers.word(before_read) != self.last || filled > R::WORDS / 2;
        let stopped = before.is_none() || counter.is_none();
        let overrun = lost || lapped || stopped;
        if overrun {
            self.skip();
        }
        let together = before.zip(counter).is_some_and(|(before, counter)| {
            counter.wrapping_sub(before) & program::MASK <= TOGETHER
        });
        let counter = counter.unwrap_or(self.seen);
        let overflowed = counter < self.seen;
        self.seen = counter;
        Look {
            counter,
            overflowed,
            levels: together.then_some(Levels(pins as u8 & ALL)),
            over_captured: 0,
            overrun: if overrun { ALL } else { 0 },
        }
    }

    #[inline(always)]
    fn oldest(&mut self, _stream: usize) -> Option<Latch> {
        self.word().map(latch)
    }

    #[inline(always)]
    fn take(&mut self, _stream: usize) -> Option<Latch> {
        self.last = self.word()?;
        self.read = self.read.wrapping_add(1) & Self::LAST;
        Some(latch(self.last))
    }
}

//! What the driver asks of a board, and the registers that are alike on both chips.

/// A register of PIO0, of DMA, of the pads or of their resets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Register(u32);

impl Register {
    pub(super) const fn at(address: u32) -> Self {
        Self(address)
    }

    /// Its address, a multiple of 4. A read of `RXF1` takes an answer out of its queue, which nobody else waits for; all others may be read
    /// at any time without an effect.
    #[inline]
    #[must_use]
    pub const fn address(self) -> u32 {
        self.0
    }
}

/// Registers, and the memory that DMA writes.
pub trait Registers {
    /// Words of memory: a power of two from 16 to 8,192.
    const WORDS: usize;

    /// Reads a register.
    fn read(&mut self, register: Register) -> u32;

    /// Writes a register; done when this returns.
    fn write(&mut self, register: Register, value: u32);

    /// Word `index` of the memory as DMA left it; 0 from [`Self::WORDS`] on.
    fn word(&mut self, index: usize) -> u32;

    /// Address of the memory as DMA sees it, a multiple of the memory's size in bytes.
    fn memory(&self) -> u32;
}

/// The levels of all pins: `GPIO_IN` of the single-cycle block.
pub(super) const PINS: Register = Register::at(0xD000_0004);

/// PIO0 ("PIO: list of registers" in both data sheets).
pub(super) mod pio {
    use super::Register;

    const BASE: u32 = 0x5020_0000;
    pub const CTRL: Register = Register::at(BASE);
    pub const FSTAT: Register = Register::at(BASE + 0x04);
    pub const FDEBUG: Register = Register::at(BASE + 0x08);
    /// Machine 1's questions and answers.
    pub const TXF1: Register = Register::at(BASE + 0x14);
    pub const RXF1: Register = Register::at(BASE + 0x24);
    /// Machine 0's queue, which DMA reads.
    pub const RXF0: Register = Register::at(BASE + 0x20);

    /// A word of the program.
    pub const fn instruction(index: u32) -> Register {
        Register::at(BASE + 0x48 + 4 * index)
    }

    /// `CLKDIV`, `EXECCTRL`, `SHIFTCTRL`, `INSTR` and `PINCTRL` of a machine.
    pub const fn machine(machine: u32) -> [Register; 5] {
        let base = BASE + 0xC8 + 0x18 * machine;
        [
            Register::at(base),
            Register::at(base + 0x04),
            Register::at(base + 0x08),
            Register::at(base + 0x10),
            Register::at(base + 0x14),
        ]
    }

    /// `CTRL`: both machines run; where the same bits restart them, and their clock dividers.
    pub const BOTH: u32 = 3;
    pub const RESTART_AT: u32 = 4;
    pub const CLOCK_RESTART_AT: u32 = 8;
    /// `FDEBUG`: machine 0 had no room in its queue. Cleared by a 1.
    pub const NO_ROOM: u32 = 1;
    /// `FSTAT`: machine 0's queue, and machine 1's of answers, is empty.
    pub const NO_CAPTURE: u32 = 1 << 8;
    pub const NO_ANSWER: u32 = 2 << 8;
    /// `SHIFTCTRL`: to the left in, to the right out, nothing by itself.
    pub const SHIFT: u32 = 1 << 19;
    /// `SHIFTCTRL`: a queue of eight words out of the machine, none into it.
    pub const LONG_QUEUE: u32 = 1 << 31;
    /// `CLKDIV`: the system clock itself.
    pub const WHOLE_CLOCK: u32 = 1 << 16;
    /// `EXECCTRL`: `STATUS` is all ones while fewer than one question waits; where the loop's ends stand.
    pub const NO_QUESTION: u32 = 1;
    pub const BOTTOM_AT: u32 = 7;
    pub const TOP_AT: u32 = 12;
    /// `PINCTRL`: where the first pin that is read stands.
    pub const FIRST_PIN_AT: u32 = 15;
}

/// Channels 0 and 1 of DMA.
pub(super) mod dma {
    use super::Register;

    const BASE: u32 = 0x5000_0000;

    /// `READ_ADDR`, `WRITE_ADDR`, `TRANS_COUNT`, `CTRL_TRIG` (which starts it) and `AL1_CTRL` (which does not) of a channel.
    pub const fn channel(channel: u32) -> [Register; 5] {
        let base = BASE + 0x40 * channel;
        [
            Register::at(base),
            Register::at(base + 0x04),
            Register::at(base + 0x08),
            Register::at(base + 0x0C),
            Register::at(base + 0x10),
        ]
    }

    /// Both channels' `WRITE_ADDR`.
    pub const WRITTEN: [Register; 2] = [Register::at(BASE + 0x04), Register::at(BASE + 0x44)];
    /// Both channels in `CHAN_ABORT`.
    pub const BOTH: u32 = 3;
    /// Request of machine 0's queue: `DREQ_PIO0_RX0`.
    pub const REQUEST: u32 = 4;

    /// A register at an offset from DMA's first.
    pub const fn at(offset: u32) -> Register {
        Register::at(BASE + offset)
    }
}

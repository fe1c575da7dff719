//! What the driver asks of a board, and the timer's registers.

use crate::capture::Channel;

/// A register of the timer, its DMA, its pins or their clocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Register(u32);

impl Register {
    pub(super) const fn at(address: u32) -> Self {
        Self(address)
    }

    /// Its address, a multiple of 4. Every register that the driver names may be read at any time without an effect.
    #[inline]
    #[must_use]
    pub const fn address(self) -> u32 {
        self.0
    }
}

/// Registers, and the memory that DMA writes.
pub trait Registers {
    /// Words of memory for each channel: a power of two from 8 to 32,768.
    const LATCHES: usize;

    /// Reads a register.
    fn read(&mut self, register: Register) -> u32;

    /// Writes a register; done when this returns.
    fn write(&mut self, register: Register, value: u32);

    /// Word `index` of a channel's memory as DMA left it; 0 from [`Self::LATCHES`] on.
    fn latched(&mut self, channel: Channel, index: usize) -> u32;

    /// Address of a channel's memory as DMA sees it.
    fn memory(&self, channel: Channel) -> u32;
}

/// TIM2 ("TIM2 to TIM5 registers" in RM0090, chapter 18, and in RM0440): the same place and the same bits on both chips.
pub(super) mod timer {
    use super::Register;

    const BASE: u32 = 0x4000_0000;
    pub const CR1: Register = Register::at(BASE);
    pub const DIER: Register = Register::at(BASE + 0x0C);
    pub const SR: Register = Register::at(BASE + 0x10);
    pub const EGR: Register = Register::at(BASE + 0x14);
    pub const CCMR1: Register = Register::at(BASE + 0x18);
    pub const CCMR2: Register = Register::at(BASE + 0x1C);
    pub const CCER: Register = Register::at(BASE + 0x20);
    pub const CNT: Register = Register::at(BASE + 0x24);
    pub const PSC: Register = Register::at(BASE + 0x28);
    pub const ARR: Register = Register::at(BASE + 0x2C);
    /// `CCR1` to `CCR3`.
    pub const LATCHES: [Register; 3] = [
        Register::at(BASE + 0x34),
        Register::at(BASE + 0x38),
        Register::at(BASE + 0x3C),
    ];

    /// `CR1`: the counter runs.
    pub const CEN: u32 = 1;
    /// `EGR`: takes over the prescaler and sets the counter to 0.
    pub const UG: u32 = 1;
    /// `SR`: the counter wrapped.
    pub const UIF: u32 = 1;
    /// `SR`: lowest of the three over-capture flags, `CC1OF` to `CC3OF`.
    pub const OVER_CAPTURES_AT: u32 = 9;
    /// `DIER`: DMA requests of the three captures, `CC1DE` to `CC3DE`.
    pub const REQUESTS: u32 = 7 << 9;
    /// `CCER`: a channel is on, at both edges (`CCxE`, `CCxP`, `CCxNP`), for three channels.
    pub const BOTH_EDGES: u32 = 0xBBB;
    /// `CCMR`: a channel takes its own input, `CCxS` = 1.
    pub const DIRECT: u32 = 1;
    /// `CCMR`: where a channel's filter stands, and where the second channel does.
    pub const FILTER_AT: u32 = 4;
    pub const SECOND_AT: u32 = 8;
}

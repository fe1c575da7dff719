//! The board: flash that is kept for the table, the timer's registers, and the interrupts.

use cortex_m::peripheral::NVIC;
use quadcal::capture::Channel;
use quadcal::slot::Slot;
use quadcal::table::ErrorTable;
use stm32f4xx_hal::pac::{Interrupt, TIM2};
use stm32f4xx_hal::rcc::{Enable, Rcc};

/// Flags of TIM2: wrapped; captured again, on any channel, before the latch was read.
const WRAPPED: u32 = 1;
const MISSED: u32 = 7 << 9;

/// TIM2, which counts 32 bits freely.
pub struct Timer(TIM2);

impl Timer {
    /// Captures both edges of three channels, filtered over 8 ticks, 0.1 us; interrupts at each, and at a wrap.
    pub fn start(timer: TIM2, clocks: &mut Rcc) -> Self {
        TIM2::enable(clocks);
        // SAFETY: values of the reference manual, "TIM2 to TIM5 registers".
        unsafe {
            timer.ccmr1_input().write(|w| w.bits(0x3131));
            timer.ccmr2_input().write(|w| w.bits(0x31));
            timer.ccer().write(|w| w.bits(0xBBB));
            timer.arr().write(|w| w.bits(u32::MAX));
            timer.dier().write(|w| w.bits(0b1111));
        }
        timer.cr1().write(|w| w.cen().set_bit());
        Self(timer)
    }

    /// A channel's capture, if there is one; reading it clears its flag.
    pub fn latch(&self, channel: Channel) -> Option<(Channel, u32)> {
        let status = self.0.sr().read();
        let (there, latch) = match channel {
            Channel::A => (status.cc1if().bit(), self.0.ccr1()),
            Channel::B => (status.cc2if().bit(), self.0.ccr2()),
            Channel::Z => (status.cc3if().bit(), self.0.ccr3()),
        };
        there.then(|| (channel, latch.read().bits()))
    }

    pub fn counter(&self) -> u32 {
        self.0.cnt().read().bits()
    }

    pub fn wrapped(&self) -> bool {
        self.0.sr().read().bits() & WRAPPED != 0
    }

    /// Whether the timer wrapped, and whether a capture was missed, since the last call.
    pub fn flags(&self) -> (bool, bool) {
        let status = self.0.sr().read().bits() & (WRAPPED | MISSED);
        // SAFETY: a 0 clears a flag, a 1 leaves it.
        self.0.sr().write(|w| unsafe { w.bits(!status) });
        (status & WRAPPED != 0, status & MISSED != 0)
    }
}

/// Lets both interrupts come. They have one priority: none preempts the other.
pub fn unmask() {
    for interrupt in [Interrupt::TIM2, Interrupt::TIM7] {
        // SAFETY: critical sections mask all interrupts, whatever is unmasked here.
        unsafe { NVIC::unmask(interrupt) };
    }
}

unsafe extern "C" {
    static _table_start: u8;
    static _table_end: u8;
}

/// The table in the flash that `memory.x` keeps for it; none, and the angles are the grid's, where nothing was written.
pub fn table(clock_hz: u64) -> Option<ErrorTable<'static, [u8; 2]>> {
    let (start, end) = (&raw const _table_start, &raw const _table_end);
    // SAFETY: flash that the linker gives to nothing else, and this program never writes.
    let bytes = unsafe { core::slice::from_raw_parts(start, end.addr() - start.addr()) };
    Slot::parse(bytes).ok()?.table_at(clock_hz).ok()
}

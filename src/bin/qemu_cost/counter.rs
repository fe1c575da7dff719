//! Instructions executed, from SysTick. QEMU models no cycle counter; with `-icount shift=3` every instruction takes 8 ns
//! of virtual time, and SysTick runs at 168 MHz of it.

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::interrupt;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m::peripheral::{SCB, SYST};
use cortex_m_rt::exception;

/// SysTick counts down from here to 0: 24 bits.
const RELOAD: u32 = 0x00ff_ffff;

/// Times the 24-bit count has gone round.
static WRAPS: AtomicU32 = AtomicU32::new(0);

/// Running count of instructions. Only one can exist, as it owns the timer.
pub struct InstructionCounter {
    _timer: SYST,
}

impl InstructionCounter {
    /// Starts the timer.
    pub fn start(mut timer: SYST) -> Self {
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(RELOAD);
        timer.clear_current();
        timer.enable_interrupt();
        timer.enable_counter();
        Self { _timer: timer }
    }

    /// Instructions executed since an arbitrary point, right to about two; reading costs some seventy itself.
    pub fn now(&self) -> u64 {
        let (wraps, count) = interrupt::free(|_| {
            let count = SYST::get_current();
            let wraps = WRAPS.load(Ordering::Relaxed);
            if SCB::is_pendst_pending() {
                // Wrapped with its handler still to run: read again, so that the count is surely the one after the wrap.
                (wraps.wrapping_add(1), SYST::get_current())
            } else {
                (wraps, count)
            }
        });
        let ticks = (u64::from(wraps) << 24) + u64::from(RELOAD - count);
        // 1e9 / 168e6 ns a tick, 8 ns an instruction.
        ticks * 125 / 168
    }
}

#[exception]
fn SysTick() {
    WRAPS.fetch_add(1, Ordering::Relaxed);
}

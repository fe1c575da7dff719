//! What the firmware supplies besides port, flash and edges: time to work, nonces, a key, and what is allowed.

use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use embedded_io::ReadReady;
use quadcal::access::{Key, Nonces};
use quadcal::recalibrate::{Interlock, Obstacle};
use quadcal::wire::{NONCE_BYTES, Nonce};

use crate::qemu::semihost::{File, Mode};

/// The key of every such device.
pub const KEY: Key = [0; 32];

/// SysTick's clocks from one look at the edges to the next: 1 ms at QEMU's 168 MHz.
const RELOAD: u32 = 168_000 - 1;

/// A millisecond has passed.
static TICKED: AtomicBool = AtomicBool::new(false);

/// Wakes the processor every millisecond.
pub struct Wake {
    _timer: SYST,
}

impl Wake {
    /// Starts the timer.
    pub fn start(mut timer: SYST) -> Self {
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(RELOAD);
        timer.clear_current();
        timer.enable_interrupt();
        timer.enable_counter();
        Self { _timer: timer }
    }

    /// SysTick's interrupt.
    pub fn tick() {
        TICKED.store(true, Ordering::Relaxed);
    }

    /// Whether a millisecond has passed since this was asked last.
    pub fn ticked(&mut self) -> bool {
        TICKED.swap(false, Ordering::Relaxed)
    }

    /// Sleeps until the next millisecond or byte, unless one is there.
    pub fn wait(&mut self, port: &mut impl ReadReady) {
        // With interrupts masked, one that comes after the look still wakes.
        cortex_m::interrupt::free(|_| {
            let idle = !TICKED.load(Ordering::Relaxed) && !port.read_ready().unwrap_or(true);
            if idle {
                cortex_m::asm::wfi();
            }
        });
    }
}

/// Nonces from the host's random numbers.
pub struct HostNonces;

impl Nonces for HostNonces {
    fn nonce(&mut self) -> Option<Nonce> {
        let mut nonce = [0; NONCE_BYTES];
        let mut file = File::open("/dev/urandom", Mode::Read).ok()?;
        let read = file.read(&mut nonce);
        file.close().ok()?;
        (read == Ok(NONCE_BYTES)).then_some(nonce)
    }
}

/// Allows everything.
pub struct Allowed;

impl Interlock for Allowed {
    fn may_calibrate(&self) -> Result<(), Obstacle> {
        Ok(())
    }

    fn may_commit(&self) -> Result<(), Obstacle> {
        Ok(())
    }
}

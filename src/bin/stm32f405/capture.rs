//! Registers of TIM2, its DMA and its pins on a real STM32F405, and the memory that DMA writes.

use core::ptr;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use quadcal::capture::Channel;
use quadcal::stm32_capture::{Register, Registers};

/// Edges of a channel that are kept: 64 may come between two drains.
const LATCHES: usize = 128;

/// A word of DMA's: in main RAM, where memory/stm32f405.x puts every static, so that DMA1 reaches it.
static MEMORY: [[AtomicU32; LATCHES]; 3] = [const { [const { AtomicU32::new(0) }; LATCHES] }; 3];

/// The registers and the memory; there is one.
pub struct CaptureRegisters {
    _one: (),
}

impl CaptureRegisters {
    /// The registers, at the first call; later there are none left.
    pub fn take() -> Option<Self> {
        static TAKEN: AtomicBool = AtomicBool::new(false);
        (!TAKEN.swap(true, Ordering::Relaxed)).then_some(Self { _one: () })
    }
}

const fn memory(channel: Channel) -> &'static [AtomicU32; LATCHES] {
    let [a, b, z] = &MEMORY;
    match channel {
        Channel::A => a,
        Channel::B => b,
        Channel::Z => z,
    }
}

impl Registers for CaptureRegisters {
    const LATCHES: usize = LATCHES;

    #[inline]
    fn read(&mut self, register: Register) -> u32 {
        let address: *const u32 = ptr::without_provenance(register.address() as usize);
        // SAFETY: registers are made by the driver alone, each of them 4-byte aligned and readable without an effect.
        unsafe { address.read_volatile() }
    }

    #[inline]
    fn write(&mut self, register: Register, value: u32) {
        let address: *mut u32 = ptr::without_provenance_mut(register.address() as usize);
        // SAFETY: as above. Only the one value of this type writes them. What the driver sends there reaches memory through DMA alone:
        // `LATCHES` words from what `memory` says on, which are atomics that outlive everything.
        unsafe { address.write_volatile(value) }
    }

    #[inline]
    fn latched(&mut self, channel: Channel, index: usize) -> u32 {
        memory(channel).get(index).map_or(0, |word| {
            // SAFETY: a static's word, aligned. Volatile, as DMA writes it behind the compiler's back.
            unsafe { word.as_ptr().read_volatile() }
        })
    }

    fn memory(&self, channel: Channel) -> u32 {
        memory(channel).as_ptr() as usize as u32
    }
}

//! The board: flash that is kept for the table, registers by address, and the memory that DMA writes.

use core::ptr;
use core::sync::atomic::AtomicU32;

use quadcal::capture::Channel;
use quadcal::slot::Slot;
use quadcal::stm32_capture::{Register, Registers};
use quadcal::table::ErrorTable;
use stm32g4::stm32g431::{DMA1, DMAMUX, GPIOA, TIM2};

/// Edges of a channel that DMA keeps: half as many may come between two drains.
const LATCHES: usize = 128;

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

/// What DMA writes, a channel after the other.
static MEMORY: [[AtomicU32; LATCHES]; 3] = [const { [const { AtomicU32::new(0) }; LATCHES] }; 3];

/// Registers by address. There is one, as it takes the peripherals.
pub struct CaptureRegisters {
    _taken: (TIM2, DMA1, DMAMUX, GPIOA),
}

impl CaptureRegisters {
    pub fn new(timer: TIM2, dma: DMA1, requests: DMAMUX, pins: GPIOA) -> Self {
        Self {
            _taken: (timer, dma, requests, pins),
        }
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

    fn read(&mut self, register: Register) -> u32 {
        let address: *const u32 = ptr::without_provenance(register.address() as usize);
        // SAFETY: registers are made by the driver alone, of the peripherals that were taken and of RCC's enable bits.
        unsafe { address.read_volatile() }
    }

    fn write(&mut self, register: Register, value: u32) {
        let address: *mut u32 = ptr::without_provenance_mut(register.address() as usize);
        // SAFETY: as above; what the driver sends there reaches `MEMORY` alone, which outlives everything.
        unsafe { address.write_volatile(value) }
    }

    fn latched(&mut self, channel: Channel, index: usize) -> u32 {
        // SAFETY: a static's word, aligned. Volatile, as DMA writes it behind the compiler's back.
        memory(channel)
            .get(index)
            .map_or(0, |word| unsafe { word.as_ptr().read_volatile() })
    }

    fn memory(&self, channel: Channel) -> u32 {
        memory(channel).as_ptr().addr() as u32
    }
}

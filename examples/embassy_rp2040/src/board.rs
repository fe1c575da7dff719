//! The board: flash that is kept for the table, registers by address, and the memory that DMA writes.

use core::ptr;
use core::sync::atomic::AtomicU32;

use embassy_rp::Peri;
use embassy_rp::peripherals::{DMA_CH0, DMA_CH1, PIN_2, PIN_3, PIN_4, PIO0};
use quadcal::pio_capture::{Register, Registers};
use quadcal::slot::Slot;
use quadcal::table::ErrorTable;

/// Words that DMA keeps: half as many changes may come between two drains.
const WORDS: usize = 256;

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

/// What DMA writes: at a multiple of its size.
#[repr(align(1024))]
struct Memory([AtomicU32; WORDS]);

static MEMORY: Memory = Memory([const { AtomicU32::new(0) }; WORDS]);

/// Registers by address. There is one, as it takes the peripherals.
pub struct PioRegisters {
    _taken: (
        Peri<'static, PIO0>,
        Peri<'static, DMA_CH0>,
        Peri<'static, DMA_CH1>,
    ),
}

impl PioRegisters {
    pub fn new(
        pio: Peri<'static, PIO0>,
        first: Peri<'static, DMA_CH0>,
        second: Peri<'static, DMA_CH1>,
        _pins: (
            Peri<'static, PIN_2>,
            Peri<'static, PIN_3>,
            Peri<'static, PIN_4>,
        ),
    ) -> Self {
        Self {
            _taken: (pio, first, second),
        }
    }
}

impl Registers for PioRegisters {
    const WORDS: usize = WORDS;

    fn read(&mut self, register: Register) -> u32 {
        let address: *const u32 = ptr::without_provenance(register.address() as usize);
        // SAFETY: registers are made by the driver alone, of the peripherals that were taken.
        unsafe { address.read_volatile() }
    }

    fn write(&mut self, register: Register, value: u32) {
        let address: *mut u32 = ptr::without_provenance_mut(register.address() as usize);
        // SAFETY: as above; what the driver sends there reaches `MEMORY` alone, which outlives everything.
        unsafe { address.write_volatile(value) }
    }

    fn word(&mut self, index: usize) -> u32 {
        // SAFETY: a static's word, aligned. Volatile, as DMA writes it behind the compiler's back.
        MEMORY
            .0
            .get(index)
            .map_or(0, |word| unsafe { word.as_ptr().read_volatile() })
    }

    fn memory(&self) -> u32 {
        MEMORY.0.as_ptr().addr() as u32
    }
}

//! The flash interface of a real STM32F405: registers, mapped flash, and the room that the linker keeps free.

use core::ops::Range;
use core::ptr::{self, addr_of};
use core::sync::atomic::{AtomicBool, Ordering};

use quadcal::stm32f405::{CAPACITY, Interface, Register, Unit};

/// Where the flash is mapped (RM0090, "Flash module organization").
const FLASH: usize = 0x0800_0000;

/// Base address of the flash interface's registers (RM0090, memory map).
const REGISTERS: usize = 0x4002_3C00;

unsafe extern "C" {
    static _tables_start: u32;
    static _tables_end: u32;
}

/// Offsets that memory.x keeps free for tables.
pub fn room() -> Range<u32> {
    // The symbols' addresses alone carry meaning; nothing is read there.
    let offset = |address: usize| (address - FLASH) as u32;
    offset(addr_of!(_tables_start) as usize)..offset(addr_of!(_tables_end) as usize)
}

/// The chip's flash interface; there is one.
pub struct FlashInterface {
    _one: (),
}

impl FlashInterface {
    /// The interface, at the first call; later there is none left.
    pub fn take() -> Option<Self> {
        static TAKEN: AtomicBool = AtomicBool::new(false);
        (!TAKEN.swap(true, Ordering::Relaxed)).then_some(Self { _one: () })
    }
}

fn address(register: Register) -> *mut u32 {
    ptr::without_provenance_mut(REGISTERS + register.offset())
}

impl Interface for FlashInterface {
    fn read(&mut self, register: Register) -> u32 {
        // SAFETY: a register of the flash interface, 4-byte aligned, which may be read at any time.
        unsafe { address(register).read_volatile() }
    }

    fn write(&mut self, register: Register, value: u32) {
        // SAFETY: a register of the flash interface. Only the one value of this type writes it, and `&mut self` keeps its writes
        // apart. The driver sends no command but to erase a sector of the room or to program there: no Rust object lies in it.
        unsafe { address(register).write_volatile(value) };
        // The write is at the register before the next access to flash.
        cortex_m::asm::dsb();
    }

    fn program(&mut self, offset: u32, unit: Unit) {
        if !room().contains(&offset) {
            return;
        }
        let to: *mut u8 = ptr::without_provenance_mut(FLASH + offset as usize);
        // SAFETY: the address lies in the room, where the linker puts nothing, and the driver hands over units at multiples of
        // their size. The room's size is a multiple of four, so a unit that begins there ends there.
        unsafe {
            match unit {
                Unit::Byte(value) => to.write_volatile(value),
                Unit::Half(value) => to.cast::<u16>().write_volatile(value),
                Unit::Word(value) => to.cast::<u32>().write_volatile(value),
            }
        }
        cortex_m::asm::dsb();
    }

    fn load(&mut self, offset: u32, bytes: &mut [u8]) {
        for (at, byte) in (offset..CAPACITY).zip(bytes) {
            let from: *const u8 = ptr::without_provenance(FLASH + at as usize);
            // SAFETY: mapped flash, below its capacity. Volatile, as the driver changes it behind the compiler's back.
            *byte = unsafe { from.read_volatile() };
        }
    }
}

//! The flash interface of a real STM32F405: registers, mapped flash, the slots in it, and the room that the linker keeps free.

use core::ops::Range;
use core::ptr::{self, addr_of};
use core::slice;
use core::sync::atomic::{AtomicBool, Ordering};

use quadcal::device::MappedFlash;
use quadcal::stm32f405::{CAPACITY, Interface, Register, Unit};
use quadcal::store::Layout;

/// Where the flash is mapped (RM0090, "Flash module organization").
const FLASH: usize = 0x0800_0000;

/// Base address of the flash interface's registers (RM0090, memory map).
const REGISTERS: usize = 0x4002_3C00;

unsafe extern "C" {
    static _tables_start: u32;
    static _tables_end: u32;
}

/// Offsets that memory/stm32f405.x keeps free for tables.
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

/// The mapped bytes of tables, slot by slot.
pub struct MappedSlots {
    layout: Layout,
}

impl MappedSlots {
    /// Slots at the places of `layout`.
    ///
    /// # Safety
    /// What [`MappedFlash::bytes`] hands out must be given up before its place is erased or its slot written. A store of the same
    /// `layout` writes and erases the place alone whose table does not count, but for its `erase`; so it is enough to use what was
    /// handed out for the table that counts, and to give it up once another one counts and before all are erased. A workbench that
    /// a device drives does that.
    pub const unsafe fn new(layout: Layout) -> Self {
        Self { layout }
    }
}

impl MappedFlash<'static> for MappedSlots {
    fn bytes(&self, offset: u32) -> Option<&'static [u8]> {
        let slot = self.layout.slot_room(offset)?;
        let (tables, length) = (room(), slot.len());
        if slot.start < tables.start || slot.end > tables.end {
            return None;
        }
        let first: *const u8 = ptr::without_provenance(FLASH + slot.start as usize);
        // SAFETY: mapped flash in the room that the linker keeps free, so no Rust object lies there and it stays mapped. Nothing writes
        // to it while the slice is used: marks lie outside it, the slot itself is written before it counts, and whoever made this
        // value has promised to give the slice up before that happens to the slot again.
        Some(unsafe { slice::from_raw_parts(first, length) })
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

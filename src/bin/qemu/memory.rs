//! How much RAM the image takes: statics from the linker's symbols, stack from the paint that start-up code laid down.

use core::ptr::addr_of;

use cortex_m_rt::STACK_PAINT_VALUE;

unsafe extern "C" {
    static __sdata: u32;
    static __sheap: u32;
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Bytes of `.data`, `.bss` and `.uninit`.
pub fn static_bytes() -> usize {
    // The symbols' addresses alone carry meaning; nothing is read there.
    addr_of!(__sheap) as usize - addr_of!(__sdata) as usize
}

/// Bytes of stack used at the deepest point so far.
pub fn stack_high_water() -> usize {
    let top = addr_of!(_stack_start) as usize;
    let mut at = addr_of!(_stack_end);
    // SAFETY: the layouts in memory/ give the stack the whole region from `_stack_end` up to `_stack_start`, both 4-byte aligned, and
    // the loop stays inside it. Volatile, as the words below the stack pointer belong to no Rust object.
    while (at as usize) < top && unsafe { at.read_volatile() } == STACK_PAINT_VALUE {
        at = at.wrapping_add(1);
    }
    top - at as usize
}

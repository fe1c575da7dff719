//! Replays an event file in QEMU for an encoder of 360 lines: 1440 edges a turn.
#![no_std]
#![no_main]

#[path = "../qemu/memory.rs"]
mod memory;
#[path = "../qemu/mod.rs"]
mod qemu;
#[path = "../qemu/replay.rs"]
mod replay;

use cortex_m_rt::entry;

use replay::Memory;

#[entry]
fn main() -> ! {
    // The entry attribute hands this out as a unique reference: safe, and off the stack.
    static mut MEMORY: Memory<360> = Memory::new();
    qemu::finish(replay::run(MEMORY))
}

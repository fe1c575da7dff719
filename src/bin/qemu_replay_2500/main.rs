//! Replays an event file in QEMU for an encoder of 2500 lines: 10,000 edges a turn, the largest table of the design.
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
    static mut MEMORY: Memory<2500> = Memory::new();
    qemu::finish(replay::run(MEMORY))
}

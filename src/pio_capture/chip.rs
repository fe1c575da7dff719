//! What differs from chip to chip: resets, pads, and DMA's control words.

use super::registers::{Register, dma};

/// Where a chip has what the driver needs.
pub trait Chip {
    /// `RESET` of the resets.
    const RESETS: Register;

    /// `RESET_DONE` of the resets.
    const RESET_DONE: Register;

    /// Bits of DMA, the pads and PIO0 there.
    const BLOCKS: u32;

    /// `CHAN_ABORT` of DMA.
    const ABORT: Register;

    /// The pad of a pin, from 0.
    fn pad(pin: u32) -> Register;

    /// A DMA channel's control word: on, before other channels, words, to a circular memory of 2^`ring` bytes, at a request, then the
    /// channel `next`, no interrupt.
    fn control(request: u32, next: u32, ring: u32) -> u32;
}

/// RP2040; its system clock is 125 MHz as a rule.
#[derive(Clone, Copy, Debug)]
pub struct Rp2040;

impl Chip for Rp2040 {
    const RESETS: Register = Register::at(0x4000_C000);
    const RESET_DONE: Register = Register::at(0x4000_C008);
    const BLOCKS: u32 = 1 << 2 | 1 << 8 | 1 << 10;
    const ABORT: Register = dma::at(0x444);

    fn pad(pin: u32) -> Register {
        Register::at(0x4001_C004 + 4 * pin)
    }

    fn control(request: u32, next: u32, ring: u32) -> u32 {
        1 << 21 | request << 15 | next << 11 | 1 << 10 | ring << 6 | 1 << 5 | 2 << 2 | 1 << 1 | 1
    }
}

/// RP2350, either kind of core; its system clock is 150 MHz as a rule.
#[derive(Clone, Copy, Debug)]
pub struct Rp2350;

impl Chip for Rp2350 {
    const RESETS: Register = Register::at(0x4002_0000);
    const RESET_DONE: Register = Register::at(0x4002_0008);
    const BLOCKS: u32 = 1 << 2 | 1 << 9 | 1 << 11;
    const ABORT: Register = dma::at(0x464);

    fn pad(pin: u32) -> Register {
        Register::at(0x4003_8004 + 4 * pin)
    }

    fn control(request: u32, next: u32, ring: u32) -> u32 {
        1 << 23 | request << 17 | next << 13 | 1 << 12 | ring << 8 | 1 << 6 | 2 << 2 | 1 << 1 | 1
    }
}

//! Captures of A, B and Z by a 32-bit timer and DMA of an STM32, for [`crate::capture`].
//!
//! TIM2 counts freely and latches its counter at both edges of CH1 (A, pin PA0), CH2 (B, PA1) and CH3 (Z, PA2). DMA1 copies each channel's
//! latches into a circular memory of its own. Nothing interrupts the processor; [`DmaCapture`] drains the memories by position.
//!
//! | [`Chip`] | DMA of A, B, Z | manual |
//! |---|---|---|
//! | [`F405`] | DMA1 streams 5, 6 and 1, channel 3 | RM0090: 7 (RCC), 8 (GPIO), 10 (DMA), 18 (TIM2 to TIM5) |
//! | [`G4`] | DMA1 channels 1, 2 and 3, DMAMUX requests 56, 57 and 58 | RM0440: RCC, GPIO, DMA, DMAMUX, TIM2/TIM3/TIM4/TIM5 |
//!
//! The driver works over [`Registers`], the few accesses that a board makes. A model of timer, filter and DMA runs the same driver in
//! tests; what has been tried where stands in the repository's `docs/firmware.md`, "Capture on a chip".
//!
//! # Limits
//! - Drain before half of a channel's memory is filled ([`Registers::LATCHES`] / 2 edges of one channel), or it counts as overrun.
//! - Two edges of one channel must be further apart than DMA takes, about 0.5 us while other masters use the bus. An input filter as long
//!   swallows shorter pulses; else they are over-captures.
//! - The memories must lie where DMA1 reaches: not in the F405's core-coupled memory. A stream that stopped on a bus error shows as
//!   over-captures at every drain.

mod chip;
mod driver;
mod filter;
mod registers;

#[cfg(test)]
mod tests;

pub use chip::{Chip, F405, G4};
pub use driver::{DmaCapture, StartError};
pub use filter::Filter;
pub use registers::{Register, Registers};

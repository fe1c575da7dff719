//! Captures of A, B and Z by the programmable input and output (PIO) of an RP2040 or RP2350, for [`crate::capture`].
//!
//! Two state machines of PIO0 run the [`program`] in step. Machine 0 counts, looks at three pins in a row each tick, and queues count and
//! levels at every change; DMA channels 0 and 1, in turn, copy the queue into a circular memory. Machine 1 counts the same ticks and says
//! the count when it is asked. Nothing interrupts the processor; [`PioCapture`] drains the memory by position.
//!
//! A tick is [`CYCLES`] cycles of the system clock, 48 ns at 125 MHz. Counts have [`BITS`] bits, so they wrap after 25 s there.
//!
//! | [`Chip`] | chapters of the data sheet |
//! |---|---|
//! | [`Rp2040`] | RESETS, DMA, SIO, GPIO (pads), PIO |
//! | [`Rp2350`] | the same names; addresses and bits of pads, resets and DMA differ |
//!
//! The driver works over [`Registers`], the few accesses that a board makes. A model of machines, queues and DMA, which executes the
//! program's words cycle by cycle, runs the same driver in tests; what has been tried where stands in the repository's
//! `docs/firmware.md`, "Capture on a chip".
//!
//! # Limits
//! - Drain before half of the memory is filled ([`Registers::WORDS`] / 2 changes of all channels), or it counts as overrun; and at least
//!   every half period of the count, 12 s at 125 MHz.
//! - After a change one tick is not looked at: a change in it is seen a tick late. A and B that change within it come as one change of both,
//!   which is a fault of the decoder.
//! - There is no input filter. A pulse shorter than a tick may be seen or not.

mod chip;
mod driver;
pub mod program;
mod registers;

#[cfg(test)]
mod tests;

pub use chip::{Chip, Rp2040, Rp2350};
pub use driver::{PioCapture, StartError};
pub use program::{BITS, CYCLES};
pub use registers::{Register, Registers};

//! quadcal: an incremental encoder that learns its own errors on board.
//!
//! Edges come in at one end, corrected angles leave at the other: `units -> edge -> timebase -> capture -> decoder -> interval ->
//! savgol -> estimate -> table`.
//!
//! # Cost of an edge
//! The repository's `docs/cost.md` has the instructions of every stage on a Cortex-M4, counted in QEMU by `cargo qemu --bin edge_cost`
//! and `cargo qemu --bin edge_cost_field`. No stage on the edge path divides, uses floating point or can panic.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(feature = "device")]
pub mod access;
pub mod capture;
pub mod corrector;
pub mod counter;
pub mod decoder;
#[cfg(feature = "device")]
pub mod device;
pub mod edge;
pub mod encoder;
pub mod estimate;
pub mod fingerprint;
pub mod hall;
pub mod interval;
pub mod log2;
mod motion;
#[cfg(feature = "embedded-hal")]
pub mod pins;
#[cfg(any(test, feature = "pio_capture"))]
pub mod pio_capture;
#[cfg(feature = "device")]
pub mod recalibrate;
pub mod recip;
pub mod replay;
pub mod savgol;
pub mod shape;
pub mod slot;
pub mod step;
#[cfg(any(test, feature = "stm32_capture"))]
pub mod stm32_capture;
#[cfg(any(test, feature = "stm32f405"))]
pub mod stm32f405;
pub mod store;
#[cfg(feature = "summary")]
pub mod summary;
pub mod table;
pub mod timebase;
pub mod trig;
pub mod units;
pub mod wheel;
mod wide;
#[cfg(feature = "device")]
pub mod wire;

#[cfg(test)]
extern crate std;

/// The example of the README, compiled with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;

/// The example of the firmware page, compiled with the tests.
#[cfg(doctest)]
#[doc = include_str!("../docs/firmware.md")]
pub struct FirmwarePage;

//! quadcal: an incremental encoder that learns its own errors on board.
//!
//! Edges come in at one end, corrected angles leave at the other: `units -> edge -> timebase -> decoder -> interval ->
//! savgol -> estimate -> table`.
//!
//! # Cost of an edge
//! Instructions, the mean over three turns of an encoder of 2500 lines with its index, edges up to 12 % of a step out of
//! place. Counted by `cargo qemu --bin edge_cost` on a Cortex-M4F in QEMU (netduinoplus2, `-icount shift=3`), profile
//! `firmware` (opt-level 3, LTO), rustc 1.96. Each stage reads its input from memory; a loop without work is subtracted,
//! three instructions of loop and black box are not.
//!
//! | stage | instructions |
//! |---|---|
//! | [`decoder::QuadratureDecoder::push`], outcome written to memory | 48 |
//! | the same where every tenth edge is a reversal without slowing down | 193 |
//! | [`corrector::Corrector::push`]: table, angle, way and time since the edge before | 50 |
//! | the same where the caller uses the delays too | 57 |
//! | decoder and corrector in a row | 98 |
//! | [`interval::Interval::push`] | 39 |
//! | [`interval::Interval::speed_at`], for the control loop | 96 |
//! | [`estimate::Estimator::push`], one turn coming in and one being folded | 125 |
//! | [`fingerprint::Trail::push`], its call included | 25 |
//!
//! On the edge path of a drive that can be calibrated in the field (feature `device`), counted by `cargo qemu --bin edge_cost_field`:
//!
//! | `device::Workbench::push` | instructions |
//! |---|---|
//! | with nothing to do but to correct: the corrector, whole parts of a turn for the pace, and what is to be done | 79 |
//! | while it learns: the estimator as well, behind a call | 223 |
//! | while it proves what it learned, or compares what was handed over: both tables' way over the turn | 507 |
//!
//! These paths divide nothing, use no floating point and hold no panic. Anything but one more edge of settled motion, Z low,
//! goes out of line: at most a few edges a turn, sixteen after a start or a reversal, and every edge of three Hall sensors in
//! the corrector.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(feature = "device")]
pub mod access;
pub mod corrector;
pub mod counter;
pub mod decoder;
#[cfg(feature = "device")]
pub mod device;
pub mod edge;
pub mod estimate;
pub mod fingerprint;
pub mod hall;
pub mod interval;
pub mod log2;
mod motion;
#[cfg(feature = "embedded-hal")]
pub mod pins;
#[cfg(feature = "device")]
pub mod recalibrate;
pub mod recip;
pub mod replay;
pub mod savgol;
pub mod shape;
pub mod slot;
pub mod step;
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
#[cfg(feature = "device")]
pub mod wire;

#[cfg(test)]
extern crate std;

/// The README's example is compiled with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;

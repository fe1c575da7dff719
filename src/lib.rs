//! quadcal: an incremental encoder that learns its own errors on board.
//!
//! Edges come in at one end, corrected angles leave at the other: `units -> edge -> timebase -> decoder -> interval ->
//! savgol -> estimate -> table`.
#![no_std]
#![forbid(unsafe_code)]

pub mod corrector;
pub mod counter;
pub mod decoder;
pub mod edge;
pub mod estimate;
pub mod hall;
pub mod interval;
pub mod log2;
mod motion;
pub mod recip;
pub mod replay;
pub mod savgol;
pub mod shape;
pub mod slot;
pub mod step;
pub mod table;
pub mod timebase;
pub mod trig;
pub mod units;
pub mod wheel;

#[cfg(test)]
extern crate std;

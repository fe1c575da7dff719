//! quadcal: an incremental encoder that learns its own errors on board.
//!
//! Edges come in at one end, corrected angles leave at the other: `units -> edge -> timebase -> decoder -> interval ->
//! savgol -> estimate -> table`.
#![no_std]
#![forbid(unsafe_code)]

pub mod edge;
pub mod estimate;
pub mod log2;
pub mod replay;
pub mod shape;
pub mod slot;
pub mod table;
pub mod trig;
pub mod units;

//! From results to report pages, one file a report.

pub mod calibrate;
pub mod demo;
pub mod diagnose;
pub mod expected;
mod figures;
pub mod separation;
pub mod simulate;
mod turns;
pub mod verify;
pub mod words;

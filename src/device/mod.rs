//! A drive's calibration service.

mod proof;
pub use proof::{Corrected, Proof};

//! Library behind the `quadcal` command: recordings, the simulator, calibration and reports.
#![forbid(unsafe_code)]

pub mod recording;
pub mod sim;
pub mod twin;

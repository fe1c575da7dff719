//! Library behind the `quadcal` command: recordings, the simulator, calibration and reports.
#![forbid(unsafe_code)]

pub mod buffers;
pub mod calibrate;
pub mod cli;
pub mod delays;
pub mod demo;
pub mod device;
pub mod diagnose;
pub mod effect;
pub mod findings;
pub mod free_run;
pub mod locate;
pub mod mechanism;
pub mod pattern;
pub mod pretend;
pub mod recording;
pub mod report;
pub mod reports;
pub mod sensor;
pub mod showcase;
pub mod sim;
pub mod starting_twin;
pub mod survey;
pub mod table_file;
pub mod time_step;
pub mod twin;
pub mod verify;

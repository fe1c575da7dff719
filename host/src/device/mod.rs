//! A device's calibration service, asked over its port: [`quadcal::wire`] from the host's side.
//!
//! [`Address`] opens a [`Port`]; [`Client`] asks and commands over it. A request that only reads is asked again when no reply comes; one that
//! changes something is not, as it may have been followed although its reply was lost. Noise on the line costs the frames that it hits.

mod address;
mod client;
mod error;
mod key;
mod port;
mod queries;
mod recalibrate;
mod transfer;
mod words;

pub use address::{Address, BadAddress, SerialLine};
pub use client::{Client, Timing};
pub use error::{DeviceError, Fault};
pub use key::{KEY_VARIABLE, KeyError, key_from_environment, key_from_file};
pub use port::Port;
pub use recalibrate::{Calibrated, Calibration, Watching};
pub use transfer::{TableMismatch, check};
pub use words::{
    class_name, failure_name, failure_text, obstacle_text, refusal_text, stage_name, stage_text,
};

//! What goes wrong between host and device, and what to do about it.

use std::io;
use std::time::Duration;

use quadcal::recalibrate::Failure;
use quadcal::slot::SlotError;
use quadcal::wire::{Refusal, VERSION};
use thiserror::Error;

use super::transfer::TableMismatch;
use super::words::{failure_text, refusal_text};

/// What went wrong, and at which port.
#[derive(Debug, Error)]
#[error("{port}: {fault}")]
pub struct DeviceError {
    /// The port, as it was named.
    pub port: String,
    /// What went wrong there.
    pub fault: Fault,
}

/// What went wrong. Prints as one line: what is wrong, then what to do.
#[derive(Debug, Error)]
pub enum Fault {
    /// The port can't be opened.
    #[error("cannot be opened ({0}); {advice}", advice = open_advice(.0))]
    Open(io::Error),
    /// The connection is gone.
    #[error(
        "the connection failed ({0}); check cable and power, then look with 'quadcal device status'"
    )]
    Lost(io::Error),
    /// No reply came to a request that only reads.
    #[error("{}", silent(*tries, *wait, *bytes))]
    Silent {
        /// How often it was asked.
        tries: u32,
        /// How long each time.
        wait: Duration,
        /// Bytes that came, none of them a reply.
        bytes: u64,
    },
    /// No reply came to a request that changes something.
    #[error(
        "no reply to '{what}' within {wait:.1?}: it may have been done or not; look with 'quadcal device status'"
    )]
    Unanswered {
        /// What was asked for.
        what: &'static str,
        /// How long the reply was waited for.
        wait: Duration,
    },
    /// The device speaks another protocol version.
    #[error(
        "the device speaks protocol version {device}, this quadcal speaks {VERSION}; update {}",
        if *device > VERSION { "quadcal" } else { "the device's firmware" }
    )]
    Version {
        /// The device's.
        device: u8,
    },
    /// A reply came that makes no sense.
    #[error(
        "the reply to '{what}' is not known to this quadcal; update it to the firmware's version"
    )]
    UnknownReply {
        /// What was asked for.
        what: &'static str,
    },
    /// The key is not the device's.
    #[error("the key is not this device's; give the right one with --key-file or QUADCAL_KEY")]
    WrongKey,
    /// Another host has opened a session.
    #[error(
        "another host has opened a session meanwhile; make sure that one alone commands the device, and try again"
    )]
    SessionTaken,
    /// The device refuses.
    #[error("'{what}' is refused: {text}", text = refusal_text(refusal))]
    Refused {
        /// What was asked for.
        what: &'static str,
        /// Why it is not done.
        refusal: Refusal,
    },
    /// A calibration, or writing a table, came to nothing.
    #[error("{text}", text = failure_text(.0))]
    Failed(Failure),
    /// The device takes the command to commit, but does not write the table.
    #[error(
        "the drive's interlock lets the command through but not the writing; bring the machine to rest and try again"
    )]
    HeldBack,
    /// A calibration is no longer there.
    #[error("the calibration is gone: the device was restarted or told to abort; start again")]
    Gone,
    /// The table did not arrive whole.
    #[error(
        "the table that was read is damaged ({0:?}); read it again, and calibrate anew if that stays so"
    )]
    DamagedTable(SlotError),
    /// A table is not for this device.
    #[error("{0}")]
    Mismatch(#[from] TableMismatch),
}

impl Fault {
    /// At a port.
    #[must_use]
    pub fn at(self, port: &str) -> DeviceError {
        DeviceError {
            port: port.to_owned(),
            fault: self,
        }
    }
}

fn open_advice(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::NotFound => "check the name, and that the device is plugged in or QEMU runs",
        io::ErrorKind::PermissionDenied => {
            "ask for access to the port, on Linux by joining its group (often dialout)"
        }
        io::ErrorKind::ConnectionRefused => "nothing listens there: start the device or QEMU first",
        _ => "check the name, and that no other program has the port open",
    }
}

fn silent(tries: u32, wait: Duration, bytes: u64) -> String {
    let asked = format!("no reply, asked {tries} times with {wait:.1?} each");
    match bytes {
        0 => format!(
            "{asked}; check port, cable and power, that no other program has the port, and that the firmware serves calibration"
        ),
        bytes => format!(
            "{asked}, but {bytes} bytes of something else; check --baud, and that no other program uses the port"
        ),
    }
}

//! What a host asks of a device. The order of the variants is their number on the wire: new ones go to the end.

use serde::{Deserialize, Serialize};

use super::PIECE_BYTES;
use crate::recalibrate::Options;

/// Bytes of a table, as many as one message takes.
pub type Piece = heapless::Vec<u8, PIECE_BYTES>;

/// Bytes of a message authentication code: the first half of HMAC-SHA-256.
pub const MAC_BYTES: usize = 16;

/// The first half of an HMAC-SHA-256.
pub type MacBytes = [u8; MAC_BYTES];

/// Bytes of a challenge.
pub const NONCE_BYTES: usize = 16;

/// A number that is used once.
pub type Nonce = [u8; NONCE_BYTES];

/// How much the device logs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LogLevel {
    /// Nothing.
    Off,
    /// What went wrong.
    Error,
    /// What may go wrong.
    Warn,
    /// What was done.
    #[default]
    Info,
    /// Turn by turn.
    Debug,
}

/// What a host asks of a device.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Request {
    /// Who are you? [`super::Reply::Identity`].
    Identify,
    /// Where does calibration stand, which table is in use? [`super::Reply::Status`].
    Status,
    /// Angle, speed and faults now. [`super::Reply::Live`].
    Live,
    /// What the last calibration found. [`super::Reply::Result`].
    Result,
    /// New table against old on fresh turns. [`super::Reply::Preview`].
    Preview,
    /// The slot in use from a byte on, a multiple of [`super::PIECE_STEP`]. [`super::Reply::Table`].
    ReadTable {
        /// First byte of the slot wanted.
        offset: u32,
    },
    /// A nonce to open a session with. [`super::Reply::Challenge`].
    Challenge,
    /// Opens a session. [`super::Reply::Opened`].
    Open {
        /// Proof that the key is known; see [`crate::access`].
        proof: MacBytes,
    },
    /// Starts a calibration. Sealed; [`super::Reply::Done`].
    Start(Options),
    /// Ends a calibration, or gives a table up that waits to be committed. Sealed; [`super::Reply::Done`].
    Abort,
    /// Writes the table that waits to flash; status tells how it went. Sealed; [`super::Reply::Done`].
    Commit,
    /// Withdraws the table in use for the one before. Sealed; [`super::Reply::Done`].
    RollBack,
    /// Hands over the next piece of a slot, from byte 0 on; the last one makes it wait to be committed. Sealed;
    /// [`super::Reply::Written`].
    WriteTable {
        /// Where in the slot the piece belongs.
        offset: u32,
        /// The bytes.
        piece: Piece,
    },
    /// Erases all tables. Sealed; [`super::Reply::Done`].
    Erase,
    /// Sets how much is logged. Sealed; [`super::Reply::Done`].
    LogLevel(LogLevel),
    /// Ends the session. Sealed; [`super::Reply::Done`].
    Close,
}

impl Request {
    /// Whether it changes nothing but who may: such a request needs no session.
    #[must_use]
    pub const fn is_open_to_all(&self) -> bool {
        matches!(
            self,
            Self::Identify
                | Self::Status
                | Self::Live
                | Self::Result
                | Self::Preview
                | Self::ReadTable { .. }
                | Self::Challenge
                | Self::Open { .. }
        )
    }
}

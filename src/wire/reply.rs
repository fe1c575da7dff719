//! What a device answers. The order of the variants is their number on the wire: new ones go to the end.

use serde::{Deserialize, Serialize};

use super::request::{LogLevel, Nonce, Piece};
use crate::recalibrate::{Figures, Obstacle, Stage, WriteFailure};
use crate::shape::CLASSES_MAX;

/// What a device answers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reply {
    /// It is done, or begun.
    Done,
    /// It is not.
    Refused(Refusal),
    /// To [`super::Request::Identify`].
    Identity(Identity),
    /// To [`super::Request::Status`].
    Status(Status),
    /// To [`super::Request::Live`].
    Live(Live),
    /// To [`super::Request::Result`]; none before a calibration came to a table.
    Result(Option<Learned>),
    /// To [`super::Request::Preview`]; none before a table was proven.
    Preview(Option<Figures>),
    /// To [`super::Request::ReadTable`].
    Table {
        /// First byte of the slot given.
        offset: u32,
        /// Bytes of the whole slot.
        whole: u32,
        /// The bytes; fewer than a whole piece at the end.
        piece: Piece,
    },
    /// To [`super::Request::Challenge`].
    Challenge {
        /// What the proof has to be made over.
        nonce: Nonce,
    },
    /// To [`super::Request::Open`].
    Opened {
        /// Time without a sealed request after which the session ends, milliseconds.
        idle_ms: u32,
    },
    /// To [`super::Request::WriteTable`].
    Written {
        /// Byte wanted next.
        next: u32,
        /// Whether the table is whole and waits to be committed.
        whole: bool,
    },
}

/// Why something is not done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refusal {
    /// The frame is of another protocol version; this is the one spoken.
    Version(u8),
    /// No request that is known.
    Unknown,
    /// There is no session, or it has ended.
    NoSession,
    /// The key is another.
    WrongProof,
    /// The counter is not above that of the request before.
    Replayed,
    /// Too many wrong proofs: wait so long, milliseconds.
    Wait(u32),
    /// The device has no nonce to give.
    NoNonce,
    /// Not in this stage.
    Stage(Stage),
    /// The firmware does not allow it now.
    Interlock(Obstacle),
    /// The flash was written too often lately: wait so long, seconds.
    Wear(u32),
    /// The flash was not written.
    NotWritten(WriteFailure),
    /// The flash can't be read.
    Flash,
    /// There is no older table.
    NothingOlder,
    /// There is no table.
    NoTable,
    /// A piece from this byte on is wanted.
    Offset(u32),
    /// The table that was handed over can't be used.
    Table(TableFault),
    /// No speed is both in the window asked for and in the device's.
    Window,
}

/// Why a table that was handed over can't be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TableFault {
    /// It is no slot, or one of a version that is not written any more.
    Header,
    /// It is of an encoder of another shape.
    Shape,
    /// It is of another encoder, by its serial number.
    Encoder,
    /// Its delays can't be told in ticks of the device's clock.
    Clock,
    /// Bytes were changed on the way.
    Crc,
}

/// Who a device is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Identity {
    /// Version of the firmware: major, minor, patch.
    pub firmware: [u8; 3],
    /// Version of the slots that it writes.
    pub slot_version: u16,
    /// Edges a turn, N.
    pub edges: u32,
    /// Edge classes, C.
    pub classes: u8,
    /// Ticks a second.
    pub clock_hz: u64,
    /// Serial number of the encoder, 0: not given.
    pub serial: u64,
}

/// Where things stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Status {
    /// Where the calibration stands.
    pub stage: Stage,
    /// Turns taken, of those learned from or, when proving, of those proven on.
    pub turns: u32,
    /// Turns wanted at the most.
    pub turns_wanted: u32,
    /// Turns that could not be used.
    pub rejected: u32,
    /// How much of the table is solved for, per cent.
    pub solved_percent: u8,
    /// Whether a session is open.
    pub session: bool,
    /// The table in use.
    pub table: Option<TableInfo>,
    /// Times that either place in flash was erased.
    pub wear: [u32; 2],
    /// How much is logged.
    pub log_level: LogLevel,
    /// Frames that could not be read since the start.
    pub bad_frames: u32,
    /// Time since the start, milliseconds.
    pub uptime_ms: u64,
}

/// The table in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TableInfo {
    /// The place in flash, 0 or 1.
    pub place: u8,
    /// Counts up from commit to commit.
    pub sequence: u32,
    /// Turns that it was learned from.
    pub turns: u32,
    /// Standard error of a line position error, 2^-32 turn.
    pub standard_error: u32,
    /// RMS of the error that it holds, 2^-32 turn.
    pub table_rms: u32,
    /// Serial number of its encoder, 0: not given.
    pub serial: u64,
    /// When it was learned, seconds since 1970, 0: not given.
    pub learned_at: u64,
    /// Temperature then, 1/16 degree Celsius.
    pub temperature_q4: Option<i16>,
}

/// The shaft now.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Live {
    /// The time of it, ticks.
    pub ticks: u64,
    /// Corrected angle, 2^-32 turn.
    pub angle: u32,
    /// Whether the angle counts from the index.
    pub referenced: bool,
    /// Speed without the table, 2^-60 turn a tick.
    pub speed_raw: i64,
    /// Speed with the table, 2^-60 turn a tick.
    pub speed: i64,
    /// Faults counted, in the order of [`crate::step::Faults`].
    pub faults: [u32; 7],
}

/// What the last calibration found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Learned {
    /// Turns learned from.
    pub turns: u32,
    /// Turns that could not be used.
    pub rejected: u32,
    /// Error RMS to expect after correction, 2^-32 turn.
    pub standard_error: u32,
    /// Standard error of a class offset, 2^-32 turn.
    pub class_standard_error: u32,
    /// RMS of the error that the table holds, 2^-32 turn.
    pub table_rms: u32,
    /// Mean error of every class, 2^-32 turn; those beyond C are zero.
    pub class_offsets: [i32; CLASSES_MAX],
    /// Delay of every class, 2^-8 tick; those beyond C are zero.
    pub class_delays: [i32; CLASSES_MAX],
}

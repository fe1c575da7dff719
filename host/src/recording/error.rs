//! What can be wrong with a recording.

use thiserror::Error;

use super::place::Place;

/// Why a recording could not be read. Each prints as one line, `FILE:LINE:COLUMN: what is wrong; what to do`.
#[derive(Debug, Error)]
pub enum ReadError {
    /// The file does not exist.
    #[error("{at}: no such file; check the path")]
    MissingFile {
        /// The file.
        at: Place,
    },
    /// The operating system refused to read.
    #[error("{at}: cannot be read ({source}); check the file and its permissions")]
    Io {
        /// The file, and the line reached.
        at: Place,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The file has no bytes, or only blank ones.
    #[error("{at}: the file is empty; record again or give another file")]
    Empty {
        /// The file.
        at: Place,
    },
    /// The content is none of the formats that are read.
    #[error(
        "{at}: {found}, not a known recording; give native CSV (ticks,a,b,z), logic-analyser CSV (Time [s],A,B,Z), VCD or \
         a one-column list of seconds, or force the format"
    )]
    UnknownFormat {
        /// The line that decided.
        at: Place,
        /// What the content looks like.
        found: String,
    },
    /// A NUL byte or bytes that are not UTF-8.
    #[error("{at}: not text; export the recording as CSV or VCD text in UTF-8")]
    NotText {
        /// First line that is not text.
        at: Place,
    },
    /// A line, or a VCD command, is longer than any recording has.
    #[error("{at}: longer than {limit} bytes; this is not a recording, or its line ends are lost")]
    TooLong {
        /// The line.
        at: Place,
        /// Longest length that is read, in bytes.
        limit: usize,
    },
    /// A column or signal that is needed is not there.
    #[error(
        "{at}: no column {wanted}, found {found}; rename a column or map {wanted} to one of them"
    )]
    MissingColumn {
        /// The column line.
        at: Place,
        /// Name of the column that was looked for.
        wanted: String,
        /// Names that are there.
        found: String,
    },
    /// Two columns or signals go by the same name.
    #[error(
        "{at}: more than one column of this name; rename one, or map to a name that is there once"
    )]
    DuplicateColumn {
        /// The column line.
        at: Place,
    },
    /// A header line whose value makes no sense.
    #[error("{at}: {key} is '{value}'; it must be {wanted}")]
    BadHeader {
        /// The header line.
        at: Place,
        /// Key of the line.
        key: String,
        /// Its value, shortened.
        value: String,
        /// What is accepted.
        wanted: &'static str,
    },
    /// The recording does not say how long a tick is.
    #[error("{at}: the tick rate is not given; add a line '{wanted}' at the head of the file")]
    NoClock {
        /// Where the header ends.
        at: Place,
        /// The line that is missing.
        wanted: &'static str,
    },
    /// A row has too few or too many fields.
    #[error("{at}: {found} fields where the column line has {wanted}; correct the row")]
    Fields {
        /// The row.
        at: Place,
        /// Fields of this row.
        found: usize,
        /// Fields of the column line.
        wanted: usize,
    },
    /// The file ends in the middle of something.
    #[error(
        "{at}: the file is cut off {within}; record or copy it again, or delete what is incomplete"
    )]
    Truncated {
        /// The last line.
        at: Place,
        /// What is incomplete.
        within: &'static str,
    },
    /// A time that is not a number.
    #[error("{at}: '{text}' is not {wanted}; correct or delete the row")]
    BadTime {
        /// The field.
        at: Place,
        /// The field's text, shortened.
        text: String,
        /// What is accepted.
        wanted: &'static str,
    },
    /// No column of the torque's name.
    #[error("{at}: no column {wanted} for the torque, found {found}; give the name of one of them")]
    MissingTorque {
        /// The column line.
        at: Place,
        /// Name that was looked for.
        wanted: String,
        /// Names that are there.
        found: String,
    },
    /// A torque that is not a finite number.
    #[error("{at}: '{text}' is not a torque in N m; correct or delete the row")]
    BadTorque {
        /// The field.
        at: Place,
        /// The field's text, shortened.
        text: String,
    },
    /// A time that is NaN or infinite.
    #[error("{at}: the time is '{text}', not a finite number; correct or delete the row")]
    NotFinite {
        /// The field.
        at: Place,
        /// The field's text, shortened.
        text: String,
    },
    /// An interval below zero.
    #[error("{at}: negative interval '{text}'; if the list holds times, read it as times")]
    NegativeInterval {
        /// The field.
        at: Place,
        /// The field's text, shortened.
        text: String,
    },
    /// A time before the one of the row above.
    #[error("{at}: time falls from {previous} to {time} ({unit}); {advice}")]
    TimeFalls {
        /// The field.
        at: Place,
        /// Time of this row.
        time: i128,
        /// Time of the row above.
        previous: i128,
        /// Unit of both.
        unit: &'static str,
        /// What may help in this format.
        advice: &'static str,
    },
    /// A time too large for 64-bit ticks (for seconds: for 64-bit nanoseconds).
    #[error(
        "{at}: time '{text}' is beyond 64-bit ticks; correct the row, or subtract the start time"
    )]
    TimeOverflow {
        /// The field.
        at: Place,
        /// The field's text, shortened.
        text: String,
    },
    /// A level that is not 0 or 1.
    #[error("{at}: level is '{text}'; it must be 0 or 1")]
    BadLevel {
        /// The field.
        at: Place,
        /// The field's text, shortened.
        text: String,
    },
    /// An undefined level in a VCD, after the signal had a definite one.
    #[error(
        "{at}: level becomes '{text}' after a definite one; record without dump pauses and with a driven input"
    )]
    UnknownLevel {
        /// The signal.
        at: Place,
        /// `x` or `z`.
        text: char,
    },
    /// Something in a VCD that IEEE 1364 does not allow.
    #[error("{at}: not valid VCD ({reason}); export the recording again")]
    Vcd {
        /// Line of the VCD.
        at: Place,
        /// What the parser stumbled over.
        reason: String,
    },
    /// Header, but nothing recorded.
    #[error("{at}: no edges in the recording; record again")]
    NoRows {
        /// The file.
        at: Place,
    },
}

impl ReadError {
    /// Where in the file it is.
    #[must_use]
    pub fn place(&self) -> &Place {
        match self {
            Self::MissingFile { at, .. }
            | Self::Io { at, .. }
            | Self::Empty { at, .. }
            | Self::UnknownFormat { at, .. }
            | Self::NotText { at, .. }
            | Self::TooLong { at, .. }
            | Self::MissingColumn { at, .. }
            | Self::DuplicateColumn { at, .. }
            | Self::BadHeader { at, .. }
            | Self::NoClock { at, .. }
            | Self::Fields { at, .. }
            | Self::Truncated { at, .. }
            | Self::BadTime { at, .. }
            | Self::MissingTorque { at, .. }
            | Self::BadTorque { at, .. }
            | Self::NotFinite { at, .. }
            | Self::NegativeInterval { at, .. }
            | Self::TimeFalls { at, .. }
            | Self::TimeOverflow { at, .. }
            | Self::BadLevel { at, .. }
            | Self::UnknownLevel { at, .. }
            | Self::Vcd { at, .. }
            | Self::NoRows { at, .. } => at,
        }
    }
}

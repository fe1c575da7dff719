//! Recordings of encoder edges: reading, in passing, every format the field has, and writing two of them.
//!
//! | format | told by | ticks |
//! |---|---|---|
//! | native CSV | a `ticks` column | as written, `# clock_hz` a second |
//! | logic-analyser CSV | a `Time [s]` column (or ms, us, ns) | nanoseconds from the first row |
//! | VCD | `$` at the start, or the extension | units of `$timescale`, nanoseconds where these are finer |
//! | one-column list | one number a line | nanoseconds from the first pulse |
//!
//! CSV columns may stand in any order and others may stand between them. The channels follow from the columns: `a,b,z` and `a,b` are
//! quadrature, `a,b,c` three Hall sensors, `a` a toothed wheel, and the time alone pulses. With `# timer_bits = 16` or `32` the ticks
//! of a native CSV are raw captures of a timer of that width and are extended on reading: each one smaller than the one above is one
//! wrap, so of a pause longer than the timer's period whole periods are lost unseen.
//!
//! Everything is read line by line in a fixed amount of memory. A row that repeats the levels above it is no edge; it is counted
//! and left out. No input makes a reader panic.

mod atomic;
mod columns;
mod decimal;
mod error;
mod feed;
mod lines;
mod list;
mod logic;
mod native;
mod notes;
mod options;
mod place;
mod sniff;
#[cfg(test)]
mod tests;
pub mod torque;
mod vcd;
mod vcd_header;
mod vcd_time;
pub mod write;

use std::fs::File;
use std::io::{Cursor, ErrorKind, Read};
use std::path::Path;
use std::sync::Arc;

use quadcal::edge::{Levels, Sample};

pub use error::ReadError;
pub use lines::LINE_LIMIT;
pub use options::{Format, ListKind, Mapping, MappingError, ReadOptions, Signal};
pub use place::{ColumnRef, Place};

use lines::{Input, Lines};

/// Ticks a second of every format that gives times in seconds.
pub const NANOSECOND_HZ: u64 = 1_000_000_000;

/// What the level bits of a recording's samples mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channels {
    /// A, B and, where `index` is set, Z.
    Quadrature {
        /// Whether the recording has a Z column.
        index: bool,
    },
    /// Three Hall sensors A, B, C.
    Hall,
    /// One channel with both edges (a toothed wheel).
    Wheel,
    /// One channel with one pulse a tooth; every sample is a pulse and its levels carry nothing.
    Pulses,
}

/// What a recording says of itself before its first sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// Tick rate of the samples' times, in hertz.
    pub clock_hz: u64,
    /// Meaning of the level bits.
    pub channels: Channels,
    /// Every `# key = value` line, in order, as written; of a VCD, its comments of that form.
    pub notes: Vec<(String, String)>,
}

/// One change of level; the times of a recording never fall.
pub type Row = Sample;

/// A recording being read: an iterator of its rows, which ends after the first error.
pub struct Recording {
    /// What the recording says of itself.
    pub header: Header,
    source: Source,
    file: Arc<str>,
    total_bytes: Option<u64>,
    last: Option<Levels>,
    repeated_rows: u64,
    done: bool,
}

enum Source {
    Native(native::Native),
    Logic(logic::Logic),
    Vcd(Box<vcd::Vcd>),
    List(list::List),
}

/// Opens the recording at `path` and reads up to its first row.
///
/// # Errors
/// Where the file cannot be opened, is of no known format, or its header lacks what is needed.
pub fn open(path: &Path, options: &ReadOptions) -> Result<Recording, ReadError> {
    let name: Arc<str> = path.display().to_string().into();
    let fail = |source: std::io::Error| {
        let at = Place::file(&name);
        match source.kind() {
            ErrorKind::NotFound => ReadError::MissingFile { at },
            _ => ReadError::Io { at, source },
        }
    };
    let file = File::open(path).map_err(fail)?;
    let metadata = file.metadata().map_err(fail)?;
    let mut recording = from_reader(file, &name, options)?;
    recording.total_bytes = metadata.is_file().then_some(metadata.len());
    Ok(recording)
}

/// Reads a recording from `reader`; `name` stands for the file in messages, and its extension helps to find the format.
///
/// # Errors
/// As [`open`].
pub fn from_reader(
    mut reader: impl Read + Send + 'static,
    name: &str,
    options: &ReadOptions,
) -> Result<Recording, ReadError> {
    let file: Arc<str> = name.into();
    let mut head = Vec::new();
    reader
        .by_ref()
        .take(sniff::HEAD as u64)
        .read_to_end(&mut head)
        .map_err(|source| ReadError::Io {
            at: Place::file(&file),
            source,
        })?;
    // Spreadsheets put a byte order mark before UTF-8 text.
    let skipped = if head.starts_with(b"\xef\xbb\xbf") {
        3
    } else {
        0
    };
    let format = sniff::format(&head[skipped..], &file, options)?;
    let mut start = Cursor::new(head);
    start.set_position(skipped as u64);
    let input: Input = Box::new(start.chain(reader));
    let (source, header) = match format {
        Format::Native => {
            let (source, header) = native::Native::open(Lines::new(input, &file), options)?;
            (Source::Native(source), header)
        }
        Format::Logic => {
            let (source, header) = logic::Logic::open(Lines::new(input, &file), options)?;
            (Source::Logic(source), header)
        }
        Format::List => {
            let (source, header) = list::List::open(Lines::new(input, &file), options)?;
            (Source::List(source), header)
        }
        Format::Vcd => {
            let (source, header) = vcd::Vcd::open(input, &file, options)?;
            (Source::Vcd(Box::new(source)), header)
        }
    };
    Ok(Recording {
        header,
        source,
        file,
        total_bytes: None,
        last: None,
        repeated_rows: 0,
        done: false,
    })
}

impl Recording {
    /// The format that was found or forced.
    #[must_use]
    pub fn format(&self) -> Format {
        match self.source {
            Source::Native(_) => Format::Native,
            Source::Logic(_) => Format::Logic,
            Source::Vcd(_) => Format::Vcd,
            Source::List(_) => Format::List,
        }
    }

    /// What a one-column list was taken for, [`ListKind::Intervals`] or [`ListKind::Times`]; none for other formats.
    #[must_use]
    pub fn list_kind(&self) -> Option<ListKind> {
        match &self.source {
            Source::List(list) => Some(list.kind()),
            _ => None,
        }
    }

    /// Rows left out so far because they repeat the levels of the row above.
    #[must_use]
    pub fn repeated_rows(&self) -> u64 {
        self.repeated_rows
    }

    /// Bytes of the file that are read.
    pub fn bytes_read(&mut self) -> u64 {
        match &mut self.source {
            Source::Native(source) => source.consumed(),
            Source::Logic(source) => source.consumed(),
            Source::Vcd(source) => source.consumed(),
            Source::List(source) => source.consumed(),
        }
    }

    /// Bytes of the whole file; none for a pipe or a reader.
    #[must_use]
    pub fn total_bytes(&self) -> Option<u64> {
        self.total_bytes
    }

    fn next_row(&mut self) -> Result<Option<Row>, ReadError> {
        loop {
            let row = match &mut self.source {
                Source::Native(source) => source.next_row(),
                Source::Logic(source) => source.next_row(),
                Source::Vcd(source) => source.next_row(),
                Source::List(source) => source.next_row(),
            }?;
            let Some(row) = row else {
                return match self.last {
                    Some(_) => Ok(None),
                    None => Err(ReadError::NoRows {
                        at: Place::file(&self.file),
                    }),
                };
            };
            if self.last != Some(row.levels) || self.header.channels == Channels::Pulses {
                self.last = Some(row.levels);
                return Ok(Some(row));
            }
            self.repeated_rows += 1;
        }
    }
}

impl Iterator for Recording {
    type Item = Result<Row, ReadError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.done {
            return None;
        }
        let row = self.next_row().transpose();
        self.done = !matches!(row, Some(Ok(_)));
        row
    }
}

impl std::iter::FusedIterator for Recording {}

impl std::fmt::Debug for Recording {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Recording")
            .field("file", &self.file)
            .field("format", &self.format())
            .field("header", &self.header)
            .finish_non_exhaustive()
    }
}

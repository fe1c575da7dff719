//! Options with which every command reads a recording.

use std::fs;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use crate::recording::{self, Format, ListKind, Mapping, ReadError, ReadOptions, Recording};
use crate::table_file;

use super::Globals;
use super::failure::Failure;
use super::output::Target;
use super::progress::Watched;

/// A recording and how to read it.
#[derive(Clone, Debug, Args)]
pub struct InputArgs {
    /// Recording of edges: native CSV, logic-analyser CSV, VCD, or one column of seconds
    #[arg(value_name = "REC")]
    pub recording: PathBuf,
    #[command(flatten)]
    pub(super) reading: ReadingArgs,
}

/// How to read a recording.
#[derive(Clone, Debug, Args)]
pub struct ReadingArgs {
    /// Format of REC, where its content does not tell
    #[arg(long, value_enum, help_heading = "Reading")]
    format: Option<FormatName>,
    /// Column or VCD signal of a channel (time, a, b, z or c), as in 'a=Channel 0'; repeatable
    #[arg(long, value_name = "CHANNEL=NAME", help_heading = "Reading")]
    map: Vec<Mapping>,
    /// What the numbers of a one-column list are; 'auto' if not given
    #[arg(
        long,
        value_enum,
        value_name = "KIND",
        default_value = "auto",
        hide_default_value = true,
        help_heading = "Reading"
    )]
    list: ListName,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum FormatName {
    /// CSV with '# clock_hz = ...' and a ticks column
    Native,
    /// CSV of a logic analyser, with a column 'Time [s]'
    Logic,
    /// Value change dump
    Vcd,
    /// One number a line, in seconds
    List,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ListName {
    /// Times if the first 64 numbers rise, else intervals
    Auto,
    /// Seconds from pulse to pulse
    Intervals,
    /// Seconds at which the pulses came
    Times,
}

impl ReadingArgs {
    /// A recording that is read so.
    #[must_use]
    pub fn of(&self, recording: &Path) -> InputArgs {
        InputArgs {
            recording: recording.to_owned(),
            reading: self.clone(),
        }
    }

    /// The options as the readers take them.
    #[must_use]
    pub fn options(&self) -> ReadOptions {
        ReadOptions {
            format: self.format.map(|name| match name {
                FormatName::Native => Format::Native,
                FormatName::Logic => Format::Logic,
                FormatName::Vcd => Format::Vcd,
                FormatName::List => Format::List,
            }),
            map: self.map.clone(),
            list: match self.list {
                ListName::Auto => ListKind::Auto,
                ListName::Intervals => ListKind::Intervals,
                ListName::Times => ListKind::Times,
            },
        }
    }
}

impl InputArgs {
    /// Opens the recording.
    ///
    /// # Errors
    /// As [`recording::open`].
    pub fn open(&self) -> Result<Recording, Failure> {
        Ok(self.reopen()?)
    }

    /// As [`open`](Self::open), for a caller that has more to say of an error.
    ///
    /// # Errors
    /// As [`recording::open`].
    pub fn reopen(&self) -> Result<Recording, ReadError> {
        recording::open(&self.recording, &self.reading.options())
    }

    /// Opens the recording to read its rows, with progress.
    ///
    /// # Errors
    /// As [`recording::open`].
    pub fn rows(&self, globals: Globals) -> Result<Watched, Failure> {
        Ok(Watched::new(self.reopen()?, globals))
    }

    /// The check sum by which a table knows this recording.
    ///
    /// # Errors
    /// [`Failure::Open`].
    pub fn source(&self) -> Result<u32, Failure> {
        table_file::source_of(&self.recording).map_err(|source| Failure::Open {
            path: self.recording.clone(),
            source,
        })
    }

    /// Refuses a pipe or device, which can't be read twice. A file that does not exist is left to the reader to report.
    ///
    /// # Errors
    /// [`Failure::NotAFile`].
    pub fn check_regular(&self) -> Result<(), Failure> {
        match fs::metadata(&self.recording) {
            Ok(found) if !found.is_file() && !found.is_dir() => Err(Failure::NotAFile {
                path: self.recording.clone(),
            }),
            _ => Ok(()),
        }
    }

    /// Refuses an output that would take the recording's place.
    ///
    /// # Errors
    /// [`Failure::OverInput`].
    pub fn spare(&self, target: &Target) -> Result<(), Failure> {
        target.spare(&self.recording)
    }
}

//! How a command ends when it cannot do what was asked: one line on stderr and an exit code.

use std::io;
use std::io::Write as _;
use std::process::ExitCode;

use thiserror::Error;

use crate::recording::ReadError;
use crate::recording::write::WriteError;

use super::output::Target;

/// Why a command did not do what was asked. Prints as one line, what is wrong and where, then what to do.
#[derive(Debug, Error)]
pub enum Failure {
    /// A recording cannot be read.
    #[error("{0}{hint}", hint = option_for(.0))]
    Read(Box<ReadError>),
    /// A recording holds what the format to be written cannot.
    #[error("{target}: {source}; write the other format")]
    Unwritable {
        /// Where it was to go.
        target: Target,
        /// What the format cannot hold.
        source: WriteError,
    },
    /// An output cannot be written.
    #[error(
        "{target}: cannot be written ({source}); check the folder, its permissions and the free space"
    )]
    Write {
        /// Where it was to go.
        target: Target,
        /// The system's reason.
        source: io::Error,
    },
    /// An output would take the place of an input.
    #[error("{target}: is the input itself; give another name for the output")]
    OverInput {
        /// The output.
        target: Target,
    },
    /// The name of an output does not say its format.
    #[error(
        "{target}: cannot tell the format from the name; end it in .csv or .vcd, or add --to csv or --to vcd"
    )]
    OutputFormat {
        /// The output.
        target: Target,
    },
}

impl From<ReadError> for Failure {
    fn from(error: ReadError) -> Self {
        Self::Read(Box::new(error))
    }
}

impl Failure {
    /// Prints the failure and gives the exit code. A reader of stdout that has seen enough is no failure and prints nothing.
    #[must_use]
    pub fn report(&self) -> ExitCode {
        if self.is_closed_pipe() {
            return ExitCode::SUCCESS;
        }
        // Where stderr is closed there is nobody left to tell.
        let _ = writeln!(io::stderr(), "quadcal: {self}");
        ExitCode::from(self.exit_code())
    }

    /// 2 where the input or the command line is to blame, else 1.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Write { .. } => 1,
            Self::Read(_)
            | Self::Unwritable { .. }
            | Self::OverInput { .. }
            | Self::OutputFormat { .. } => 2,
        }
    }

    fn is_closed_pipe(&self) -> bool {
        matches!(self, Self::Write { target: Target::Stdout, source } if source.kind() == io::ErrorKind::BrokenPipe)
    }

    /// Sorts a writer's error into the system's part and the format's.
    #[must_use]
    pub fn writing(target: &Target, error: WriteError) -> Self {
        let target = target.clone();
        match error {
            WriteError::Io(source) => Self::Write { target, source },
            source => Self::Unwritable { target, source },
        }
    }
}

/// The option that carries out what the reader advises, as the reader knows no command line.
fn option_for(error: &ReadError) -> String {
    match error {
        ReadError::MissingColumn { wanted, .. } => {
            // The mapping knows the time by one name, whatever the column's own.
            let signal = match wanted.as_str() {
                signal @ ("a" | "b" | "c" | "z") => signal,
                _ => "time",
            };
            format!(" (--map {signal}=NAME)")
        }
        ReadError::DuplicateColumn { .. } => " (--map a=NAME)".to_owned(),
        ReadError::UnknownFormat { .. } => " (--format)".to_owned(),
        ReadError::NegativeInterval { .. } => " (--list times)".to_owned(),
        ReadError::TimeFalls { advice, .. } if advice.contains("as intervals") => {
            " (--list intervals)".to_owned()
        }
        _ => String::new(),
    }
}

//! Where results go: files that appear whole or not at all, stdout, JSON, and text for people.

mod apart;
mod facts;

use std::ffi::OsString;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, StdoutLock, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use crate::recording::write::AtomicFile;
use crate::report::Report;

use super::failure::Failure;
use apart::same_file;
pub use apart::spare;
pub use facts::Facts;

/// Where an output goes; written `-` for stdout.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Target {
    /// The standard output.
    Stdout,
    /// A file.
    File(PathBuf),
}

impl From<OsString> for Target {
    fn from(text: OsString) -> Self {
        if text == "-" {
            Self::Stdout
        } else {
            Self::File(text.into())
        }
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stdout => f.write_str("standard output"),
            Self::File(path) => {
                // A control character in a name must not break the message into lines.
                let name = path.display().to_string();
                f.write_str(&name.replace(char::is_control, "?"))
            }
        }
    }
}

impl Target {
    /// Starts the output.
    ///
    /// # Errors
    /// [`Failure::Write`].
    pub fn create(&self) -> Result<Output, Failure> {
        let failed = |source| self.failed(source);
        match self {
            Self::Stdout => Ok(Output::Stdout(io::stdout().lock())),
            Self::File(path) => match fs::metadata(path) {
                Ok(found) if found.is_dir() => Err(failed(io::ErrorKind::IsADirectory.into())),
                // A device or pipe must stay what it is.
                Ok(found) if !found.is_file() => {
                    let file = File::options().write(true).open(path).map_err(failed)?;
                    Ok(Output::Device(file))
                }
                // The file behind a link takes the new content, and the link stays.
                Ok(_) => {
                    let path = fs::canonicalize(path).map_err(failed)?;
                    AtomicFile::create(&path).map(Output::File).map_err(failed)
                }
                Err(_) => AtomicFile::create(path).map(Output::File).map_err(failed),
            },
        }
    }

    /// Whether it is a file whose name ends in `.extension`, upper or lower case.
    #[must_use]
    pub fn has_extension(&self, extension: &str) -> bool {
        match self {
            Self::File(path) => path
                .extension()
                .is_some_and(|found| found.eq_ignore_ascii_case(extension)),
            Self::Stdout => false,
        }
    }

    /// Refuses to take the place of `input`, through links or not.
    ///
    /// # Errors
    /// [`Failure::OverInput`].
    pub fn spare(&self, input: &Path) -> Result<(), Failure> {
        match self {
            Self::File(path) if same_file(input, path) => Err(Failure::OverInput {
                target: self.clone(),
            }),
            _ => Ok(()),
        }
    }

    /// Writes all of `bytes` as the whole output.
    ///
    /// # Errors
    /// [`Failure::Write`]; a file is then as it was.
    pub fn write(&self, bytes: &[u8]) -> Result<(), Failure> {
        let mut output = self.create()?;
        output
            .write_all(bytes)
            .and_then(|()| output.commit())
            .map_err(|source| self.failed(source))
    }

    /// Writes `value` as indented JSON with a line end.
    ///
    /// # Errors
    /// [`Failure::Write`]; a file is then as it was.
    pub fn write_json(&self, value: &impl Serialize) -> Result<(), Failure> {
        self.write(&self.json_of(value)?)
    }

    /// `value` as [`write_json`](Self::write_json) writes it.
    ///
    /// # Errors
    /// [`Failure::Write`].
    pub fn json_of(&self, value: &impl Serialize) -> Result<Vec<u8>, Failure> {
        let mut text =
            serde_json::to_vec_pretty(value).map_err(|error| self.failed(error.into()))?;
        text.push(b'\n');
        Ok(text)
    }

    /// Writes the page of `report`.
    ///
    /// # Errors
    /// [`Failure::Write`]; a file is then as it was.
    pub fn write_report(&self, report: &Report) -> Result<(), Failure> {
        self.write(report.render().as_bytes())
    }

    /// The failure to write here.
    #[must_use]
    pub fn failed(&self, source: io::Error) -> Failure {
        Failure::Write {
            target: self.clone(),
            source,
        }
    }
}

/// An output being written. Dropped before [`commit`](Self::commit), a file is as it was before.
#[derive(Debug)]
pub enum Output {
    /// The standard output, written at once.
    Stdout(StdoutLock<'static>),
    /// A device or named pipe, written at once.
    Device(File),
    /// A file that appears on commit.
    File(AtomicFile),
}

impl Output {
    /// Brings everything to its place.
    ///
    /// # Errors
    /// The system's.
    pub fn commit(self) -> io::Result<()> {
        match self {
            Self::Stdout(mut out) => out.flush(),
            Self::Device(mut out) => out.flush(),
            Self::File(out) => out.commit(),
        }
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Stdout(out) => out.write(bytes),
            Self::Device(out) => out.write(bytes),
            Self::File(out) => out.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Stdout(out) => out.flush(),
            Self::Device(out) => out.flush(),
            Self::File(out) => out.flush(),
        }
    }
}

/// The option of a command that can give its result as JSON.
#[derive(Clone, Debug, Args)]
pub struct JsonArg {
    /// Write the result as JSON; '-' prints it in place of the text
    #[arg(long, value_name = "PATH", help_heading = "Results")]
    pub json: Option<Target>,
}

impl JsonArg {
    /// Writes `value` where the option says, and `text` to stdout unless the JSON went there.
    ///
    /// # Errors
    /// [`Failure::Write`].
    pub fn write(&self, value: &impl Serialize, text: &Facts) -> Result<(), Failure> {
        self.write_beside(&[], value, text)
    }

    /// The same beside other outputs: where one of them is stdout, nothing else may go there.
    ///
    /// # Errors
    /// [`Failure::Write`].
    pub fn write_beside(
        &self,
        others: &[Option<&Target>],
        value: &impl Serialize,
        text: &Facts,
    ) -> Result<(), Failure> {
        if let Some(target) = &self.json {
            target.write_json(value)?;
        }
        let mut outputs = others.iter().copied().chain([self.json.as_ref()]);
        if outputs.any(|output| output == Some(&Target::Stdout)) {
            return Ok(());
        }
        Target::Stdout.write(text.to_string().as_bytes())
    }
}

/// The option of a command that can write a report.
#[derive(Clone, Debug, Args)]
pub struct ReportArg {
    /// Write a report with plots, one HTML file that needs nothing else; '-' prints it in place of the text
    #[arg(long, value_name = "PATH", help_heading = "Results")]
    pub report: Option<Target>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_through_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, "old").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        let target = Target::File(link.clone());
        let mut output = target.create().unwrap();
        output.write_all(b"half").unwrap();
        drop(output);
        assert_eq!(fs::read(&file).unwrap(), b"old");
        target.write(b"new").unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert!(link.is_symlink());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[test]
    fn a_device_stays_a_device() {
        Target::File("/dev/null".into()).write(b"gone").unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}

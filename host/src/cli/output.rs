//! Where results go: files that appear whole or not at all, stdout, JSON, and text for people.

use std::ffi::OsString;
use std::fmt;
use std::fs::{self, File};
use std::io::{self, StdoutLock, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use crate::recording::write::AtomicFile;
use crate::report::{self, Report};

use super::failure::Failure;

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

/// Whether both paths lead to one regular file, through links or not.
/// Refuses outputs of which one would take another's place, or an input's.
///
/// # Errors
/// [`Failure::OverOutput`], [`Failure::OverInput`].
pub fn spare(outputs: &[Option<&Target>], input: &Path) -> Result<(), Failure> {
    distinct(outputs)?;
    let mut files = outputs.iter().flatten();
    files.try_for_each(|target| target.spare(input))
}

fn distinct(outputs: &[Option<&Target>]) -> Result<(), Failure> {
    let files: Vec<_> = outputs.iter().flatten().collect();
    for (index, target) in files.iter().enumerate() {
        let Target::File(path) = target else {
            continue;
        };
        let taken = files[..index].iter().any(|other| match other {
            Target::File(other) => (other == path || same_file(other, path)) && !is_device(path),
            Target::Stdout => false,
        });
        if taken {
            return Err(Failure::OverOutput {
                target: (**target).clone(),
            });
        }
    }
    Ok(())
}

/// Whether there is something that is no regular file, such as /dev/null, which may be written by all.
fn is_device(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir())
}

fn same_file(a: &Path, b: &Path) -> bool {
    match (fs::canonicalize(a), fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b && a.is_file(),
        _ => false,
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
        if let Some(target) = &self.json {
            target.write_json(value)?;
        }
        if self.json == Some(Target::Stdout) {
            return Ok(());
        }
        Target::Stdout.write(text.to_string().as_bytes())
    }
}

/// The option of a command that can write a report.
#[derive(Clone, Debug, Args)]
pub struct ReportArg {
    /// Write a report with plots, one HTML file that needs nothing else
    #[arg(long, value_name = "PATH", help_heading = "Results")]
    pub report: Option<Target>,
}

/// Named results, one a line, the values in one column.
#[derive(Clone, Debug, Default)]
pub struct Facts(Vec<(String, String)>);

impl Facts {
    /// Adds a line.
    pub fn push(&mut self, name: impl Into<String>, value: impl fmt::Display) -> &mut Self {
        // Text copied from a terminal should hold plain spaces, and a value must stay on its line.
        let value = value.to_string().replace(['\u{a0}', '\u{202f}'], " ");
        self.0
            .push((name.into(), value.replace(char::is_control, "?")));
        self
    }

    /// Adds the lines of `other`.
    pub fn append(&mut self, mut other: Self) -> &mut Self {
        self.0.append(&mut other.0);
        self
    }

    /// Adds a line with a value in SI units, three digits.
    pub fn push_si(&mut self, name: impl Into<String>, value: f64, unit: &str) -> &mut Self {
        self.push(name, report::si(value, unit))
    }
}

impl fmt::Display for Facts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = self.0.iter().map(|(name, _)| name.chars().count());
        let width = names.max().unwrap_or(0);
        self.0
            .iter()
            .try_for_each(|(name, value)| writeln!(f, "{name:width$}  {value}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_stand_in_one_column_and_on_one_line() {
        let mut facts = Facts::default();
        facts.push("µ", "a\nb").push_si("Clock", 8.4e7, "Hz");
        assert_eq!(facts.to_string(), "µ      a?b\nClock  84.0 MHz\n");
    }

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

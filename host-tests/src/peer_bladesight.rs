//! The Python package bladesight, in an environment of its own, on the same edge times.

use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus};

use thiserror::Error;

/// Precision of the likelihood that the paper and the package's own top-level function use.
pub const PUBLISHED_BETA: f64 = 1e10;
/// Its companion.
pub const PUBLISHED_SIGMA: f64 = 0.01;

const REQUIREMENTS: &str = include_str!("../peer/requirements.txt");
const DRIVER: &str = include_str!("../peer/bladesight_geometry.py");

/// Why the package gave nothing.
#[derive(Debug, Error)]
pub enum PeerError {
    /// A program can't be started, or a file can't be read or written.
    #[error("{what}: {source}")]
    Io {
        /// Program or file.
        what: String,
        /// The system's word.
        source: io::Error,
    },
    /// A program failed, maybe for want of memory.
    #[error("{what} ended with {status}")]
    Failed {
        /// The program.
        what: String,
        /// How it ended.
        status: ExitStatus,
    },
    /// Its output is no list of numbers.
    #[error("line {line} of its output is not understood")]
    Output {
        /// Counted from 1.
        line: usize,
    },
}

/// An environment with the package.
#[derive(Clone, Debug)]
pub struct Bladesight {
    folder: PathBuf,
}

/// What one precision gave.
#[derive(Clone, Debug)]
pub struct PeerRun {
    /// Precision of the likelihood.
    pub beta: f64,
    /// Time that the package took, s, without Python's start.
    pub seconds: f64,
    /// Error of every edge, zero mean, rad.
    pub error: Vec<f64>,
}

impl Bladesight {
    /// Sets up the environment in a folder, or takes the one that is there.
    ///
    /// # Errors
    /// [`PeerError`] where Python, its package index or the folder can't be used.
    pub fn install(folder: &Path) -> Result<Self, PeerError> {
        let this = Self {
            folder: folder.to_owned(),
        };
        // Written last: an environment half set up is set up again.
        let requirements = folder.join("requirements.txt");
        if std::fs::read_to_string(&requirements).is_ok_and(|text| text == REQUIREMENTS) {
            return Ok(this);
        }
        run(Command::new("python3").args(["-m", "venv"]).arg(folder))?;
        let pinned = folder.join("pinned.txt");
        write(&pinned, REQUIREMENTS)?;
        run(Command::new(this.python())
            .args(["-m", "pip", "install", "--quiet", "--requirement"])
            .arg(pinned))?;
        write(&requirements, REQUIREMENTS)?;
        Ok(this)
    }

    fn python(&self) -> PathBuf {
        self.folder.join("bin/python")
    }

    /// The errors that the package finds from whole turns of `edges` times and one more, the first of an edge 0, for each precision.
    /// Up to `block` turns are solved at once and the blocks' results averaged.
    ///
    /// # Errors
    /// [`PeerError`], also where the block is too large for the memory.
    pub fn solve(
        &self,
        times: &[u64],
        clock_hz: u64,
        edges: usize,
        block: usize,
        betas: &[f64],
    ) -> Result<Vec<PeerRun>, PeerError> {
        let (input, output) = (
            self.folder.join("times.txt"),
            self.folder.join("errors.csv"),
        );
        let driver = self.folder.join("bladesight_geometry.py");
        let mut text = String::new();
        for ticks in times {
            let _ = writeln!(text, "{ticks}");
        }
        write(&input, &text)?;
        write(&driver, DRIVER)?;
        run(Command::new(self.python())
            .arg(driver)
            .args([&input, &output])
            .args(["--clock-hz", &clock_hz.to_string()])
            .args(["--edges", &edges.to_string()])
            .args(["--block", &block.to_string()])
            .args(["--sigma", &PUBLISHED_SIGMA.to_string()])
            .arg("--beta")
            .args(betas.iter().map(f64::to_string)))?;
        let found = std::fs::read_to_string(&output).map_err(|source| PeerError::Io {
            what: output.display().to_string(),
            source,
        })?;
        let parse = |(at, line): (usize, &str)| {
            let numbers: Option<Vec<f64>> = line.split(',').map(|x| x.parse().ok()).collect();
            match numbers.as_deref() {
                Some([beta, seconds, error @ ..]) if error.len() == edges => Ok(PeerRun {
                    beta: *beta,
                    seconds: *seconds,
                    error: error.to_vec(),
                }),
                _ => Err(PeerError::Output { line: at + 1 }),
            }
        };
        found.lines().enumerate().map(parse).collect()
    }
}

fn run(command: &mut Command) -> Result<(), PeerError> {
    let what = command.get_program().to_string_lossy().into_owned();
    match command.status() {
        Err(source) => Err(PeerError::Io { what, source }),
        Ok(status) if !status.success() => Err(PeerError::Failed { what, status }),
        Ok(_) => Ok(()),
    }
}

fn write(path: &Path, text: &str) -> Result<(), PeerError> {
    std::fs::write(path, text).map_err(|source| PeerError::Io {
        what: path.display().to_string(),
        source,
    })
}

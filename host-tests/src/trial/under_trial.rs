//! Options that say which command is under trial.

use std::env::consts::EXE_SUFFIX;
use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result};
use clap::Args;

use super::run::Quadcal;

/// The command under trial, as the command line of a trial gives it.
#[derive(Clone, Debug, Default, Args)]
pub struct UnderTrial {
    /// The command under trial; else the quadcal that is built beside this one
    #[arg(long, value_name = "PROGRAM")]
    quadcal: Option<PathBuf>,
}

impl UnderTrial {
    /// The command, by an absolute path.
    ///
    /// # Errors
    /// Where there is no such program.
    pub fn quadcal(&self) -> Result<Quadcal> {
        Ok(Quadcal {
            program: self.program()?,
        })
    }

    fn program(&self) -> Result<PathBuf> {
        if let Some(path) = &self.quadcal {
            return fs::canonicalize(path).with_context(|| path.display().to_string());
        }
        let own = std::env::current_exe()?;
        ["quadcal", "quadcal-under-test"]
            .map(|name| own.with_file_name(format!("{name}{EXE_SUFFIX}")))
            .into_iter()
            .find(|path| path.is_file())
            .with_context(|| {
                format!(
                    "no quadcal beside {}: build it first (cargo build --release), or give --quadcal",
                    own.display()
                )
            })
    }
}

//! What a trial is done on.

use std::path::{Path, PathBuf};

use quadcal_host::twin::Twin;
use tempfile::TempDir;

use super::TrialError;
use super::drive::{self, CLOCK_HZ, Drive, FLASH, LINES};
use super::error::io;
use super::shaft::Shaft;

/// A shaft that turns, a drive that sees its edges, and a folder for flash, edges and port.
pub struct Bench {
    elf: PathBuf,
    folder: TempDir,
    shaft: Shaft,
    /// The drive.
    pub drive: Drive,
    boots: u32,
}

impl Bench {
    /// With a drive whose flash is empty.
    ///
    /// # Errors
    /// [`TrialError`].
    pub fn start(twin: &Twin) -> Result<Self, TrialError> {
        let elf = drive::build()?;
        let folder = tempfile::tempdir().map_err(io("making a folder"))?;
        let shaft = Shaft::start(twin, LINES, CLOCK_HZ)?;
        let edges = "edges-1.qcev";
        shaft
            .write_to(&folder.path().join(edges))
            .map_err(io("writing edges"))?;
        let drive = Drive::start(&elf, folder.path(), Some(edges))?;
        Ok(Self {
            elf,
            folder,
            shaft,
            drive,
            boots: 1,
        })
    }

    /// Cuts the power, and switches on again; the shaft turns on. What had been logged.
    ///
    /// # Errors
    /// [`TrialError`].
    pub fn reboot(&mut self) -> Result<String, TrialError> {
        let log = self.drive.cut_power()?;
        let edges = |boot: u32| format!("edges-{boot}.qcev");
        let _ = std::fs::remove_file(self.folder.path().join(edges(self.boots)));
        self.boots += 1;
        let edges = edges(self.boots);
        self.shaft
            .write_to(&self.folder.path().join(&edges))
            .map_err(io("writing edges"))?;
        self.drive = Drive::start(&self.elf, self.folder.path(), Some(&edges))?;
        Ok(log)
    }

    /// Where flash and edges are.
    #[must_use]
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// The drive's flash.
    #[must_use]
    pub fn flash(&self) -> PathBuf {
        self.folder().join(FLASH)
    }
}

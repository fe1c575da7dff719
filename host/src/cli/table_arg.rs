//! The option that names an error table, and the way to what it holds.

use std::fmt;
use std::path::{Path, PathBuf};

use clap::Args;
use quadcal::slot::Slot;

use crate::table_file;

use super::failure::Failure;

/// The option of a command that uses an error table.
#[derive(Clone, Debug, Args)]
pub(super) struct TableArg {
    /// Error table, as quadcal calibrate wrote it
    #[arg(long = "table", value_name = "TABLE")]
    path: PathBuf,
}

impl TableArg {
    /// The table's file.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The bytes of the table's file, for [`parse`](Self::parse).
    ///
    /// # Errors
    /// [`Failure::Open`].
    pub(super) fn read(&self) -> Result<Vec<u8>, Failure> {
        table_file::read(&self.path).map_err(|source| Failure::Open {
            path: self.path.clone(),
            source,
        })
    }

    /// The table in the bytes of its file, marked with what it learned from the recording with the check sum `source`.
    ///
    /// # Errors
    /// [`Failure::Table`].
    pub(super) fn parse<'a>(&self, bytes: &'a [u8], source: u32) -> Result<Slot<'a>, Failure> {
        let parsed = table_file::parse(bytes);
        let slot = parsed.map_err(|fault| Failure::Table {
            table: self.path.clone(),
            fault,
        })?;
        Ok(table_file::marked(slot, bytes, source))
    }
}

impl fmt::Display for TableArg {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.path.display().fmt(f)
    }
}

//! Files that appear whole or not at all.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

/// A file that appears under its name only when it is complete: it is written beside its target and takes its place on
/// [`commit`](Self::commit). Dropped before that it is removed and the target is left as it was.
#[derive(Debug)]
pub struct AtomicFile {
    file: NamedTempFile,
    target: PathBuf,
}

impl AtomicFile {
    /// Starts a file that is to become `target`.
    ///
    /// # Errors
    /// Where the folder of `target` does not exist or cannot be written.
    pub fn create(target: &Path) -> io::Result<Self> {
        let mut why = None;
        let made =
            Builder::new()
                .prefix(".quadcal-")
                .suffix(".part")
                .make_in(folder(target), |path| {
                    let made = File::options().write(true).create_new(true).open(path);
                    made.inspect_err(|error| why = error.raw_os_error())
                });
        // The library's error names the file beside the target, which nobody asked for.
        let plain = |error| why.map_or(error, io::Error::from_raw_os_error);
        Ok(Self {
            file: made.map_err(plain)?,
            target: target.to_owned(),
        })
    }

    /// Brings the content to the disk and puts the file in its target's place.
    ///
    /// # Errors
    /// Where that fails; the target is then left as it was.
    pub fn commit(self) -> io::Result<()> {
        let Self { file, target } = self;
        file.as_file().sync_all()?;
        file.persist(&target)?;
        // The new name is on the disk once its folder is.
        #[cfg(unix)]
        File::open(folder(&target))?.sync_all()?;
        Ok(())
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.as_file_mut().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_file_mut().flush()
    }
}

fn folder(target: &Path) -> &Path {
    match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

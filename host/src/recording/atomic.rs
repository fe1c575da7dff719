//! Files that appear whole or not at all.

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
        let mut builder = Builder::new();
        builder.prefix(".quadcal-").suffix(".part");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // As for any new file; the umask takes its share.
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        Ok(Self {
            file: builder.tempfile_in(folder(target))?,
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
        std::fs::File::open(folder(&target))?.sync_all()?;
        Ok(())
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

fn folder(target: &Path) -> &Path {
    match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

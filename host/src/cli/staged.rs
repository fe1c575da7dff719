//! Several files that appear together: each is written beside its name before the first takes it.

use std::io::Write as _;

use super::failure::Failure;
use super::output::{Output, Target};

/// Files that are written, not yet in their places. Dropped, they leave nothing.
#[derive(Debug, Default)]
pub(super) struct Staged(Vec<(Target, Output)>);

impl Staged {
    /// Writes a file beside its place.
    ///
    /// # Errors
    /// [`Failure::Write`].
    pub(super) fn add(&mut self, target: Target, bytes: &[u8]) -> Result<(), Failure> {
        let mut output = target.create()?;
        output
            .write_all(bytes)
            .map_err(|source| target.failed(source))?;
        self.0.push((target, output));
        Ok(())
    }

    /// Brings all to their places.
    ///
    /// # Errors
    /// [`Failure::Write`].
    pub(super) fn commit(self) -> Result<(), Failure> {
        self.0.into_iter().try_for_each(|(target, output)| {
            let committed = output.commit();
            committed.map_err(|source| target.failed(source))
        })
    }
}

//! Results kept apart: no two in one place, none in the place of what was read.

use std::fs;
use std::path::{Path, PathBuf};

use super::Target;
use crate::cli::failure::Failure;

/// Refuses outputs of which one would take another's place, or an input's, and two on one standard output.
///
/// # Errors
/// [`Failure::OverOutput`], [`Failure::OverInput`].
pub fn spare(outputs: &[Option<&Target>], input: &Path) -> Result<(), Failure> {
    distinct(outputs)?;
    let mut files = outputs.iter().flatten();
    files.try_for_each(|target| target.spare(input))
}

fn distinct(outputs: &[Option<&Target>]) -> Result<(), Failure> {
    let targets: Vec<_> = outputs.iter().flatten().collect();
    for (index, target) in targets.iter().enumerate() {
        let taken = targets[..index].iter().any(|other| match (target, other) {
            (Target::Stdout, Target::Stdout) => true,
            (Target::File(path), Target::File(other)) => same_name(other, path),
            _ => false,
        });
        if taken {
            return Err(Failure::OverOutput {
                target: (**target).clone(),
            });
        }
    }
    Ok(())
}

/// Whether both names are of one file, which need not be there yet.
fn same_name(a: &Path, b: &Path) -> bool {
    (a == b || same_file(a, b) || place(a).is_some_and(|place_a| Some(place_a) == place(b)))
        && !is_device(b)
}

/// A file's folder, links resolved, with its name; none where there is no such folder.
fn place(path: &Path) -> Option<PathBuf> {
    let folder = path.parent().filter(|folder| *folder != Path::new(""));
    let folder = fs::canonicalize(folder.unwrap_or(Path::new("."))).ok()?;
    Some(folder.join(path.file_name()?))
}

/// Whether there is something that is no regular file, such as /dev/null, which may be written by all.
fn is_device(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir())
}

/// Whether both paths lead to one regular file, through links or not.
pub(super) fn same_file(a: &Path, b: &Path) -> bool {
    match (fs::canonicalize(a), fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b && a.is_file(),
        _ => false,
    }
}

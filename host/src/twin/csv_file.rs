//! CSV files that a twin names.

use std::fs::File;
use std::path::Path;

use super::TwinError;

/// Most bytes of such a file.
const BYTES_MAX: u64 = 256 << 20;

/// Opens a file with a header line, if it is one: a pipe or a device may have no end.
///
/// # Errors
/// [`TwinError::CsvFile`].
pub(crate) fn open(path: &Path) -> Result<csv::Reader<File>, TwinError> {
    let unusable = |why: String| TwinError::CsvFile {
        path: path.to_owned(),
        why,
    };
    let found = std::fs::metadata(path)
        .map_err(|e| unusable(format!("can't read it: {e}; check the path in the twin")))?;
    if !found.is_file() {
        return Err(unusable("not a file; name a CSV file in the twin".into()));
    }
    if found.len() > BYTES_MAX {
        let (has, most) = (found.len() >> 20, BYTES_MAX >> 20);
        return Err(unusable(format!(
            "{has} MiB, up to {most} MiB are read; leave out what the twin does not need"
        )));
    }
    let file = File::open(path).map_err(|e| unusable(format!("can't read it: {e}")))?;
    Ok(csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_reader(file))
}

//! What every report says of its origin.

use std::path::Path;

use crate::report::{Footer, InputFile};

use super::failure::Failure;

/// Where a report comes from: this version, the command line, and the `inputs`.
///
/// # Errors
/// [`Failure::Open`] for an input that can't be read.
pub fn footer(inputs: &[&Path]) -> Result<Footer, Failure> {
    let read = |path: &&Path| {
        InputFile::read(path).map_err(|source| Failure::Open {
            path: path.to_path_buf(),
            source,
        })
    };
    let words = std::env::args_os().skip(1);
    let words = words.map(|word| word.to_string_lossy().into_owned());
    Ok(Footer {
        version: format!("quadcal {}", env!("CARGO_PKG_VERSION")),
        command: std::iter::once("quadcal".to_owned())
            .chain(words)
            .collect::<Vec<_>>()
            .join(" "),
        inputs: inputs.iter().map(read).collect::<Result<_, _>>()?,
    })
}

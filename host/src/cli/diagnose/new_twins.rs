//! The twins with the findings in them, as files.
//!
//! The first recording's twin takes the name that was given (`new.toml`), the others a number (`new-2.toml`); where all came out the same,
//! as one twin was given for all, there is one file. A disc that was learned edge by edge goes beside its twin
//! (`new.errors.csv`).

use std::ffi::OsString;
use std::fmt::Write as _;
use std::fs;
use std::path::{Component, Path, PathBuf};

use crate::cli::failure::Failure;
use crate::diagnose::diagnosis::{Diagnosis, LearnedDisc};
use crate::twin::{ErrorListFault, Errors, Twin, TwinError, edited};

/// A diagnosis with the twins that it makes.
pub(super) struct Diagnosed {
    pub(super) diagnosis: Diagnosis,
    /// The twins with the findings in them, one for each recording.
    pub(super) twins: Vec<Twin>,
    /// For each recording the whole disc, if that was learned edge by edge.
    pub(super) discs: Vec<Option<LearnedDisc>>,
}

/// A file to be written.
pub(super) struct NewFile {
    pub(super) path: PathBuf,
    pub(super) text: String,
}

/// Every name that the twins of so many recordings may take.
pub(super) fn names(first: &Path, recordings: usize) -> Vec<PathBuf> {
    let twins = (0..recordings).map(|index| numbered(first, index));
    twins
        .flat_map(|twin| [list_name(&twin), twin])
        .collect::<Vec<_>>()
}

/// The files of a diagnosis, the first recording's twin going to `first`. `declared` are texts and twins as they were given, one for
/// each recording or one for all.
///
/// # Errors
/// A twin that can't be written, or a list of errors that does not fit its encoder.
pub(super) fn files(
    first: &Path,
    diagnosed: &Diagnosed,
    declared: &[(String, Twin)],
) -> Result<Vec<NewFile>, Failure> {
    let list = |index: usize| diagnosed.discs.get(index).and_then(Option::as_ref);
    let twins = &diagnosed.twins;
    let alike = (1..twins.len()).all(|index| twins[index] == twins[0] && list(index) == list(0));
    let count = if alike { 1 } else { twins.len() };
    let mut files = Vec::new();
    for (index, twin) in twins.iter().take(count).enumerate() {
        let path = numbered(first, index);
        let mut twin = twin.clone();
        let folder = twin.folder.clone();
        for csv in twin.csv_paths() {
            *csv = moved(csv, &folder, &path);
        }
        if let Some(disc) = list(index) {
            let list = list_name(&path);
            let text = list_csv(&list, disc, &twin)?;
            twin.errors = Errors {
                csv: list.file_name().map(PathBuf::from),
                wave_standard_errors_rad: disc.spread.rounded_waves_rad(),
                ..Errors::default()
            };
            files.push(NewFile { path: list, text });
        }
        let text = match declared.get(index).or(declared.first()) {
            Some((text, old)) => edited(text, old, &twin)?,
            None => twin.to_toml()?,
        };
        let text = remarks(diagnosed, index) + &text;
        files.push(NewFile { path, text });
    }
    Ok(files)
}

/// `new.toml`, `new-2.toml`, ..
fn numbered(first: &Path, index: usize) -> PathBuf {
    if index == 0 {
        return first.to_owned();
    }
    let mut name = first.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{}", index + 1));
    if let Some(extension) = first.extension() {
        name.push(".");
        name.push(extension);
    }
    first.with_file_name(name)
}

fn list_name(twin: &Path) -> PathBuf {
    let mut name: OsString = twin.file_stem().unwrap_or_default().to_owned();
    name.push(".errors.csv");
    twin.with_file_name(name)
}

/// Errors of every edge of the grid as a twin reads them. Of a wheel recorded with one edge of each tooth the other goes along.
fn list_csv(path: &Path, disc: &LearnedDisc, twin: &Twin) -> Result<String, TwinError> {
    let errors_rad = &disc.errors_rad;
    let edges = twin.encoder.grid_edges();
    let each = if 2 * errors_rad.len() == edges as usize {
        2
    } else {
        1
    };
    let values = errors_rad.iter().flat_map(|e| vec![*e; each]);
    let error = disc.spread.edge_rad;
    let mut text = "k,e_rad,standard_error_rad\n".to_owned();
    let mut given = 0;
    for (k, value) in (0_u32..).zip(values) {
        // Writing to a string never fails.
        let _ = writeln!(text, "{k},{value:e},{error:.3e}");
        given = k + 1;
    }
    let fault = match given {
        _ if given < edges => ErrorListFault::Missing(given),
        _ if given > edges => ErrorListFault::OutOfGrid {
            k: edges,
            last: edges - 1,
        },
        _ => return Ok(text),
    };
    Err(TwinError::ErrorList {
        path: path.to_owned(),
        line: u64::from(given) + 1,
        fault,
    })
}

/// What a twin's file says of its origin.
fn remarks(diagnosed: &Diagnosed, index: usize) -> String {
    let plain = |text: &str| text.replace(char::is_control, "?");
    let diagnosis = &diagnosed.diagnosis;
    let mut text = String::new();
    if let Some(facts) = diagnosis.recordings.get(index) {
        let (twin, file) = (plain(&facts.twin), plain(&facts.file));
        let _ = match diagnosis.findings.is_empty() {
            true => writeln!(
                text,
                "# {twin}, in which 'quadcal diagnose' found nothing missing on {file}."
            ),
            false => writeln!(
                text,
                "# {twin} with what 'quadcal diagnose' found missing on {file}."
            ),
        };
    }
    for finding in &diagnosis.findings {
        let what = plain(&finding.text);
        let _ = writeln!(text, "# {}: {what}", finding.mechanism);
    }
    text
}

/// A list's path, relative to the old twin's folder, as the new twin finds it.
fn moved(csv: &Path, old_folder: &Path, new_twin: &Path) -> PathBuf {
    let here = |folder: &Path| match folder.as_os_str().is_empty() {
        true => PathBuf::from("."),
        false => folder.to_owned(),
    };
    let new_folder = new_twin.parent().unwrap_or(Path::new(""));
    let folders = fs::canonicalize(here(old_folder)).and_then(|old| {
        let new = fs::canonicalize(here(new_folder))?;
        Ok((old, new))
    });
    match folders {
        _ if csv.is_absolute() => csv.to_owned(),
        Ok((old, new)) if old == new => csv.to_owned(),
        Ok((old, new)) => relative(&new, &old).join(csv),
        // Without its folder the twin won't be written at all.
        Err(_) => old_folder.join(csv),
    }
}

/// The way from one folder to another, both from the root, links resolved.
fn relative(from: &Path, to: &Path) -> PathBuf {
    let from: Vec<Component<'_>> = from.components().collect();
    let to_parts: Vec<Component<'_>> = to.components().collect();
    let shared = from.iter().zip(&to_parts).take_while(|(a, b)| a == b);
    let shared = shared.count();
    if shared == 0 {
        // Another drive.
        return to.to_owned();
    }
    let up = from[shared..].iter().map(|_| Component::ParentDir);
    up.chain(to_parts[shared..].iter().copied()).collect()
}

#[cfg(test)]
mod tests;

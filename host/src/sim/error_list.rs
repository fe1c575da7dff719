//! Reads the CSV list of an encoder's errors that a twin may name.

use std::path::Path;

use serde::Deserialize;

use crate::twin::{ErrorListFault, TwinError};

#[derive(Deserialize)]
struct Entry {
    k: u32,
    e_rad: f64,
}

/// e(k) of every edge of the grid, rad.
pub(super) fn read(path: &Path, edges: u32) -> Result<Vec<f64>, TwinError> {
    let fault = |line: u64, fault: ErrorListFault| TwinError::ErrorList {
        path: path.to_owned(),
        line,
        fault,
    };
    let line_of = |e: &csv::Error| e.position().map_or(1, csv::Position::line);
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_path(path)
        .map_err(|e| fault(1, e.into()))?;
    let headers = reader
        .headers()
        .map_err(|e| fault(line_of(&e), e.into()))?
        .clone();
    let mut found: Vec<Option<f64>> = vec![None; edges as usize];
    let mut record = csv::StringRecord::new();
    let mut line = 1;
    while reader
        .read_record(&mut record)
        .map_err(|e| fault(line_of(&e), e.into()))?
    {
        line = record.position().map_or(line, csv::Position::line);
        let entry: Entry = record
            .deserialize(Some(&headers))
            .map_err(|e| fault(line, e.into()))?;
        let Some(slot) = found.get_mut(entry.k as usize) else {
            let last = edges - 1;
            return Err(fault(line, ErrorListFault::OutOfGrid { k: entry.k, last }));
        };
        if slot.is_some() {
            return Err(fault(line, ErrorListFault::Twice(entry.k)));
        }
        if !entry.e_rad.is_finite() {
            return Err(fault(line, ErrorListFault::NotFinite(entry.e_rad)));
        }
        *slot = Some(entry.e_rad);
    }
    (0..edges)
        .zip(found)
        .map(|(k, e)| e.ok_or_else(|| fault(line, ErrorListFault::Missing(k))))
        .collect()
}

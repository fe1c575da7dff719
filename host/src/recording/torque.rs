//! The torque column of a native CSV.
//!
//! A row says which torque is asked for from its time on. Rows that repeat the levels above them are no edges and may be written at each
//! change of torque: then the times are exact. Where only edges have rows, a change lies somewhere between two of them.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use quadcal::edge::Levels;

use super::columns::Fields;
use super::error::ReadError;
use super::lines::Lines;
use super::native::Native;
use super::options::ReadOptions;
use super::place::{Place, quote};
use crate::free_run::torque::TorqueStep;

/// Reads the torque of the native CSV at `path`, in N m, from the column of this name.
///
/// # Errors
/// As [`open`](super::open); [`ReadError::MissingTorque`] without such a column, [`ReadError::BadTorque`] for a field that is no number.
pub fn open(
    path: &Path,
    column: &str,
    options: &ReadOptions,
) -> Result<Vec<TorqueStep>, ReadError> {
    let name: Arc<str> = path.display().to_string().into();
    let file = File::open(path).map_err(|source| ReadError::Io {
        at: Place::file(&name),
        source,
    })?;
    from_reader(file, &name, column, options)
}

/// As [`open`], from `reader`; `name` stands for the file in messages.
///
/// # Errors
/// As [`open`].
pub fn from_reader(
    reader: impl Read + Send + 'static,
    name: &str,
    column: &str,
    options: &ReadOptions,
) -> Result<Vec<TorqueStep>, ReadError> {
    let file: Arc<str> = name.into();
    let lines = Lines::new(Box::new(reader), &file);
    let (mut native, _) = Native::open(lines, options)?;
    let place = native.torque_column(column)?;
    let mut steps: Vec<TorqueStep> = Vec::new();
    let mut last: Option<(u64, Levels)> = None;
    while let Some((row, torque_n_m)) =
        native.next_with(|line| field(line, place, &file, column))?
    {
        let changed = steps
            .last()
            .is_none_or(|step| step.torque_n_m != torque_n_m);
        if changed {
            let after = match last {
                Some((before, levels)) if levels != row.levels => before,
                _ => row.ticks,
            };
            steps.push(TorqueStep {
                after,
                from: row.ticks,
                torque_n_m,
            });
        }
        last = Some((row.ticks, row.levels));
    }
    Ok(steps)
}

/// The number in a field of a line.
fn field(
    line: &super::lines::Line<'_>,
    place: (usize, u8),
    file: &Arc<str>,
    column: &str,
) -> Result<f64, ReadError> {
    let text = Fields::new(line.bytes, place.1)
        .nth(place.0)
        .unwrap_or_default();
    std::str::from_utf8(text)
        .ok()
        .and_then(|text| text.parse().ok())
        .filter(|torque: &f64| torque.is_finite())
        .ok_or_else(|| ReadError::BadTorque {
            at: Place::named(file, line.number, column),
            text: quote(text),
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "# clock_hz = 1000\nticks,a,b,torque_n_m\n";

    fn read(rows: &str, column: &str) -> Result<Vec<TorqueStep>, ReadError> {
        let text = format!("{HEAD}{rows}");
        from_reader(
            std::io::Cursor::new(text.into_bytes()),
            "x.csv",
            column,
            &ReadOptions::default(),
        )
    }

    fn step(after: u64, from: u64, torque_n_m: f64) -> TorqueStep {
        TorqueStep {
            after,
            from,
            torque_n_m,
        }
    }

    #[test]
    fn a_change_is_at_its_own_row_or_between_two_edges() {
        let rows = "10,1,0,0.5\n20,1,1,0.5\n25,1,1,-1e-3\n30,0,1,-0.001\n40,0,0,2\n";
        assert_eq!(
            read(rows, "Torque_N_m").unwrap(),
            [step(10, 10, 0.5), step(25, 25, -1e-3), step(30, 40, 2.0)]
        );
    }

    #[test]
    fn a_missing_column_and_a_field_that_is_no_number_are_named() {
        let missing = read("10,1,0,0.5\n", "current").unwrap_err().to_string();
        assert!(missing.starts_with("x.csv:2"), "{missing}");
        assert!(missing.contains("torque_n_m"), "{missing}");
        for bad in ["", "x", "nan"] {
            let error = read(&format!("10,1,0,{bad}\n"), "torque_n_m")
                .unwrap_err()
                .to_string();
            assert!(error.starts_with("x.csv:3"), "{error}");
        }
    }
}

//! Behaviour of the readers and writers together.

mod bad_input;
mod formats;
mod never_panics;
mod round_trip;

use std::io::Cursor;

use super::{ReadError, ReadOptions, Recording, Row, from_reader};

/// Opens bytes as a file of this name.
fn open_bytes(name: &str, bytes: &[u8], options: &ReadOptions) -> Result<Recording, ReadError> {
    from_reader(Cursor::new(bytes.to_vec()), name, options)
}

/// All rows as (ticks, levels).
fn rows(name: &str, text: &str, options: &ReadOptions) -> Result<Vec<(u64, u8)>, ReadError> {
    open_bytes(name, text.as_bytes(), options)?
        .map(|row| row.map(|Row { ticks, levels }| (ticks, levels.0)))
        .collect()
}

/// Options with these mappings.
fn mapped(map: &[&str]) -> ReadOptions {
    ReadOptions {
        map: map.iter().map(|text| text.parse().unwrap()).collect(),
        ..ReadOptions::default()
    }
}

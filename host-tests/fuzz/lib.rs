//! What every fuzz target asks of a reader.
//!
//! `cargo install cargo-fuzz`, then in `host-tests`: `cargo +nightly fuzz run read_native fuzz/corpus/read_native
//! fuzz/seeds/read_native`, and likewise `read_logic`, `read_vcd`, `read_list`, `read_any` and `device`. What is found goes to `corpus`, which
//! is not kept in the repository; `seeds` is.
#![forbid(unsafe_code)]

use std::io::Cursor;

use quadcal_host::recording::{Channels, Format, ListKind, ReadOptions, from_reader};

/// Reads `bytes` to the end and checks what a recording promises: times never fall, levels change, nothing follows an error, and
/// errors are one line.
///
/// # Panics
/// Where a promise is broken.
pub fn read(bytes: &[u8], format: Option<Format>, list: ListKind) {
    let options = ReadOptions {
        format,
        list,
        ..ReadOptions::default()
    };
    let mut recording = match from_reader(Cursor::new(bytes.to_vec()), "fuzz", &options) {
        Ok(recording) => recording,
        Err(error) => return assert!(!error.to_string().contains('\n')),
    };
    let pulses = recording.header.channels == Channels::Pulses;
    let mut last = None;
    while let Some(row) = recording.next() {
        match row {
            Ok(row) => {
                if let Some((ticks, levels)) = last.replace((row.ticks, row.levels)) {
                    assert!(row.ticks >= ticks);
                    assert!(pulses || row.levels != levels);
                }
            }
            Err(error) => {
                assert!(!error.to_string().contains('\n'));
                assert!(recording.next().is_none());
            }
        }
    }
}

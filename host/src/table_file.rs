//! Error tables as files: the bytes of one flash slot, and a CSV for people.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use crc::{CRC_32_ISO_HDLC, Crc};
use quadcal::shape::EDGES_MAX;
use quadcal::slot::{self, HEADER_BYTES, Slot, SlotError, SlotHeader, VERSION};

use crate::calibrate::Calibration;
use crate::findings::Findings;

/// Bytes of a recording that its check sum covers.
const SOURCE_BYTES: u64 = 64 * 1024;

/// More bytes than any table has, without the marks behind it.
pub(crate) const SLOT_BYTES_MAX: u32 = HEADER_BYTES as u32 + 2 * EDGES_MAX + 8;

/// First bytes of the marks of further recordings, which a file has behind the slot; flash does without them.
const MARKS_MAGIC: [u8; 4] = *b"QCTM";

/// Bytes of a mark: the recording's check sum, and the last tick learned from.
const MARK_BYTES: usize = 12;

/// Most marks that are kept.
const MARKS_MOST: usize = 1024;

/// More bytes than any file of a table has.
const TABLE_BYTES_MAX: u64 = SLOT_BYTES_MAX as u64 + (8 + MARKS_MOST * MARK_BYTES) as u64;

/// Check sum by which a table knows the recording that it was learned from: CRC-32 of the first 64 KiB. Never 0.
///
/// # Errors
/// Whatever opening or reading says.
pub fn source_of(path: &Path) -> io::Result<u32> {
    let mut start = Vec::new();
    File::open(path)?
        .take(SOURCE_BYTES)
        .read_to_end(&mut start)?;
    Ok(source_of_bytes(&start))
}

/// As [`source_of`], of a recording in memory.
#[must_use]
pub fn source_of_bytes(recording: &[u8]) -> u32 {
    let covered = recording.len().min(SOURCE_BYTES as usize);
    let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC);
    crc.checksum(&recording[..covered]).max(1)
}

/// The slot bytes of a calibration on the recording with check sum `source`.
#[must_use]
pub fn bytes_of(calibration: &Calibration, source: u32) -> Vec<u8> {
    bytes_with(calibration, &calibration.slot_header(source))
}

/// The slot bytes of a calibration's entries under `header`.
#[must_use]
pub fn bytes_with(calibration: &Calibration, header: &SlotHeader) -> Vec<u8> {
    let mut bytes = Vec::new();
    let entries = calibration.solution.entries();
    let Ok(()) = slot::write(header, entries, |piece| {
        bytes.extend_from_slice(piece);
        Ok::<(), std::convert::Infallible>(())
    });
    bytes
}

/// What a file holds behind the slot where a table was learned from several recordings: which of their turns were learned from, as the
/// slot has room for the first one's mark. `marks` are the check sums of all recordings and the last ticks learned from; nothing
/// for a single one.
///
/// ```text
/// offset  size  field, little-endian
///      0     4  magic "QCTM"
///      4     4  number of marks
///      8   12n  marks: check sum of a recording's start (4), last tick learned from (8)
/// ```
#[must_use]
pub fn marks_of(marks: &[(u32, u64)]) -> Vec<u8> {
    if marks.len() < 2 {
        return Vec::new();
    }
    let kept = &marks[..marks.len().min(MARKS_MOST)];
    let mut bytes = MARKS_MAGIC.to_vec();
    #[allow(clippy::cast_possible_truncation)]
    bytes.extend_from_slice(&(kept.len() as u32).to_le_bytes());
    for (source, learned_until) in kept {
        bytes.extend_from_slice(&source.to_le_bytes());
        bytes.extend_from_slice(&learned_until.to_le_bytes());
    }
    bytes
}

/// The `slot` of a file's `bytes` as a check of the recording `source` needs it: with that recording's mark, if the table was learned from it.
#[must_use]
pub fn marked<'a>(slot: Slot<'a>, bytes: &[u8], source: u32) -> Slot<'a> {
    let behind = bytes.get(slot::slot_bytes(slot.header.shape)..);
    let behind = behind.filter(|behind| behind.starts_with(&MARKS_MAGIC));
    let marks = behind
        .and_then(|behind| behind.get(8..))
        .unwrap_or_default();
    let marks = marks.as_chunks::<MARK_BYTES>().0;
    let found = marks.iter().find(|mark| mark[..4] == source.to_le_bytes());
    let Some(&[_, _, _, _, ref tick @ ..]) = found else {
        return slot;
    };
    let mut slot = slot;
    slot.header.source = source;
    slot.header.learned_until = u64::from_le_bytes(*tick);
    slot
}

/// Reads a table's bytes; of a longer file, no more than a table can have.
///
/// # Errors
/// Whatever opening or reading says.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?
        .take(TABLE_BYTES_MAX)
        .read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The table in `bytes`.
///
/// # Errors
/// [`SlotError`]. A file with another start than a table's is [`SlotError::Magic`], however short it is.
pub fn parse(bytes: &[u8]) -> Result<Slot<'_>, SlotError> {
    match bytes.first_chunk() {
        Some(&magic) if magic != slot::MAGIC => Err(SlotError::Magic(magic)),
        _ => Slot::parse(bytes),
    }
}

/// What is wrong with a table and what to do, in one line.
#[must_use]
pub fn describe(error: &SlotError) -> String {
    const AGAIN: &str = "copy it again or write it again with quadcal calibrate";
    match error {
        SlotError::Truncated { found: 0, .. } => format!("the table is empty; {AGAIN}"),
        SlotError::Truncated { needed, found } => {
            format!("the table is cut off: {found} of {needed} bytes; {AGAIN}")
        }
        SlotError::Magic(_) => {
            "not an error table; give the file that quadcal calibrate wrote with -o".to_owned()
        }
        SlotError::Version(found) => {
            let newer = if *found > VERSION {
                "update quadcal"
            } else {
                "calibrate again"
            };
            format!("the table has format version {found}, this quadcal knows {VERSION}; {newer}")
        }
        SlotError::Shape(_) | SlotError::Table(_) | SlotError::Clock => {
            format!("the table's header is damaged; {AGAIN}")
        }
        SlotError::Crc { stored, computed } => format!(
            "the table is damaged: its check sum is {computed:08x} and should be {stored:08x}; {AGAIN}"
        ),
    }
}

/// The table as CSV: `edge,class,error_rad,standard_error_rad`, one row an edge.
#[must_use]
pub fn csv_of(findings: &Findings) -> String {
    use std::fmt::Write;
    let mut text = "edge,class,error_rad,standard_error_rad\n".to_owned();
    let names = findings.class_names.iter().cycle();
    for ((edge, error), class) in findings.error_rad.iter().enumerate().zip(names) {
        // Writing to a string never fails.
        let _ = writeln!(
            text,
            "{edge},{class},{error:.4e},{:.4e}",
            findings.after_rad
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fault_of_a_table_says_what_to_do() {
        for (bytes, expected) in [
            (&b""[..], "the table is empty; "),
            (b"QC", "the table is cut off: 2 of 68 bytes; "),
            (b"ticks,a,b", "not an error table; "),
        ] {
            let text = describe(&parse(bytes).unwrap_err());
            assert!(text.starts_with(expected), "{text}");
        }
        let mut other = vec![0; 80];
        other[..6].copy_from_slice(b"QCTB\x04\x00");
        let text = describe(&parse(&other).unwrap_err());
        assert!(
            text.contains("version 4") && text.contains("update"),
            "{text}"
        );
    }

    #[test]
    fn the_source_is_that_of_the_first_64_kib() {
        let mut bytes = vec![7; 70_000];
        let source = source_of_bytes(&bytes);
        bytes[69_999] = 0;
        assert_eq!(source, source_of_bytes(&bytes));
        bytes[65_535] = 0;
        assert_ne!(source, source_of_bytes(&bytes));
    }
}

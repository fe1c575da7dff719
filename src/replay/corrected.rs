//! The corrected file: what a session makes of the edges after it has learned.
//!
//! Little endian throughout. One header, one record for every accepted edge, and the fault counts at the end.
//!
//! ```text
//! header, 16 bytes                      record, 32 bytes
//!  0  4  magic "QCCE"                    0  8  time of the edge as captured, ticks
//!  4  2  version, 2                      8  4  corrected angle, 2^-32 turn
//!  6  2  reserved, 0                    12  4  angle moved since the edge before, signed, 2^-32 turn
//!  8  4  lines                          16  4  time since the edge before as captured, ticks
//! 12  4  timer clock in hertz           20  4  how late the edge was captured, signed, 2^-8 tick
//!                                       24  4  how much too long that makes the time, signed, 2^-8 tick
//!                                       28  2  flags, the bits of step::Flags
//!                                       30  2  reserved, 0
//!
//! fault counts, 28 bytes: illegal, lost, extra, glitch, abrupt reversal, interval spike, repeated; 4 bytes each
//! ```
//!
//! Records are written as edges come. Where a glitch withdraws an edge its record stays; the next record's way and time
//! count from the edge before the withdrawn one.

use core::fmt;

use crate::corrector::CorrectedEdge;
use crate::step::{Faults, Flags};
use crate::units::{TickDelta8, Turn32, TurnDelta32};

/// First four bytes of a corrected file.
pub const CORRECTED_MAGIC: [u8; 4] = *b"QCCE";
/// Version of the format.
pub const CORRECTED_VERSION: u16 = 2;
/// Bytes in the header.
pub const CORRECTED_HEADER_LEN: usize = 16;
/// Bytes in one record.
pub const EDGE_LEN: usize = 32;
/// Where a record's reserved bytes are.
const RESERVED_AT: usize = 30;
/// Bytes of the fault counts.
pub const FAULTS_LEN: usize = 28;

/// What the file says of its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CorrectedHeader {
    /// Lines of the disc.
    pub lines: u32,
    /// Timer clock in hertz.
    pub clock_hz: u32,
}

/// A corrected file, checked, in place.
#[derive(Clone, Copy, Debug)]
pub struct CorrectedFile<'a> {
    /// What the file says of its edges.
    pub header: CorrectedHeader,
    /// Faults that the decoder counted, from the start of the event file on.
    pub faults: Faults,
    edges: &'a [[u8; EDGE_LEN]],
}

/// Why bytes are not a corrected file; positions are byte offsets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CorrectedError {
    /// The file does not begin with [`CORRECTED_MAGIC`].
    Magic,
    /// Another version of the format.
    Version(u16),
    /// This many bytes are no header, whole records and fault counts.
    Length(usize),
    /// The reserved bytes at this offset are not 0.
    Reserved(usize),
}

impl fmt::Display for CorrectedError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Magic => f.write_str("not a corrected file"),
            Self::Version(v) => write!(f, "corrected file version {v} is not known"),
            Self::Length(n) => write!(f, "{n} bytes are cut off inside a part of the file"),
            Self::Reserved(at) => write!(f, "byte {at}: reserved bytes are not 0"),
        }
    }
}

impl core::error::Error for CorrectedError {}

impl CorrectedHeader {
    /// The header's bytes.
    #[must_use]
    pub fn emit(&self) -> [u8; CORRECTED_HEADER_LEN] {
        let [v0, v1] = CORRECTED_VERSION.to_le_bytes();
        let [m0, m1, m2, m3] = CORRECTED_MAGIC;
        let [l0, l1, l2, l3] = self.lines.to_le_bytes();
        let [c0, c1, c2, c3] = self.clock_hz.to_le_bytes();
        [m0, m1, m2, m3, v0, v1, 0, 0, l0, l1, l2, l3, c0, c1, c2, c3]
    }

    fn parse(bytes: &[u8; CORRECTED_HEADER_LEN]) -> Result<Self, CorrectedError> {
        let [m0, m1, m2, m3, v0, v1, r0, r1, rest @ ..] = *bytes;
        let [l0, l1, l2, l3, c0, c1, c2, c3] = rest;
        if [m0, m1, m2, m3] != CORRECTED_MAGIC {
            return Err(CorrectedError::Magic);
        }
        match u16::from_le_bytes([v0, v1]) {
            CORRECTED_VERSION => {}
            other => return Err(CorrectedError::Version(other)),
        }
        if [r0, r1] != [0; 2] {
            return Err(CorrectedError::Reserved(6));
        }
        Ok(Self {
            lines: u32::from_le_bytes([l0, l1, l2, l3]),
            clock_hz: u32::from_le_bytes([c0, c1, c2, c3]),
        })
    }
}

impl<'a> CorrectedFile<'a> {
    /// Checks a whole file.
    ///
    /// # Errors
    /// [`CorrectedError`] says what is wrong and where.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, CorrectedError> {
        let length = CorrectedError::Length(bytes.len());
        let (head, rest) = bytes.split_first_chunk().ok_or(length)?;
        let header = CorrectedHeader::parse(head)?;
        let (records, faults) = rest.split_last_chunk().ok_or(length)?;
        let (edges, over) = records.as_chunks::<EDGE_LEN>();
        if !over.is_empty() {
            return Err(length);
        }
        if let Some(bad) = edges.iter().position(|edge| edge[RESERVED_AT..] != [0, 0]) {
            let at = CORRECTED_HEADER_LEN + bad * EDGE_LEN + RESERVED_AT;
            return Err(CorrectedError::Reserved(at));
        }
        Ok(Self {
            header,
            faults: parse_faults(faults),
            edges,
        })
    }

    /// The corrected edges in order.
    pub fn edges(&self) -> impl ExactSizeIterator<Item = CorrectedEdge> + use<'a> {
        self.edges.iter().map(parse_edge)
    }
}

/// The bytes of one record.
#[inline]
#[must_use]
pub fn emit_edge(edge: &CorrectedEdge) -> [u8; EDGE_LEN] {
    let mut bytes = [0; EDGE_LEN];
    let words = [
        edge.angle.0,
        edge.moved.0.cast_unsigned(),
        edge.interval,
        edge.late.0.cast_unsigned(),
        edge.stretch.0.cast_unsigned(),
        u32::from(edge.flags.0),
    ];
    let cells = bytes.as_chunks_mut::<4>().0.iter_mut();
    let ticks = [edge.ticks as u32, (edge.ticks >> 32) as u32];
    for (cell, word) in cells.zip(ticks.into_iter().chain(words)) {
        *cell = word.to_le_bytes();
    }
    bytes
}

fn parse_edge(bytes: &[u8; EDGE_LEN]) -> CorrectedEdge {
    let mut words = [0; EDGE_LEN / 4];
    for (word, cell) in words.iter_mut().zip(bytes.as_chunks::<4>().0) {
        *word = u32::from_le_bytes(*cell);
    }
    let [low, high, angle, moved, interval, late, stretch, flags] = words;
    CorrectedEdge {
        ticks: u64::from(low) | (u64::from(high) << 32),
        angle: Turn32(angle),
        moved: TurnDelta32(moved.cast_signed()),
        interval,
        late: TickDelta8(late.cast_signed()),
        stretch: TickDelta8(stretch.cast_signed()),
        flags: Flags(flags as u16),
    }
}

/// The bytes of the fault counts.
#[must_use]
pub fn emit_faults(faults: &Faults) -> [u8; FAULTS_LEN] {
    let mut bytes = [0; FAULTS_LEN];
    let counts = [
        faults.illegal,
        faults.lost,
        faults.extra,
        faults.glitch,
        faults.abrupt_reversal,
        faults.interval_spike,
        faults.repeated,
    ];
    for (cell, count) in bytes.as_chunks_mut::<4>().0.iter_mut().zip(counts) {
        *cell = count.to_le_bytes();
    }
    bytes
}

fn parse_faults(bytes: &[u8; FAULTS_LEN]) -> Faults {
    let mut cells = bytes.as_chunks::<4>().0.iter();
    let mut next = || cells.next().map_or(0, |cell| u32::from_le_bytes(*cell));
    // The fields are read in the order in which they stand here.
    Faults {
        illegal: next(),
        lost: next(),
        extra: next(),
        glitch: next(),
        abrupt_reversal: next(),
        interval_spike: next(),
        repeated: next(),
        // A replay's captures come from a file, none is missing.
        missed: 0,
    }
}

#[cfg(test)]
mod tests;

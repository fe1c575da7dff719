//! Rows as they would be had no edge been lost and none come in between.
//!
//! A shaft has inertia: in the middle of steady motion it neither jumps two edges at once nor turns back for a moment. Where rows say
//! so, the rows around are read again with a short pulse taken out or with edges put in, and what fits the pace of the motion
//! best is taken. At a standstill or a reversal a shaft may do all of that, and rows are left as they are, unless the levels
//! themselves can't be.

use quadcal::edge::{Levels, Sample};

use super::code::Code;
use super::mender::Mender;
use crate::recording::Row;

/// What a capture did wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// Edges are missing.
    Lost,
    /// A pulse came that no edge made.
    Extra,
}

/// Something wrong with the rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// What.
    pub kind: FaultKind,
    /// When, ticks: of the first edge lost, about, or of the pulse.
    pub ticks: u64,
    /// Edges missing from the recording, or rows too many.
    pub edges: u32,
    /// Edges of the recording before the first one lost, lost ones included; none where they were not counted.
    pub number: Option<u64>,
    /// Channel of it.
    pub channel: usize,
    /// Whether the count may be wrong after it.
    pub doubtful: bool,
}

/// A row of a mended recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// The row.
    pub row: Row,
    /// Whether its edge was captured, and at its own time.
    pub captured: bool,
}

/// Mended rows and what was wrong.
#[derive(Clone, Debug, Default)]
pub struct Mended {
    /// The rows.
    pub pieces: Vec<Piece>,
    /// By time.
    pub faults: Vec<Fault>,
}

impl Mended {
    /// Rows that are as good as can be known.
    #[must_use]
    pub fn untouched(rows: &[Row]) -> Self {
        let whole = |row: &Row| Piece {
            row: *row,
            captured: true,
        };
        Self {
            pieces: rows.iter().map(whole).collect(),
            faults: Vec::new(),
        }
    }
}

/// Mends rows of a sensor.
#[must_use]
pub fn mend(code: Code, rows: &[Row]) -> Mended {
    let mut mender = Mender::new(code, rows);
    let mut at = 0;
    while at < mender.edges.len() {
        at = mender.take(at);
    }
    mender.finish(rows)
}

impl Mender {
    /// The rows, mended.
    fn finish(mut self, rows: &[Row]) -> Mended {
        let mut pieces: Vec<Piece> = Vec::with_capacity(rows.len() + self.put_in.len());
        self.dropped.sort_unstable();
        self.untimed.sort_unstable();
        let (mut flips, mut put_in) = (self.flips.iter().peekable(), self.put_in.iter().peekable());
        let mask = self.code.mask();
        let mut inside: Option<(usize, u8)> = None;
        for (number, row) in rows.iter().enumerate() {
            let due = |put: &&(usize, u64, u8)| put.1 < row.ticks || put.0 <= number;
            while let Some((_, ticks, levels)) = put_in.next_if(due) {
                let others = pieces.last().map_or(0, |piece| piece.row.levels.0 & !mask);
                pieces.push(Piece {
                    row: Sample {
                        ticks: *ticks,
                        levels: Levels(levels | others),
                    },
                    captured: false,
                });
            }
            if let Some((_, to, bit)) = flips.next_if(|(from, ..)| *from == number) {
                inside = Some((*to, *bit));
            }
            // No change, as after an edge that was lost, is no edge.
            if number > 0 && rows[number - 1].levels == row.levels {
                continue;
            }
            let mut levels = row.levels.0;
            if let Some((to, bit)) = inside {
                if number < to {
                    levels ^= bit;
                } else {
                    inside = None;
                }
            }
            if self.dropped.binary_search(&number).is_ok() {
                levels = levels & !mask | pieces.last().map_or(levels, |p| p.row.levels.0) & mask;
            }
            if pieces
                .last()
                .is_some_and(|last| last.row.levels.0 == levels)
            {
                continue;
            }
            pieces.push(Piece {
                row: Sample {
                    ticks: row.ticks,
                    levels: Levels(levels),
                },
                captured: self.untimed.binary_search(&number).is_err(),
            });
        }
        self.faults.sort_by_key(|fault| fault.ticks);
        Mended {
            pieces,
            faults: self.faults,
        }
    }
}

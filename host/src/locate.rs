//! Starts in the midst of a recording, its index unseen: where the fingerprint finds the shaft in a table, and whether the index
//! agrees.

use quadcal::edge::{Levels, Sample};
use quadcal::fingerprint::{Fingerprint, FingerprintConfig, FingerprintError, Trail, Verdict};
use quadcal::slot::Slot;
use quadcal::step::{Flags, Outcome};
use thiserror::Error;

use crate::recording::Row;
use crate::sensor::{PlanError, SensorKind, SensorPlan};

/// Blocks of 16 edges in a window.
const BLOCKS: usize = 4;

/// Intervals kept on the edge path.
const TRAIL: usize = 128;

/// Half blocks of the table that a slice looks at: under 20,000 instructions on a Cortex-M4. One slice an edge.
const SLICE: u32 = 96;

/// Why no place can be looked for.
#[derive(Debug, Error)]
pub enum LocateError {
    /// The sensor's numbers are out of range.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The table's entries do not fit its header; a checked slot never gives this.
    #[error("the table's entries do not fit its header; write it again with quadcal calibrate")]
    Table,
    /// The table is no fingerprint.
    #[error("{}", describe(*.0))]
    Fingerprint(FingerprintError),
    /// No edge that the table was not learned from.
    #[error(
        "no edge is left that the table was not learned from; calibrate with --turns or --fraction, or give another recording"
    )]
    NothingLeft,
}

fn describe(error: FingerprintError) -> String {
    match error {
        FingerprintError::Classes(classes) => format!(
            "the table is of a sensor with {classes} edge classes; only a quadrature encoder has a fingerprint, so give its table"
        ),
        FingerprintError::Edges(edges) => format!(
            "the table has {edges} edges a turn and a fingerprint needs {}; wait for the index instead",
            16 * BLOCKS
        ),
        FingerprintError::Bits(bits) => {
            format!("an error probability of 2^-{bits} can't be asked for; give 1 to 60 bits")
        }
    }
}

/// What was said at one start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// The place was found.
    Found {
        /// Bound of the probability that it is the wrong one.
        doubt: f64,
        /// Whether the index says the same; none where the recording does not tell.
        agrees: Option<bool>,
    },
    /// The table is of another disc.
    OtherDisc {
        /// Bound of the probability that it is not.
        doubt: f64,
    },
    /// Nothing was decided within a turn or before the recording's end.
    Open,
}

/// One start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Edges from the start to the verdict.
    pub edges: u32,
    /// What was said.
    pub end: End,
}

/// All starts.
#[derive(Clone, Debug)]
pub struct Located {
    /// In order of time.
    pub starts: Vec<Start>,
    /// Edges of a turn.
    pub edges_per_turn: u32,
    /// Whether the recording is the one that the table was learned from; then all starts are later than what was learned.
    pub same_recording: bool,
}

impl Located {
    /// Starts that ended as `pick` says.
    #[must_use]
    pub fn count(&self, pick: impl Fn(End) -> bool) -> usize {
        self.starts.iter().filter(|start| pick(start.end)).count()
    }

    /// Travel to the verdict, degrees, in rising order, of starts that ended as `pick` says.
    #[must_use]
    pub fn degrees(&self, pick: impl Fn(End) -> bool) -> Vec<f64> {
        let chosen = self.starts.iter().filter(|start| pick(start.end));
        let degrees =
            |start: &Start| 360.0 * f64::from(start.edges) / f64::from(self.edges_per_turn);
        let mut degrees: Vec<f64> = chosen.map(degrees).collect();
        degrees.sort_by(f64::total_cmp);
        degrees
    }

    /// The largest error probability stated; 0 where nothing was.
    #[must_use]
    pub fn doubt(&self) -> f64 {
        let doubts = self.starts.iter().map(|start| match start.end {
            End::Found { doubt, .. } | End::OtherDisc { doubt } => doubt,
            End::Open => 0.0,
        });
        doubts.fold(0.0, f64::max)
    }
}

/// Starts at `count` places spread evenly over `rows` and looks for each in `slot`'s table; `source` is the check sum of the
/// recording's start.
///
/// # Errors
/// [`LocateError`] when table and recording don't allow it.
pub fn locate(
    slot: &Slot<'_>,
    plan: SensorPlan,
    source: u32,
    rows: &[Row],
    count: usize,
) -> Result<Located, LocateError> {
    let same_recording = slot.header.source == source && source != 0;
    let first = if same_recording {
        rows.partition_point(|row| row.ticks <= slot.header.learned_until)
    } else {
        0
    };
    let numbers = numbers(plan, rows, slot.header.indexed)?;
    let usable = rows.len() - first;
    if usable < 2 {
        return Err(LocateError::NothingLeft);
    }
    let table = slot.angles().map_err(|_| LocateError::Table)?;
    let config = FingerprintConfig::new(slot.header.standard_error);
    let begin = |start: usize| {
        let at = first + start * usable / count;
        let fingerprint = Fingerprint::new(table, config).map_err(LocateError::Fingerprint)?;
        begin_at(fingerprint, plan, rows, &numbers, at)
    };
    Ok(Located {
        starts: (0..count).map(begin).collect::<Result<_, LocateError>>()?,
        edges_per_turn: slot.header.shape.edges(),
        same_recording,
    })
}

/// The number of the edge at every row by the index, where it is known.
fn numbers(plan: SensorPlan, rows: &[Row], indexed: bool) -> Result<Vec<Option<u32>>, PlanError> {
    let mut decoder = plan.decoder()?;
    let sure = |row: &Row| {
        let step = decoder.push(*row).step()?;
        let known = indexed
            && step.flags.contains(Flags::REFERENCED)
            && !step.flags.contains(Flags::TURN_SUSPECT);
        known.then_some(step.edge)
    };
    Ok(rows.iter().map(sure).collect())
}

/// One start at row `at`.
fn begin_at(
    mut fingerprint: Fingerprint<'_, BLOCKS, [u8; 2]>,
    plan: SensorPlan,
    rows: &[Row],
    numbers: &[Option<u32>],
    at: usize,
) -> Result<Start, LocateError> {
    let blind = SensorPlan {
        kind: SensorKind::Quadrature { index_state: None },
        ..plan
    };
    let mut decoder = blind.decoder()?;
    let mut trail = Trail::<TRAIL>::new();
    // A drive weighs its table before the shaft moves.
    while fingerprint.search(&trail, SLICE) == Verdict::Searching {}
    let turn = 4 * plan.lines;
    let mut edges = 0;
    for (row, number) in rows.iter().zip(numbers).skip(at) {
        let outcome = decoder.push(Sample {
            levels: Levels(row.levels.0 & (Levels::A | Levels::B)),
            ..*row
        });
        trail.push(&outcome);
        let Outcome::Step(step) = outcome else {
            continue;
        };
        edges += 1;
        let end = match fingerprint.search(&trail, SLICE) {
            Verdict::Found(place) => End::Found {
                doubt: probability(place.doubt.0),
                agrees: number.map(|number| (step.edge + place.offset) % turn == number),
            },
            Verdict::OtherDisc(doubt) => End::OtherDisc {
                doubt: probability(doubt.0),
            },
            _ if edges >= turn => break,
            _ => continue,
        };
        return Ok(Start { edges, end });
    }
    Ok(Start {
        edges,
        end: End::Open,
    })
}

fn probability(bits: u8) -> f64 {
    0.5_f64.powi(bits.into())
}

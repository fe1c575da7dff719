//! Starts without an index: where the fingerprint finds the shaft, how soon, how sure it says it is, and what it makes of another
//! disc's table.

mod case;

use quadcal::decoder::{DecoderConfig, QuadratureDecoder};
use quadcal::edge::{Levels, Sample};
use quadcal::fingerprint::{Fingerprint, FingerprintConfig, Trail, Verdict};
use quadcal::step::Outcome;
use quadcal::table::ErrorTable;
use quadcal_host::sim::{Event, Simulation};

use crate::accuracy::run;

pub use case::Case;

/// Blocks of a window here.
pub const BLOCKS: usize = 4;

/// Half blocks of the table looked at in a slice (under 20,000 instructions), one slice an edge.
pub const SLICE: u32 = 96;

/// Turns after which a start is given up.
pub(crate) const PATIENCE_TURNS: u32 = 3;

/// A disc, its table as the core learned it, and a recording of another day.
pub struct Disc {
    errors: Vec<f64>,
    table: Table,
    events: Vec<Event>,
}

/// A learned table.
#[derive(Clone)]
pub struct Table {
    shape: quadcal::shape::EncoderShape,
    offsets: [quadcal::units::TurnDelta32; quadcal::shape::CLASSES_MAX],
    entries: Vec<i16>,
    shift: u32,
    /// Its standard error, 2^-32 turn.
    pub standard_error: u32,
}

impl Table {
    /// The table of a disc that slipped by `lines` against its index.
    #[must_use]
    pub fn slipped(&self, lines: usize) -> Self {
        let mut table = self.clone();
        table.entries.rotate_left(4 * lines);
        table
    }

    fn view(&self) -> ErrorTable<'_> {
        ErrorTable::new(self.shape, self.offsets, &self.entries, self.shift)
            .expect("a solution fits itself")
    }
}

impl Disc {
    /// Learns disc `seed` of a case and records it again.
    ///
    /// # Panics
    /// When the twin can't be simulated: a fault of the test.
    #[must_use]
    pub fn new(case: Case, seed: u64) -> Self {
        let teacher = case.teacher(seed);
        let learned = run(&teacher);
        let solution = &learned.calibration.solution;
        let mut disc = Self {
            errors: Simulation::new(&teacher)
                .expect("the twin is valid")
                .true_errors(),
            table: Table {
                shape: solution.shape(),
                offsets: *solution.class_offsets(),
                entries: solution.entries().to_vec(),
                shift: solution.shift(),
                standard_error: solution.standard_error(),
            },
            events: Vec::new(),
        };
        let pupil = case.pupil(&disc.errors, seed + 1_000_000);
        disc.events = Simulation::new(&pupil)
            .expect("the twin is valid")
            .collect();
        disc
    }

    /// Its table.
    #[must_use]
    pub const fn table(&self) -> &Table {
        &self.table
    }

    /// Starts at a fraction of the first turn of the recording, Z unseen, with `table`.
    ///
    /// # Panics
    /// When the table has no use: a fault of the test.
    #[must_use]
    pub fn start(&self, table: &Table, fraction: f64, bits: u8) -> Start {
        let mut drive = Drive::with(table, bits);
        let slots = table.shape.edges();
        let from = (fraction * f64::from(slots)) as usize;
        let mut edges = 0;
        let mut last = Verdict::Gathering;
        for event in &self.events[from..] {
            let levels = Levels(event.row.levels.0 & (Levels::A | Levels::B));
            let outcome = drive.push(Sample {
                ticks: event.row.ticks,
                levels,
            });
            let (Some(step), Some(truth)) = (outcome.step(), event.truth.edge) else {
                continue;
            };
            edges += 1;
            last = drive.search();
            match last {
                Verdict::Found(place) => {
                    let right = (step.edge + place.offset) % slots == truth;
                    let bits = place.doubt.0;
                    return Start {
                        edges,
                        end: if right {
                            End::Right(bits)
                        } else {
                            End::Wrong(bits)
                        },
                    };
                }
                Verdict::OtherDisc(doubt) => {
                    return Start {
                        edges,
                        end: End::Refused(doubt.0),
                    };
                }
                _ if edges >= PATIENCE_TURNS * slots => break,
                _ => {}
            }
        }
        let told = last == Verdict::Undecidable;
        Start {
            edges,
            end: End::Open { told },
        }
    }

    /// Runs the recording with its index and `table` in use from the first index on; edges from there to the verdict that it does
    /// not fit (said before, where the index came late), none if it never comes.
    ///
    /// # Panics
    /// When the table has no use: a fault of the test.
    #[must_use]
    pub fn watch(&self, table: &Table, bits: u8) -> Option<u32> {
        let mut drive = Drive::with(table, bits);
        let mut edges = 0;
        for event in &self.events {
            let outcome = drive.push(event.row);
            let referenced = drive.trail.is_referenced();
            edges += u32::from(outcome.step().is_some() && referenced);
            let refused = matches!(drive.search(), Verdict::Misfit(_) | Verdict::OtherDisc(_));
            if referenced && refused {
                return Some(edges);
            }
        }
        None
    }
}

/// A drive that looks for its place in a table.
struct Drive<'a> {
    decoder: QuadratureDecoder,
    trail: Trail<128>,
    fingerprint: Fingerprint<'a, BLOCKS>,
}

impl<'a> Drive<'a> {
    /// A drive that stands still and has weighed the table.
    fn with(table: &'a Table, bits: u8) -> Self {
        let config = FingerprintConfig {
            standard_error: table.standard_error,
            bits,
        };
        let lines = table.shape.edges() / 4;
        let mut drive = Self {
            decoder: QuadratureDecoder::new(DecoderConfig::new(lines)).expect("lines fit"),
            trail: Trail::new(),
            fingerprint: Fingerprint::new(table.view(), config)
                .expect("the table is of a quadrature encoder"),
        };
        while drive.search() == Verdict::Searching {}
        drive
    }

    /// Takes a change of levels.
    fn push(&mut self, sample: Sample) -> Outcome {
        let outcome = self.decoder.push(sample);
        self.trail.push(&outcome);
        outcome
    }

    /// Searches for a slice.
    fn search(&mut self) -> Verdict {
        self.fingerprint.search(&self.trail, SLICE)
    }
}

/// How a start ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Start {
    /// Edges from the first on.
    pub edges: u32,
    /// What was said.
    pub end: End,
}

/// What was said of a start; numbers are bits of [`quadcal::fingerprint::Doubt`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The true place.
    Right(u8),
    /// A place that is not the true one.
    Wrong(u8),
    /// The table is another disc's.
    Refused(u8),
    /// Nothing within three turns; whether the core said that it can't tell.
    Open {
        /// Whether it said so.
        told: bool,
    },
}

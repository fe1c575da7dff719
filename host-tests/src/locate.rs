//! Starts without an index: where the fingerprint finds the shaft, how soon, how sure it says it is, and what it makes of another
//! disc's table.

use quadcal::decoder::{DecoderConfig, QuadratureDecoder};
use quadcal::edge::{Levels, Sample};
use quadcal::fingerprint::{Fingerprint, FingerprintConfig, Trail, Verdict};
use quadcal::table::ErrorTable;
use quadcal_host::sim::{Event, Simulation};
use quadcal_host::twin::{Drive, Duration, Encoder, Errors, Noise, Per, Position, Twin};

use crate::accuracy::run;

/// Blocks of a window here.
pub const BLOCKS: usize = 4;

/// Half blocks of the table looked at in a slice (under 20,000 instructions), one slice an edge.
pub const SLICE: u32 = 96;

/// Turns after which a start is given up.
const PATIENCE_TURNS: u32 = 3;

/// What is made hard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Case {
    /// The paper's rig with 0.1 % wander.
    Paper,
    /// A 1 MHz clock: 25 ticks an edge at the search's own 240 r/min.
    CoarseClock,
    /// eps ten times smaller.
    WeakPattern,
    /// 60 lines, errors in parts of a step as the paper's.
    FewLines,
    /// No eps but eccentricity and tilt.
    Smooth,
    /// 1 % wander beside cogging of 1 %, twice the paper's higher orders.
    Cogging,
    /// From 15 to 150 r/min within one turn.
    Ramp,
    /// White time noise of the capture half as large as eps.
    HalfJitter,
    /// As large as eps.
    Jitter,
}

impl Case {
    /// Every case.
    pub const ALL: [Self; 9] = [
        Self::Paper,
        Self::CoarseClock,
        Self::WeakPattern,
        Self::FewLines,
        Self::Smooth,
        Self::Cogging,
        Self::Ramp,
        Self::HalfJitter,
        Self::Jitter,
    ];

    /// Its name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper's rig, wander 0.1 %",
            Self::CoarseClock => "25 ticks an edge",
            Self::WeakPattern => "eps 10 times smaller",
            Self::FewLines => "60 lines",
            Self::Smooth => "smooth pattern only",
            Self::Cogging => "wander and cogging 1 %",
            Self::Ramp => "15 to 150 r/min in a turn",
            Self::HalfJitter => "time noise half of eps",
            Self::Jitter => "time noise as large as eps",
        }
    }

    /// The rig that the table is learned on.
    #[must_use]
    pub fn teacher(self, seed: u64) -> Twin {
        let mut twin = Twin::paper();
        twin.seed = seed;
        twin.duration = Duration::Turns(14.1);
        twin.noise = Some(wander(1e-3));
        match self {
            Self::WeakPattern => scale_position(&mut twin, 0.1),
            Self::FewLines => {
                let scale = 2500.0 / 60.0;
                twin.encoder = Encoder::Quadrature {
                    lines: 60,
                    index: true,
                };
                scale_position(&mut twin, scale);
                twin.errors.width_a_rad *= scale;
                twin.errors.width_b_rad *= scale;
                twin.errors.quadrature_rad *= scale;
            }
            Self::Smooth => {
                let harmonic = |amplitude_rad| {
                    Some(quadcal_host::twin::Harmonic {
                        amplitude_rad,
                        phase_rad: 0.4,
                    })
                };
                twin.errors = Errors {
                    position: None,
                    eccentricity: harmonic(5e-4),
                    tilt: harmonic(1e-4),
                    ..twin.errors
                };
            }
            _ => {}
        }
        twin
    }

    /// The same disc, another day: other wander, and what makes the case hard.
    fn pupil(self, disc: &Disc, seed: u64) -> Twin {
        let mut twin = self.teacher(seed);
        twin.errors = Errors {
            list_rad: disc.errors.clone(),
            ..Errors::default()
        };
        twin.duration = Duration::Turns(f64::from(PATIENCE_TURNS) + 1.2);
        match self {
            Self::CoarseClock => {
                twin.timer.clock_hz = 1_000_000;
                twin.drive = Drive::Constant { r_min: 240.0 };
            }
            Self::Cogging => {
                twin.noise = Some(wander(1e-2));
                for ripple in &mut twin.ripple {
                    ripple.speed_fraction = Some(1e-2);
                }
            }
            Self::Ramp => {
                twin.drive = Drive::Ramp {
                    from_r_min: 15.0,
                    to_r_min: 150.0,
                    over_s: 0.73,
                };
            }
            // 3.6e-5 rad at 15 r/min are 2.3e-5 s.
            Self::Jitter => twin.timer.jitter_s = 2.3e-5,
            Self::HalfJitter => twin.timer.jitter_s = 1.15e-5,
            _ => {}
        }
        twin
    }
}

fn wander(rms_fraction: f64) -> Noise {
    Noise::SpeedWander {
        rms_fraction,
        correlation_rad: Some(0.5),
        hold_s: None,
    }
}

fn scale_position(twin: &mut Twin, factor: f64) {
    twin.errors.position = Some(Position::Uniform {
        amplitude_rad: 6.2832e-5 * factor,
        per: Per::Edge,
    });
}

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
        let pupil = case.pupil(&disc, seed + 1_000_000);
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
        let slots = table.shape.edges();
        let config = FingerprintConfig {
            standard_error: table.standard_error,
            bits,
        };
        let mut fingerprint: Fingerprint<'_, BLOCKS> =
            Fingerprint::new(table.view(), config).expect("the table is of a quadrature encoder");
        let mut trail = Trail::<128>::new();
        let mut decoder = QuadratureDecoder::new(DecoderConfig::new(slots / 4)).expect("lines fit");
        // The table is at hand before the shaft moves.
        while fingerprint.search(&trail, SLICE) == Verdict::Searching {}
        let from = (fraction * f64::from(slots)) as usize;
        let mut edges = 0;
        let mut last = Verdict::Gathering;
        for event in &self.events[from..] {
            let levels = Levels(event.row.levels.0 & (Levels::A | Levels::B));
            let outcome = decoder.push(Sample {
                ticks: event.row.ticks,
                levels,
            });
            trail.push(&outcome);
            let (Some(step), Some(truth)) = (outcome.step(), event.truth.edge) else {
                continue;
            };
            edges += 1;
            last = fingerprint.search(&trail, SLICE);
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

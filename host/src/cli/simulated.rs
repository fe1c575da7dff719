//! The files of a simulation, written as it runs and brought to their places together.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::io::{BufWriter, Write as _};

use crate::recording::write::{NativeWriter, VcdWriter, WriteError};
use crate::recording::{Header, Row};
use crate::reports::simulate::Outcome;
use crate::sim::Simulation;
use crate::twin::{Duration, Twin};

use super::Globals;
use super::failure::Failure;
use super::output::{Output, Target};
use super::progress::Progress;

/// Points kept of the true speed.
const SPEED_POINTS: f64 = 400.0;

/// Where the parts of a simulation go.
pub(super) struct Files<'a> {
    /// The recording.
    pub recording: &'a Target,
    /// The true errors.
    pub truth: Option<&'a Target>,
    /// A reference encoder's angles, and the turns it makes for one of the encoder.
    pub reference: Option<(&'a Target, f64)>,
}

/// A writer of either format.
enum Writer {
    Csv(NativeWriter<Output>),
    Vcd(Box<VcdWriter<Output>>),
}

impl Writer {
    fn new(target: &Target, header: &Header) -> Result<Self, Failure> {
        let output = target.create()?;
        let writer = if target.has_extension("vcd") {
            VcdWriter::new(output, header).map(|writer| Self::Vcd(Box::new(writer)))
        } else {
            NativeWriter::new(output, header).map(Self::Csv)
        };
        writer.map_err(|error| Failure::writing(target, error))
    }

    fn row(&mut self, row: &Row) -> Result<(), WriteError> {
        match self {
            Self::Csv(writer) => writer.row(row),
            Self::Vcd(writer) => writer.row(row),
        }
    }

    fn finish(self) -> Result<Output, WriteError> {
        match self {
            Self::Csv(writer) => writer.finish(),
            Self::Vcd(writer) => writer.finish(),
        }
    }
}

/// A simulation that has run, its files not yet in their places.
pub(super) struct Simulated {
    recording: Output,
    reference: Option<BufWriter<Output>>,
    outcome: Outcome,
}

impl Simulated {
    /// Runs a simulation to its end.
    ///
    /// # Errors
    /// A file that can't be written, an output whose name ends in neither .csv nor .vcd, or a shaft that ran away.
    #[allow(clippy::cast_precision_loss)]
    pub fn run(
        mut simulation: Simulation,
        twin: &Twin,
        files: &Files<'_>,
        globals: Globals,
    ) -> Result<Self, Failure> {
        let target = files.recording;
        if *target != Target::Stdout && !["csv", "vcd"].iter().any(|e| target.has_extension(e)) {
            return Err(Failure::RecordingName {
                target: target.clone(),
            });
        }
        let mut writer = Writer::new(target, &simulation.header())?;
        let mut reference = match files.reference {
            Some((target, ratio)) => {
                let mut out = BufWriter::new(target.create()?);
                writeln!(out, "time,angle_rad").map_err(|source| target.failed(source))?;
                Some((out, target, ratio))
            }
            None => None,
        };
        let mut tally = Tally::new(twin);
        let total = match twin.duration {
            Duration::Turns(turns) => Some(turns.ceil() as u64),
            Duration::Seconds(_) | Duration::Unknown => None,
        };
        let mut progress = Progress::count("Simulating", "turns", total, globals);
        for event in simulation.by_ref() {
            writer
                .row(&event.row)
                .map_err(|error| Failure::writing(target, error))?;
            tally.rows += 1;
            if event.truth.edge.is_none() {
                continue;
            }
            let ahead = tally.edge(event.truth.time_s, event.truth.angle_rad);
            if tally.edges.is_multiple_of(4096) {
                progress.reach((tally.way / TAU) as u64, |_| String::new());
            }
            if let Some((out, target, ratio)) = reference.as_mut().filter(|_| ahead) {
                let angle = event.truth.angle_rad * *ratio;
                writeln!(out, "{:.12},{angle:.12}", event.truth.time_s)
                    .map_err(|source| target.failed(source))?;
            }
        }
        drop(progress);
        simulation.ended()?;
        let recording = writer
            .finish()
            .map_err(|error| Failure::writing(target, error))?;
        Ok(Self {
            recording,
            reference: reference.map(|(out, _, _)| out),
            outcome: tally.outcome(),
        })
    }

    /// Brings all files to their places; `truth` are the encoder's true errors, rad.
    ///
    /// # Errors
    /// [`Failure::Write`].
    pub fn commit(self, files: &Files<'_>, truth: &[f64]) -> Result<Outcome, Failure> {
        if let (Some(out), Some((target, _))) = (self.reference, files.reference) {
            out.into_inner()
                .map_err(|error| error.into_error())
                .and_then(Output::commit)
                .map_err(|source| target.failed(source))?;
        }
        if let Some(target) = files.truth {
            target.write(truth_csv(truth).as_bytes())?;
        }
        self.recording
            .commit()
            .map_err(|source| files.recording.failed(source))?;
        let mut outcome = self.outcome;
        outcome.true_errors_rad = truth.to_vec();
        Ok(outcome)
    }
}

/// True errors as CSV.
pub(super) fn truth_csv(truth: &[f64]) -> String {
    let mut text = "edge,error_rad\n".to_owned();
    for (edge, error) in truth.iter().enumerate() {
        // Writing to a string never fails.
        let _ = writeln!(text, "{edge},{error:e}");
    }
    text
}

/// What is counted while a simulation runs.
struct Tally {
    rows: u64,
    edges: u64,
    way: f64,
    stride: u64,
    first: Option<(f64, f64)>,
    last: (f64, f64),
    mark: (f64, f64),
    speed: Vec<(f64, f64)>,
}

impl Tally {
    fn new(twin: &Twin) -> Self {
        // Whole turns at least every few points would be too coarse for a short run: a fixed share of the edges it is.
        let turns = match twin.duration {
            Duration::Turns(turns) => turns,
            Duration::Unknown => 0.0,
            Duration::Seconds(seconds) => seconds * twin.drive.nominal_rad_s().abs() / TAU,
        };
        let edges = turns * f64::from(twin.encoder.grid_edges());
        Self {
            rows: 0,
            edges: 0,
            way: 0.0,
            stride: ((edges / SPEED_POINTS) as u64).max(1),
            first: None,
            last: (0.0, 0.0),
            mark: (0.0, 0.0),
            speed: Vec::new(),
        }
    }

    /// Takes an edge; false for one that delays brought behind another that happened later.
    fn edge(&mut self, time: f64, angle: f64) -> bool {
        self.edges += 1;
        if self.first.is_some() && time <= self.last.0 {
            return false;
        }
        let here = (time, angle);
        match self.first {
            None => {
                self.first = Some(here);
                self.mark = here;
            }
            Some(_) => self.way += (angle - self.last.1).abs(),
        }
        self.last = here;
        if self.edges.is_multiple_of(self.stride) && time > self.mark.0 {
            let r_min = (angle - self.mark.1) / (time - self.mark.0) * 60.0 / TAU;
            self.speed.push((time, r_min));
            self.mark = here;
            // How many edges come of a torque is not known before.
            if self.speed.len() as f64 >= 2.0 * SPEED_POINTS {
                let mut odd = false;
                self.speed.retain(|_| {
                    odd = !odd;
                    !odd
                });
                self.stride *= 2;
            }
        }
        true
    }

    fn outcome(self) -> Outcome {
        Outcome {
            rows: self.rows,
            edges: self.edges,
            seconds: self.first.map_or(0.0, |first| self.last.0 - first.0),
            turns: self.way / TAU,
            true_errors_rad: Vec::new(),
            speed: self.speed,
        }
    }
}

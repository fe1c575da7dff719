//! Recordings without a twin: read, their sensor found, and a starting twin made of them.

use crate::calibrate::{self, Disagreement};
use crate::diagnose::edges::{self, Sensor};
use crate::recording::Row;
use crate::sensor::{SensorKind, SensorPlan};
use crate::starting_twin::{self, Found, Given, Placed, Rhythm, Starting, StartingError};
use crate::survey::Survey;

use super::Globals;
use super::failure::Failure;
use super::input::InputArgs;
use super::progress::Pass;

/// A recording that was read.
struct Read {
    input: InputArgs,
    survey: Survey,
    rows: Vec<Row>,
    source: u32,
    found: Found,
}

/// Recordings whose sensor was found and whose edges are placed.
pub(super) struct Recordings {
    /// The sensor.
    pub found: Found,
    /// Clock of all of them, Hz.
    pub clock_hz: u64,
    /// Their edges.
    pub placed: Vec<Placed>,
}

impl Recordings {
    /// Reads recordings of one rig and finds their sensor.
    ///
    /// # Errors
    /// A recording that can't be read, whose sensor can't be told, or that is of another rig than one before it.
    pub fn read(inputs: &[InputArgs], given: Given, globals: Globals) -> Result<Self, Failure> {
        let sizes = inputs.iter().map(|input| {
            let found = std::fs::metadata(&input.recording);
            found.map(|found| found.len())
        });
        let mut pass = Pass::new("Reading", sizes.sum::<Result<u64, _>>().ok(), globals);
        let mut all: Vec<Read> = Vec::new();
        for input in inputs {
            let this = read(input, given, &mut pass)?;
            for other in &all {
                together(&this, other)?;
            }
            all.push(this);
        }
        drop(pass);
        // The recording that tells most of the sensor speaks for all.
        let best = all.iter().max_by_key(|one| one.found.source);
        let (found, clock_hz) = match best {
            Some(best) => (best.found.clone(), best.survey.header.clock_hz),
            None => return Err(Failure::NoRecording),
        };
        let placed = all.iter().map(|one| place(one, &found));
        Ok(Self {
            placed: placed.collect::<Result<_, _>>()?,
            found,
            clock_hz,
        })
    }

    /// The starting twin's numbers, beside what swings at a rate of its own.
    ///
    /// # Errors
    /// As [`starting_twin::estimate`].
    pub fn estimate(
        &self,
        rhythms: Vec<Rhythm>,
        progress: &mut dyn FnMut(f64, &'static str),
    ) -> Result<Starting, Failure> {
        starting_twin::estimate(&self.found, self.clock_hz, &self.placed, rhythms, progress)
            .map_err(Failure::from)
    }

    /// What swings at a rate of its own.
    ///
    /// # Errors
    /// As [`starting_twin::rhythms`].
    pub fn rhythms(
        &self,
        progress: &mut dyn FnMut(f64, &'static str),
    ) -> Result<Vec<Rhythm>, Failure> {
        starting_twin::rhythms(&self.found, self.clock_hz, &self.placed, progress)
            .map_err(Failure::from)
    }
}

fn read(input: &InputArgs, given: Given, pass: &mut Pass) -> Result<Read, Failure> {
    input.check_regular()?;
    let watched = pass.watch(input.open()?);
    let header = watched.recording().header.clone();
    let rows: Vec<Row> = watched.collect::<Result<_, _>>()?;
    let survey = Survey::of(header, rows.iter().copied().map(Ok))?;
    let found = starting_twin::find(&survey, &rows, given).map_err(|source| Failure::Sensor {
        recording: input.recording.clone(),
        source,
    })?;
    Ok(Read {
        input: input.clone(),
        survey,
        rows,
        source: input.source()?,
        found,
    })
}

/// Refuses two recordings that are not of one rig, or are one recording.
fn together(this: &Read, other: &Read) -> Result<(), Failure> {
    let guessed = |one: &Read| one.found.source == starting_twin::Source::Pattern;
    let agreed = if this.source == other.source {
        Err(Disagreement::Same)
    } else {
        let ([one, another], clocks) = (
            [plan(this), plan(other)],
            [this, other].map(|one| one.survey.header.clock_hz),
        );
        // What is guessed of one gives way to the other.
        let lines = if guessed(this) {
            another.lines
        } else {
            one.lines
        };
        let one = SensorPlan { lines, ..one };
        let lines = if guessed(other) {
            one.lines
        } else {
            another.lines
        };
        let another = SensorPlan { lines, ..another };
        calibrate::agree((one, clocks[0]), (another, clocks[1]))
    };
    agreed.map_err(|source| Failure::Together {
        this: this.input.recording.clone(),
        other: other.input.recording.clone(),
        source,
    })
}

/// The sensor as recordings are compared by it; any gap ties the edges of two recordings to each other.
fn plan(one: &Read) -> SensorPlan {
    let (lines, index, missing) = match &one.found.sensor {
        Sensor::Quadrature { lines, index } => (*lines, *index, 0),
        Sensor::Hall { pole_pairs } => (*pole_pairs, None, 0),
        Sensor::Wheel { present, .. } => {
            let missing = present.iter().filter(|there| !**there).count();
            let teeth = u32::try_from(present.len()).unwrap_or(u32::MAX);
            (teeth, None, u16::try_from(missing).unwrap_or(u16::MAX))
        }
    };
    SensorPlan {
        kind: SensorKind::of(one.survey.header.channels, index, missing),
        lines,
    }
}

/// Places the edges of a recording by the sensor of all, with the recording's own index.
fn place(one: &Read, found: &Found) -> Result<Placed, Failure> {
    let sensor = match (&found.sensor, &one.found.sensor) {
        (Sensor::Quadrature { lines, .. }, Sensor::Quadrature { index, .. }) => {
            Sensor::Quadrature {
                lines: *lines,
                index: *index,
            }
        }
        (sensor, _) => sensor.clone(),
    };
    let edges = edges::place(&sensor, one.survey.header.clock_hz, &one.rows);
    Ok(Placed {
        file: one.input.recording.display().to_string(),
        edges: edges.map_err(|source| Failure::Placing {
            recording: one.input.recording.clone(),
            source,
        })?,
    })
}

impl From<StartingError> for Failure {
    fn from(error: StartingError) -> Self {
        match error {
            StartingError::Diagnose(error) => error.into(),
            StartingError::Twin(error) => error.into(),
        }
    }
}

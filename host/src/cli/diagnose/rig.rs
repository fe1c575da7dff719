//! The recordings of a rig, read, each with the twin that should explain it.

use std::path::{Path, PathBuf};

use crate::calibrate::Disagreement;
use crate::cli::Globals;
use crate::cli::failure::Failure;
use crate::cli::input::{InputArgs, ReadingArgs};
use crate::cli::progress::Pass;
use crate::diagnose::edges;
use crate::diagnose::pipeline::EDGES_LEAST;
use crate::diagnose::rig::{DiagnoseError, Recorded};
use crate::recording::{Header, Row};
use crate::sim::true_errors;
use crate::survey::Survey;
use crate::twin::{Encoder, Twin};

use super::encoder::{self, OtherEncoder};

/// What the command line names.
pub(super) struct Named<'a> {
    pub(super) recordings: &'a [PathBuf],
    /// One for all recordings, or one each.
    pub(super) twins: &'a [PathBuf],
    pub(super) reading: &'a ReadingArgs,
}

/// A twin by its file.
struct Declared<'a> {
    path: &'a Path,
    twin: Twin,
}

impl Named<'_> {
    /// Reads everything: the twins first, as they are soon read.
    ///
    /// # Errors
    /// The first of a twin that can't be run, of another rig, of a recording that can't be read or is of another encoder.
    pub(super) fn read(&self, globals: Globals) -> Result<Vec<Recorded>, Failure> {
        let declared = self.declared()?;
        let inputs: Vec<InputArgs> = self.recordings.iter().map(|r| self.reading.of(r)).collect();
        let mut sources: Vec<(u32, &Path)> = Vec::new();
        for input in &inputs {
            input.check_regular()?;
        }
        let mut rig = Vec::new();
        let mut surveying = self.pass("Reading", globals);
        let mut surveys = Vec::new();
        for input in &inputs {
            let rows = surveying.watch(input.open()?);
            let header = rows.recording().header.clone();
            surveys.push(Survey::of(header, rows)?);
            let source = input.source()?;
            if let Some((_, other)) = sources.iter().find(|(earlier, _)| *earlier == source) {
                return Err(Failure::Together {
                    this: input.recording.clone(),
                    other: other.to_path_buf(),
                    source: Disagreement::Same,
                });
            }
            sources.push((source, &input.recording));
        }
        drop(surveying);
        let mut decoding = self.pass("Decoding", globals);
        for (index, (input, survey)) in inputs.iter().zip(&surveys).enumerate() {
            // As many twins as recordings, or one.
            let Some(declared) = declared.get(index).or(declared.first()) else {
                break;
            };
            rig.push(recorded(input, survey, declared, &mut decoding)?);
        }
        Ok(rig)
    }

    fn declared(&self) -> Result<Vec<Declared<'_>>, Failure> {
        let (twins, recordings) = (self.twins.len(), self.recordings.len());
        if twins != 1 && twins != recordings {
            return Err(Failure::TwinCount { twins, recordings });
        }
        let mut declared: Vec<Declared<'_>> = Vec::new();
        for path in self.twins {
            let twin = Twin::load(path)?;
            // Lists of errors are read, and edges looked at for their order, before a long recording is.
            true_errors(&twin)?;
            if let Some(first) = declared.first()
                && disc(&first.twin.encoder) != disc(&twin.encoder)
            {
                return Err(Failure::OtherRig {
                    this: path.clone(),
                    other: first.path.to_owned(),
                });
            }
            declared.push(Declared { path, twin });
        }
        Ok(declared)
    }

    fn pass(&self, what: &str, globals: Globals) -> Pass {
        let sizes = self.recordings.iter().map(|path| {
            let found = std::fs::metadata(path);
            found.map(|found| found.len())
        });
        Pass::new(what, sizes.sum::<Result<u64, _>>().ok(), globals)
    }
}

/// An encoder without its index, which may be connected for one recording and not for another.
fn disc(encoder: &Encoder) -> Encoder {
    match encoder {
        &Encoder::Quadrature { lines, .. } => Encoder::Quadrature {
            lines,
            index: false,
        },
        other => other.clone(),
    }
}

fn recorded(
    input: &InputArgs,
    survey: &Survey,
    declared: &Declared<'_>,
    pass: &mut Pass,
) -> Result<Recorded, Failure> {
    let other = |source| Failure::OtherEncoder {
        recording: input.recording.clone(),
        twin: declared.path.to_owned(),
        source,
    };
    let file = input.recording.display().to_string();
    let encoder = &declared.twin.encoder;
    let sensor =
        encoder::sensor(encoder, survey).map_err(|source| {
            match encoder::part_of_a_turn(encoder, survey) {
                Some(turns) if source == OtherEncoder::NoIndexPulse => DiagnoseError::TooShort {
                    file: file.clone(),
                    edges: usize::try_from(survey.rows).unwrap_or(usize::MAX),
                    turns,
                    least: EDGES_LEAST,
                }
                .into(),
                _ => other(source),
            }
        })?;
    let clock_hz = declared.twin.timer.clock_hz;
    if let Some(stated) = stated_clock(&survey.header).filter(|stated| *stated != clock_hz) {
        return Err(Failure::OtherClock {
            recording: input.recording.clone(),
            twin: declared.path.to_owned(),
            stated,
            declared: clock_hz,
        });
    }
    let rows: Vec<Row> = pass.watch(input.open()?).collect::<Result<_, _>>()?;
    let edges = edges::place(&sensor, survey.header.clock_hz, &rows).map_err(|source| {
        Failure::Placing {
            recording: input.recording.clone(),
            source,
        }
    })?;
    Ok(Recorded {
        file,
        edges,
        twin: declared.twin.clone(),
    })
}

/// The clock that a recording states, Hz; that of times in seconds is only the step in which they are read.
fn stated_clock(header: &Header) -> Option<u64> {
    let stated = header.notes.iter().any(|(key, _)| key == "clock_hz");
    stated.then_some(header.clock_hz)
}

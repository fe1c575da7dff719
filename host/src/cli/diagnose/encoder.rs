//! The sensor that a twin declares, held against what a recording shows.

use quadcal::edge::Levels;
use thiserror::Error;

use crate::recording::{Channels, Header, Row};
use crate::sensor::{PlanError, SensorKind, SensorPlan};
use crate::survey::Survey;
use crate::twin::Encoder;

/// Why a recording is not of the encoder that its twin declares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum OtherEncoder {
    /// Another kind of sensor.
    #[error(
        "the twin declares {declared}, the recording is of {recorded}; give the twin of this rig, or name the channels with --map"
    )]
    Kind {
        /// As declared.
        declared: &'static str,
        /// As recorded.
        recorded: &'static str,
    },
    /// The twin has an index and the recording has no channel for it.
    #[error(
        "the twin declares an index, the recording has no channel Z; set index = false in the twin's [encoder.quadrature], or record Z"
    )]
    NoIndexChannel,
    /// The twin has an index and none is in the recording.
    #[error(
        "the twin declares an index, but channel Z never goes high; record a whole turn, or set index = false in the twin's \
         [encoder.quadrature]"
    )]
    NoIndexPulse,
    /// Another number of lines.
    #[error(
        "the twin declares {declared} {name} a turn, {shown_by} {shown}; give the twin of this rig, or correct it"
    )]
    Lines {
        /// As declared.
        declared: u32,
        /// As the recording shows.
        shown: u32,
        /// What is counted.
        name: &'static str,
        /// What in the recording shows it.
        shown_by: &'static str,
    },
    /// An encoder that can be simulated, but not decoded.
    #[error("{0}; this encoder can't be diagnosed")]
    Plan(#[from] PlanError),
}

/// The plan by which the recording of `survey` is decoded as the encoder that its twin declares.
///
/// A recording may hold more than the twin declares, an index that it knows nothing of, never less. One pulse a tooth
/// is enough for a wheel.
///
/// # Errors
/// [`OtherEncoder`].
pub fn plan(encoder: &Encoder, survey: &Survey) -> Result<SensorPlan, OtherEncoder> {
    let channels = survey.header.channels;
    let (kind, lines) = match (encoder, channels) {
        (&Encoder::Quadrature { lines, index }, Channels::Quadrature { index: recorded }) => {
            let index_state = match (index, recorded) {
                (false, _) => None,
                (true, false) => return Err(OtherEncoder::NoIndexChannel),
                (true, true) if survey.index_pulses == 0 => return Err(OtherEncoder::NoIndexPulse),
                (true, true) => Some(survey.index_state()),
            };
            (SensorKind::Quadrature { index_state }, lines)
        }
        (&Encoder::Hall { pole_pairs }, Channels::Hall) => (SensorKind::Hall, pole_pairs),
        (&Encoder::Wheel { teeth, .. }, Channels::Wheel | Channels::Pulses) => {
            // More teeth than the decoder can miss are refused with their number cut.
            let missing = encoder.missing_at_end().unwrap_or(u32::MAX);
            let missing = u16::try_from(missing).unwrap_or(u16::MAX);
            (SensorKind::of(channels, None, missing), teeth)
        }
        _ => {
            return Err(OtherEncoder::Kind {
                declared: declared(encoder),
                recorded: recorded(channels),
            });
        }
    };
    let plan = SensorPlan { kind, lines };
    plan.shape()?;
    plan.decoder()?;
    check_lines(plan, survey)?;
    Ok(plan)
}

/// Turns that a recording without an index pulse may have at the most, where that is less than one: it needs no index to be too short.
#[must_use]
#[allow(clippy::cast_precision_loss)]
pub fn part_of_a_turn(encoder: &Encoder, survey: &Survey) -> Option<f64> {
    let turns = survey.rows as f64 / f64::from(encoder.grid_edges());
    (survey.index_pulses == 0 && turns < 1.0).then_some(turns)
}

/// A row without an index that the twin does not declare, as the decoder would go by it.
#[must_use]
pub fn as_declared(plan: SensorPlan, row: Row) -> Row {
    match plan.kind {
        SensorKind::Quadrature { index_state: None } => Row {
            levels: Levels(row.levels.0 & !Levels::Z),
            ..row
        },
        _ => row,
    }
}

fn declared(encoder: &Encoder) -> &'static str {
    match encoder {
        Encoder::Quadrature { .. } => "a quadrature encoder (channels A and B)",
        Encoder::Hall { .. } => "three Hall sensors (channels A, B and C)",
        Encoder::Wheel { .. } => "a toothed wheel (one channel)",
    }
}

fn recorded(channels: Channels) -> &'static str {
    match channels {
        Channels::Quadrature { index: true } => "a quadrature encoder (A, B and Z)",
        Channels::Quadrature { index: false } => "a quadrature encoder (A and B)",
        Channels::Hall => "three Hall sensors (A, B and C)",
        Channels::Wheel => "one channel",
        Channels::Pulses => "one channel's pulses",
    }
}

/// Refuses a number of lines that the index, the header, or, where it says nothing, a strong pattern contradicts.
fn check_lines(plan: SensorPlan, survey: &Survey) -> Result<(), OtherEncoder> {
    let counted = match plan.kind {
        SensorKind::Quadrature { .. } => survey.lines(),
        _ => None,
    };
    let noted = noted_lines(&survey.header);
    let (shown, shown_by) = match (counted, noted) {
        (Some(lines), _) => (lines, "the recording's edges between two index pulses make"),
        (None, Some(lines)) => (lines, "the recording's header says"),
        (None, None) => match pattern_lines(plan, survey) {
            Some(lines) => (lines, "the recording's intervals repeat after"),
            None => return Ok(()),
        },
    };
    if shown == plan.lines {
        return Ok(());
    }
    Err(OtherEncoder::Lines {
        declared: plan.lines,
        shown,
        name: plan.kind.line_name(),
        shown_by,
    })
}

/// The number of lines in a header, under the name that the sensor's lines have.
fn noted_lines(header: &Header) -> Option<u32> {
    let wanted = match header.channels {
        Channels::Quadrature { .. } => "lines",
        Channels::Hall => "pole_pairs",
        Channels::Wheel | Channels::Pulses => "teeth",
    };
    let (_, value) = header.notes.iter().find(|(key, _)| key == wanted)?;
    value.parse().ok().filter(|&lines| lines > 0)
}

/// Lines of another encoder that the intervals show beyond doubt: its turn explains nearly all of their scatter, the declared one
/// next to nothing. Less is no proof, as what a rig does besides may repeat too.
fn pattern_lines(plan: SensorPlan, survey: &Survey) -> Option<u32> {
    const NEARLY_ALL: f64 = 0.2;
    const NEXT_TO_NOTHING: f64 = 0.9;
    if plan.gap_edges() > 0 {
        return None;
    }
    let classes = plan.kind.classes();
    let declared = survey.repeat_at(plan.lines.saturating_mul(classes))?;
    let found = survey.repeat(classes)?;
    let proof = found.left < NEARLY_ALL * found.total
        && declared.left > NEXT_TO_NOTHING * declared.total
        && declared.edges % found.edges != 0;
    let edges = u32::try_from(found.edges).ok()?;
    proof.then_some(edges / classes)
}

#[cfg(test)]
mod tests;

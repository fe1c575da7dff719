//! The sensor that a twin declares, held against what a recording shows.

use thiserror::Error;

use crate::diagnose::edges::Sensor;
use crate::recording::{Channels, Header};
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
        "the twin declares {declared} {name} a turn, {shown_by} {shown}; {}give the twin of this rig, or correct it",
        dark(*declared, *shown, name)
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
}

/// What a few lines fewer may be as well.
fn dark(declared: u32, shown: u32, name: &str) -> &'static str {
    match declared.checked_sub(shown) {
        Some(1) if name == "lines" => "if the twin is right, one line gives no edges; else ",
        Some(2) if name == "lines" => "if the twin is right, two lines give no edges; else ",
        _ => "",
    }
}

/// The sensor by which the recording of `survey` is placed as the encoder that its twin declares.
///
/// A recording may hold more than the twin declares, an index that it knows nothing of, never less. One pulse a tooth
/// is enough for a wheel.
///
/// # Errors
/// [`OtherEncoder`].
pub fn sensor(encoder: &Encoder, survey: &Survey) -> Result<Sensor, OtherEncoder> {
    let channels = survey.header.channels;
    let sensor = match (encoder, channels) {
        (&Encoder::Quadrature { lines, index }, Channels::Quadrature { index: recorded }) => {
            let index = match (index, recorded) {
                (false, _) => None,
                (true, false) => return Err(OtherEncoder::NoIndexChannel),
                (true, true) if survey.index_pulses == 0 => return Err(OtherEncoder::NoIndexPulse),
                (true, true) => Some(survey.index_state()),
            };
            Sensor::Quadrature { lines, index }
        }
        (&Encoder::Hall { pole_pairs }, Channels::Hall) => Sensor::Hall { pole_pairs },
        (&Encoder::Wheel { teeth, .. }, Channels::Wheel | Channels::Pulses) => Sensor::Wheel {
            present: (0..teeth).map(|tooth| encoder.is_real(2 * tooth)).collect(),
            both_edges: channels == Channels::Wheel,
        },
        _ => {
            return Err(OtherEncoder::Kind {
                declared: declared(encoder),
                recorded: recorded(channels),
            });
        }
    };
    check_lines(&sensor, survey)?;
    Ok(sensor)
}

/// Turns that a recording without an index pulse may have at the most, where that is less than one: it needs no index to be too short.
#[must_use]
#[allow(clippy::cast_precision_loss)]
pub fn part_of_a_turn(encoder: &Encoder, survey: &Survey) -> Option<f64> {
    let turns = survey.rows as f64 / f64::from(encoder.grid_edges());
    (survey.index_pulses == 0 && turns < 1.0).then_some(turns)
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
fn check_lines(sensor: &Sensor, survey: &Survey) -> Result<(), OtherEncoder> {
    let (counted, declared, classes, name) = match sensor {
        Sensor::Quadrature { lines, .. } => (survey.lines(), *lines, 4, "lines"),
        Sensor::Hall { pole_pairs } => (None, *pole_pairs, 6, "pole pairs"),
        Sensor::Wheel {
            present,
            both_edges,
        } => (
            None,
            u32::try_from(present.len()).unwrap_or(u32::MAX),
            1 + u32::from(*both_edges),
            "teeth",
        ),
    };
    let gaps = matches!(sensor, Sensor::Wheel { present, .. } if present.contains(&false));
    let noted = noted_lines(&survey.header);
    let (shown, shown_by) = match (counted, noted) {
        (Some(lines), _) => (lines, "the recording's edges between two index pulses make"),
        (None, Some(lines)) => (lines, "the recording's header says"),
        (None, None) if gaps => return Ok(()),
        (None, None) => match pattern_lines(declared, classes, survey) {
            Some(lines) => (lines, "the recording's intervals repeat after"),
            None => return Ok(()),
        },
    };
    if shown == declared {
        return Ok(());
    }
    Err(OtherEncoder::Lines {
        declared,
        shown,
        name,
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
fn pattern_lines(declared: u32, classes: u32, survey: &Survey) -> Option<u32> {
    const NEARLY_ALL: f64 = 0.2;
    const NEXT_TO_NOTHING: f64 = 0.9;
    let declared = survey.repeat_at(declared.saturating_mul(classes))?;
    let found = survey.repeat(classes)?;
    let proof = found.left < NEARLY_ALL * found.total
        && declared.left > NEXT_TO_NOTHING * declared.total
        && declared.edges % found.edges != 0;
    let edges = u32::try_from(found.edges).ok()?;
    proof.then_some(edges / classes)
}

#[cfg(test)]
mod tests;

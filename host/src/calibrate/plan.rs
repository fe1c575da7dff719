//! What sensor a recording is of: what was declared, held against what the recording shows.

use super::{CalibrateError, CalibrateOptions};
use crate::recording::{Channels, Header};
use crate::sensor::{SensorKind, SensorPlan};
use crate::survey::Survey;

/// Where the number of lines comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LinesFrom {
    /// It was declared, by an option or a twin.
    Declared,
    /// The edges between index pulses were counted.
    Index,
    /// The recording's header says it: `lines`, `pole_pairs` or `teeth`.
    Header,
    /// It was guessed from how the intervals repeat.
    Pattern,
}

impl LinesFrom {
    /// Its name in files.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::Declared => "declared",
            Self::Index => "index",
            Self::Header => "header",
            Self::Pattern => "pattern",
        }
    }

    /// Of a recording as [`plan`] takes it.
    #[must_use]
    pub fn of(survey: &Survey, options: &CalibrateOptions) -> Self {
        if options.lines.is_some() {
            Self::Declared
        } else if survey.lines().is_some() {
            Self::Index
        } else if header_lines(&survey.header).is_some() {
            Self::Header
        } else {
            Self::Pattern
        }
    }
}

/// The number of lines that a recording's header gives, under the name that the sensor's lines have.
fn header_lines(header: &Header) -> Option<u32> {
    let wanted = match header.channels {
        Channels::Quadrature { .. } => "lines",
        Channels::Hall => "pole_pairs",
        Channels::Wheel | Channels::Pulses => "teeth",
    };
    let (_, value) = header.notes.iter().find(|(key, _)| key == wanted)?;
    value.parse().ok().filter(|&lines| lines > 0)
}

/// The sensor that a survey shows, checked against what was declared.
///
/// # Errors
/// [`CalibrateError`] when the index or the number of lines is missing or contradicts the declaration.
pub fn plan(survey: &Survey, options: &CalibrateOptions) -> Result<SensorPlan, CalibrateError> {
    match survey.header.channels {
        Channels::Quadrature { .. } => {
            let indexed = survey.index_pulses > 0;
            if !indexed && !options.without_index {
                return Err(CalibrateError::NoIndex { rows: survey.rows });
            }
            let lines = match (options.lines, survey.lines()) {
                (Some(given), Some(likely)) if given != likely => {
                    return Err(CalibrateError::WrongLines { given, likely });
                }
                (Some(lines), _) | (None, Some(lines)) => lines,
                (None, None) => header_lines(&survey.header).ok_or(CalibrateError::LinesUnknown)?,
            };
            let index_state = indexed.then(|| survey.index_state());
            Ok(SensorPlan {
                kind: SensorKind::Quadrature { index_state },
                lines,
            })
        }
        channels => plan_by_pattern(
            survey,
            SensorKind::of(channels, None, options.missing),
            options.lines.or_else(|| header_lines(&survey.header)),
        ),
    }
}

/// A sensor without an index: its turn is the one after which the intervals repeat.
fn plan_by_pattern(
    survey: &Survey,
    kind: SensorKind,
    given: Option<u32>,
) -> Result<SensorPlan, CalibrateError> {
    let classes = kind.classes();
    // A gap is no interval like the others; the decoder finds the turn by it.
    let gap = matches!(kind, SensorKind::Wheel { missing: 1.., .. });
    let found = if gap { None } else { survey.repeat(classes) };
    let likely = found
        .and_then(|repeat| u32::try_from(repeat.edges).ok())
        .map(|edges| edges / classes);
    let lines = match (given, likely) {
        (Some(given), Some(likely)) if given % likely != 0 => {
            let fits = survey
                .repeat_at(given.saturating_mul(classes))
                .is_some_and(|repeat| found.is_none_or(|found| repeat.left < 1.5 * found.left));
            if !fits {
                return Err(CalibrateError::WrongTurn {
                    given,
                    likely,
                    classes,
                    name: kind.line_name(),
                });
            }
            given
        }
        (Some(lines), _) | (None, Some(lines)) => lines,
        (None, None) => return Err(CalibrateError::LinesUnknown),
    };
    Ok(SensorPlan { kind, lines })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::Simulation;
    use crate::twin::Twin;

    /// A survey of the example of three Hall sensors, whose noise repeats better after 14 pole pairs than after its two.
    fn hall(notes: impl Fn(&mut Vec<(String, String)>)) -> Survey {
        let twin = Twin::parse(include_str!("../../twins/hall.toml"), "hall.toml").unwrap();
        let simulation = Simulation::new(&twin).unwrap();
        let mut header = simulation.header();
        notes(&mut header.notes);
        Survey::of(header, simulation.map(|event| Ok(event.row))).unwrap()
    }

    #[test]
    fn a_header_goes_before_a_guess_and_an_option_before_both() {
        let lines = |survey: &Survey, given| {
            let options = CalibrateOptions {
                lines: given,
                ..CalibrateOptions::default()
            };
            let lines = plan(survey, &options).unwrap().lines;
            (lines, LinesFrom::of(survey, &options))
        };
        let survey = hall(|_| ());
        assert_eq!(lines(&survey, None), (2, LinesFrom::Header));
        assert_eq!(lines(&survey, Some(14)), (14, LinesFrom::Declared));
        let silent = hall(|notes| notes.retain(|(key, _)| key != "pole_pairs"));
        assert_eq!(lines(&silent, None).1, LinesFrom::Pattern);
        let nonsense = hall(|notes| {
            notes
                .iter_mut()
                .filter(|(key, _)| key == "pole_pairs")
                .for_each(|(_, value)| "two".clone_into(value));
        });
        assert_eq!(lines(&nonsense, None).1, LinesFrom::Pattern);
    }
}

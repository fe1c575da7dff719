//! What sensor a recording is of: what was declared, held against what the recording shows.

use super::{CalibrateError, CalibrateOptions};
use crate::recording::Channels;
use crate::sensor::{SensorKind, SensorPlan};
use crate::survey::Survey;

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
                (None, None) => return Err(CalibrateError::LinesUnknown),
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
            options.lines,
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

//! The first way through the recordings: what each is, and whether they go together.

use crate::calibrate::{self, CalibrateOptions, Disagreement};
use crate::cli::Globals;
use crate::cli::failure::Failure;
use crate::cli::input::InputArgs;
use crate::cli::progress::Pass;
use crate::free_run::FreeRun;
use crate::recording::Channels;
use crate::sensor::SensorPlan;
use crate::survey::Survey;

use super::Calibrate;

/// A recording that was looked through once.
pub(super) struct Surveyed {
    pub(super) input: InputArgs,
    pub(super) survey: Survey,
    pub(super) plan: SensorPlan,
    pub(super) options: CalibrateOptions,
    pub(super) source: u32,
    /// The recording that a free shaft would have made, where a loop is undone.
    pub(super) free: Option<FreeRun>,
}

impl Calibrate {
    /// Looks through all recordings: what they are, and whether they go together.
    pub(super) fn survey(&self, globals: Globals) -> Result<Vec<Surveyed>, Failure> {
        let inputs: Vec<InputArgs> = self
            .recordings
            .iter()
            .map(|path| self.reading.of(path))
            .collect();
        for input in &inputs {
            self.spare(input)?;
            input.check_regular()?;
        }
        let mut pass = self.pass("Reading", globals);
        let mut surveyed: Vec<Surveyed> = Vec::new();
        for input in inputs {
            let one = self.survey_one(input, &mut pass)?;
            for other in &surveyed {
                together(&one, other)?;
            }
            surveyed.push(one);
        }
        self.check_no_index(&surveyed)?;
        Ok(surveyed)
    }

    fn survey_one(&self, input: InputArgs, pass: &mut Pass) -> Result<Surveyed, Failure> {
        let rows = pass.watch(input.open()?);
        let header = rows.recording().header.clone();
        let source = input.source()?;
        let mut options = self.sensor.options(&input.recording, header.channels)?;
        options.turns = self.turns;
        options.goal = self.goal.map(calibrate::goal_of);
        options.without_index |= self.no_index;
        let mut survey = Survey::of(header, rows)?;
        let plan = calibrate::plan(&survey, &options)
            .map_err(|error| self.failed(&input.recording, error))?;
        let twin = self.sensor.twin()?;
        let header = &survey.header;
        let free = self
            .speed_loop
            .free_run(&input, twin.as_ref(), header, plan, self.inertia)?;
        if let Some(free) = &free {
            survey = free.survey(survey);
        }
        options.until = self
            .fraction
            .map(|fraction| part_of(survey.first, survey.last, fraction));
        Ok(Surveyed {
            input,
            survey,
            plan,
            options,
            source,
            free,
        })
    }
}

impl Calibrate {
    /// Refuses `--no-index` where every recording ties its edges to the disc, or never could.
    fn check_no_index(&self, surveyed: &[Surveyed]) -> Result<(), Failure> {
        let useless = |one: &Surveyed| {
            let survey = &one.survey;
            let quadrature = matches!(survey.header.channels, Channels::Quadrature { .. });
            match (quadrature, survey.index_pulses) {
                (true, 0) => None,
                (true, _) => {
                    Some("has an index, and a table that rests on it holds for every recording")
                }
                (false, _) => Some("is not of a quadrature encoder, which alone may have an index"),
            }
        };
        let all: Option<Vec<&str>> = surveyed.iter().map(useless).collect();
        match (self.no_index, surveyed.first(), all.as_deref()) {
            (true, Some(first), Some([why, ..])) => Err(Failure::Useless {
                option: "--no-index",
                recording: first.input.recording.clone(),
                why,
            }),
            _ => Ok(()),
        }
    }
}

/// Refuses two recordings that are not of one encoder, or are one recording.
fn together(this: &Surveyed, other: &Surveyed) -> Result<(), Failure> {
    let sensor = |one: &Surveyed| (one.plan, one.survey.header.clock_hz);
    let agreed = if this.source == other.source {
        Err(Disagreement::Same)
    } else {
        calibrate::agree(sensor(this), sensor(other))
    };
    agreed.map_err(|source| Failure::Together {
        this: this.input.recording.clone(),
        other: other.input.recording.clone(),
        source,
    })
}

/// The tick at a fraction 0..=1 of the way from `first` to `last`.
#[allow(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss
)]
fn part_of(first: u64, last: u64, fraction: f64) -> u64 {
    first + ((last - first) as f64 * fraction).round() as u64
}

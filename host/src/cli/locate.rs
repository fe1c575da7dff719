//! `quadcal locate`: whether the shaft's place is found in a table without the index.

use clap::Args;
use quadcal::slot::Slot;
use serde::Serialize;

use crate::calibrate::{self, CalibrateError, CalibrateOptions};
use crate::locate::{End, Located, locate};
use crate::recording::{Channels, Row};
use crate::sensor::SensorPlan;
use crate::survey::Survey;
use crate::verify::VerifyError;

use super::failure::Failure;
use super::input::InputArgs;
use super::output::{Facts, JsonArg};
use super::table_arg::TableArg;
use super::{EXIT_CODES, Globals};

const EXAMPLES: &str = "\
Examples:
  quadcal locate spindle.csv --table spindle.qct
  quadcal locate today.csv --table spindle.qct --starts 1000 --json -

Starts at places spread over the recording as a drive does after power-up, without looking at the
index: the line position errors tell where in the table the shaft is, or that the table is of
another disc. The travel needed is that of a drive that spends 20,000 instructions on the search at
every edge. On the recording that the table was learned from, only later edges are used. Exit code 1
means that the table is of another disc, that the index is not where the table has it, or that no
place was found.

";

/// Find the place in an error table without the index, or refuse the table
#[derive(Debug, Args)]
#[command(after_help = [EXAMPLES, EXIT_CODES].concat())]
pub struct Locate {
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    table: TableArg,
    /// Places to start at
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    starts: u32,
    #[command(flatten)]
    json: JsonArg,
}

/// The result, as in the JSON.
#[derive(Debug, Serialize)]
struct Summary {
    file: String,
    table: String,
    same_recording: bool,
    starts: usize,
    found: usize,
    agree_with_index: usize,
    disagree_with_index: usize,
    refused: usize,
    undecided: usize,
    error_probability: f64,
    degrees_median: Option<f64>,
    degrees_most: Option<f64>,
}

impl Locate {
    /// Starts everywhere and prints what was found; fails where the table must not be applied.
    pub fn run(self, globals: Globals) -> Result<(), Failure> {
        if let Some(target) = &self.json.json {
            self.input.spare(target)?;
        }
        self.input.check_regular()?;
        let bytes = self.table.read()?;
        let source = self.input.source()?;
        let slot = self.table.parse(&bytes, source)?;
        let rows = self.input.rows(globals)?;
        let header = rows.recording().header.clone();
        let survey = Survey::of(header, rows)?;
        let plan = self.plan(&survey, &slot)?;
        let rows: Vec<Row> = self.input.rows(globals)?.collect::<Result<_, _>>()?;
        let located = locate(&slot, plan, source, &rows, self.starts as usize)
            .map_err(|error| Failure::locating(&self.input.recording, self.table.path(), error))?;
        let summary = self.summary(&located);
        self.json.write(&summary, &summary.facts())?;
        self.judge(&summary)
    }

    /// The sensor: as the table has it, if the recording agrees.
    fn plan(&self, survey: &Survey, slot: &Slot<'_>) -> Result<SensorPlan, Failure> {
        let path = &self.input.recording;
        let shape = slot.header.shape;
        let other = |recording, recording_classes| {
            let error = VerifyError::Shape {
                table: shape.edges(),
                table_classes: shape.classes(),
                recording,
                recording_classes,
            };
            Failure::verifying(path, self.table.path(), error)
        };
        let quadrature = matches!(survey.header.channels, Channels::Quadrature { .. });
        if quadrature != (shape.classes() == 4) {
            let classes = crate::sensor::SensorKind::of(survey.header.channels, None, 0).classes();
            let lines = survey.lines().unwrap_or(0);
            return Err(other(classes * lines, classes));
        }
        let options = CalibrateOptions {
            lines: Some(shape.lines()),
            without_index: true,
            ..CalibrateOptions::default()
        };
        calibrate::plan(survey, &options).map_err(|error| match error {
            CalibrateError::WrongLines { likely, .. } => other(4 * likely, 4),
            error => Failure::calibrating(path, None, error),
        })
    }

    fn summary(&self, located: &Located) -> Summary {
        let found = |end| matches!(end, End::Found { .. });
        let agrees = |wanted| {
            located.count(|end| matches!(end, End::Found { agrees, .. } if agrees == Some(wanted)))
        };
        let degrees = located.degrees(|end| end != End::Open);
        Summary {
            file: self.input.recording.display().to_string(),
            table: self.table.to_string(),
            same_recording: located.same_recording,
            starts: located.starts.len(),
            found: located.count(found),
            agree_with_index: agrees(true),
            disagree_with_index: agrees(false),
            refused: located.count(|end| matches!(end, End::OtherDisc { .. })),
            undecided: located.count(|end| end == End::Open),
            error_probability: located.doubt(),
            degrees_median: degrees.get(degrees.len() / 2).copied(),
            degrees_most: degrees.last().copied(),
        }
    }

    fn judge(&self, summary: &Summary) -> Result<(), Failure> {
        let table = self.table.path().to_owned();
        let (refused, starts) = (summary.refused, summary.starts);
        if refused > 0 {
            return Err(Failure::OtherDisc {
                table,
                refused,
                starts,
            });
        }
        if summary.disagree_with_index > 0 {
            return Err(Failure::IndexMoved {
                table,
                moved: summary.disagree_with_index,
                starts,
            });
        }
        if summary.found == 0 {
            return Err(Failure::NoPlace { table, starts });
        }
        Ok(())
    }
}

impl Summary {
    fn facts(&self) -> Facts {
        let mut facts = Facts::default();
        let later = if self.same_recording {
            ", on edges that the table was not learned from"
        } else {
            ""
        };
        facts
            .push("Recording", &self.file)
            .push("Table", &self.table)
            .push("Starts", format!("{}{later}", self.starts))
            .push(
                "Found",
                format!(
                    "{} ({} agree with the index, {} do not, {} can't be checked)",
                    self.found,
                    self.agree_with_index,
                    self.disagree_with_index,
                    self.found - self.agree_with_index - self.disagree_with_index
                ),
            )
            .push("Refused as another disc's", self.refused)
            .push("Undecided", self.undecided);
        if let (Some(median), Some(most)) = (self.degrees_median, self.degrees_most) {
            facts
                .push(
                    "Travel needed",
                    format!("{median:.2} degrees (median), {most:.2} at the most"),
                )
                .push(
                    "Error probability stated",
                    format!("at most {:.1e} a start", self.error_probability),
                );
        }
        facts
    }
}

//! `quadcal verify`: whether a table makes its encoder better.

use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

use clap::Args;
use quadcal::slot::SlotHeader;
use serde::Serialize;

use crate::calibrate::{self, CalibrateError};
use crate::delays::{ClassDelay, class_delays, describe};
use crate::recording::Header;
use crate::report::si;
use crate::reports::verify as page;
use crate::sensor::{SensorKind, SensorPlan};
use crate::survey::Survey;
use crate::verify::{Reference, Verdict, Verification, VerifyError, verify};

use super::failure::Failure;
use super::footer::footer;
use super::input::InputArgs;
use super::output::{Facts, JsonArg, ReportArg, spare};
use super::sensor_args::SensorArgs;
use super::table_arg::TableArg;
use super::{EXIT_CODES, Globals};

const EXAMPLES: &str = "\
Examples:
  quadcal verify spindle.csv --table spindle.qct
  quadcal verify rig.csv --table rig.qct --reference ref.csv --ratio 8 --report rig.html

On the recording that the table was learned from, only later turns are looked at. Without a reference the scatter of the speed from
edge to edge decides. A reference is CSV with time (s, on the recording's clock) and angle_rad, and turns RATIO times as fast
as the encoder: equations (21) and (22). Exit code 1 means that the table makes the encoder worse
or is of another disc.

";

/// Check an error table on turns it was not learned from
#[derive(Debug, Args)]
#[command(after_help = [EXAMPLES, EXIT_CODES].concat())]
pub struct Verify {
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    table: TableArg,
    /// Angles of a reference encoder: CSV with time (s) and angle_rad
    #[arg(long, value_name = "REF", help_heading = "Reference")]
    reference: Option<PathBuf>,
    /// Turns of the reference for each turn of the encoder; negative if it turns the other way
    #[arg(
        long,
        value_name = "R",
        default_value = "1",
        value_parser = ratio,
        allow_negative_numbers = true,
        requires = "reference",
        help_heading = "Reference"
    )]
    ratio: f64,
    #[command(flatten)]
    sensor: SensorArgs,
    #[command(flatten)]
    report: ReportArg,
    #[command(flatten)]
    json: JsonArg,
}

/// A ratio that can be divided by.
pub(super) fn ratio(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value != 0.0 => Ok(value),
        _ => Err("give a finite number other than 0".to_owned()),
    }
}

/// The result, as in the JSON.
#[derive(Debug, Serialize)]
struct Summary {
    file: String,
    table: String,
    verdict: &'static str,
    same_recording: bool,
    /// How much of the table's line pattern the recording shows: 1 for its disc, 0 for another; null where the pattern is too weak.
    pattern_found: Option<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    delays: Vec<ClassDelay>,
    intervals: u64,
    scatter_before: f64,
    scatter_after: f64,
    reference: Option<ReferenceSummary>,
}

#[derive(Debug, Serialize)]
struct ReferenceSummary {
    edges: u64,
    rmse_before_rad: f64,
    rmse_after_rad: f64,
}

impl Verify {
    /// Checks, writes the results, and fails where the table makes things worse.
    pub fn run(self, globals: Globals) -> Result<(), Failure> {
        let outputs = [self.report.report.as_ref(), self.json.json.as_ref()];
        spare(&outputs, &self.input.recording)?;
        self.input.check_regular()?;
        let bytes = self.table.read()?;
        let source = self.input.source()?;
        let slot = self.table.parse(&bytes, source)?;
        let reference = self.read_reference()?;
        let path = &self.input.recording;
        let rows = self.input.rows(globals)?;
        let header = rows.recording().header.clone();
        let survey = Survey::of(header.clone(), rows)?;
        let plan = self.plan(&survey, &header, &slot.header)?;
        let rows = self.input.rows(globals)?;
        let check = verify(&slot, plan, source, header.clock_hz, rows, reference)
            .and_then(|check| check.check_whole_turn().map(|()| check))
            .map_err(|error| self.failed(error))?;
        if let (Some(reference), None) = (&self.reference, &check.reference) {
            return Err(Failure::Apart {
                reference: reference.display().to_string(),
            });
        }
        if let Some(target) = &self.report.report {
            let mut inputs = vec![path.as_path(), self.table.path()];
            inputs.extend(self.reference.as_deref());
            let (name, table) = (path.display().to_string(), self.table.to_string());
            let page = page::report(&name, &table, &check, footer(&inputs)?);
            target.write_report(&page)?;
        }
        let delays = class_delays(plan.kind, &slot.header.delays);
        let facts = self.facts(&check, &delays);
        let summary = self.summary(&check, delays);
        self.json.write_beside(&outputs, &summary, &facts)?;
        self.judge(&check)
    }

    /// A check's error, by the file that it is about.
    fn failed(&self, error: VerifyError) -> Failure {
        let file = match (&error, &self.reference) {
            (VerifyError::ReferenceMisfit { .. }, Some(reference)) => reference,
            _ => &self.input.recording,
        };
        Failure::verifying(file, self.table.path(), error)
    }

    fn read_reference(&self) -> Result<Option<Reference>, Failure> {
        let Some(path) = &self.reference else {
            return Ok(None);
        };
        let file = File::open(path).map_err(|source| Failure::Open {
            path: path.clone(),
            source,
        })?;
        let name = path.display().to_string();
        Ok(Some(Reference::read(
            BufReader::new(file),
            &name,
            self.ratio,
        )?))
    }

    /// The sensor: as declared, or else as the table has it, if the recording agrees.
    fn plan(
        &self,
        survey: &Survey,
        header: &Header,
        table: &SlotHeader,
    ) -> Result<SensorPlan, Failure> {
        let (path, twin) = (&self.input.recording, self.sensor.twin.as_deref());
        let mut options = self.sensor.options(path, header.channels)?;
        options.without_index |= !table.indexed;
        let declared = options.lines.is_some();
        options.lines = options.lines.or(Some(table.shape.lines()));
        calibrate::plan(survey, &options).map_err(|error| match error {
            CalibrateError::WrongLines { likely, .. }
            | CalibrateError::WrongTurn { likely, .. }
                if !declared =>
            {
                let classes = SensorKind::of(header.channels, None, options.missing).classes();
                let error = VerifyError::Shape {
                    table: table.shape.edges(),
                    table_classes: table.shape.classes(),
                    recording: likely * classes,
                    recording_classes: classes,
                };
                Failure::verifying(path, self.table.path(), error)
            }
            error => Failure::calibrating(path, twin, error),
        })
    }

    fn summary(&self, check: &Verification, delays: Vec<ClassDelay>) -> Summary {
        Summary {
            file: self.input.recording.display().to_string(),
            table: self.table.to_string(),
            verdict: match check.verdict() {
                Verdict::Better => "better",
                Verdict::Same => "same",
                Verdict::Worse => "worse",
                Verdict::OtherDisc => "other_disc",
            },
            same_recording: check.same_recording,
            pattern_found: check.pattern.map(|pattern| pattern.share),
            delays,
            intervals: check.scatter.intervals,
            scatter_before: check.scatter.before,
            scatter_after: check.scatter.after,
            reference: check.reference.as_ref().map(|reference| ReferenceSummary {
                edges: reference.edges,
                rmse_before_rad: reference.before_rad,
                rmse_after_rad: reference.after_rad,
            }),
        }
    }

    fn facts(&self, check: &Verification, delays: &[ClassDelay]) -> Facts {
        let mut facts = Facts::default();
        facts
            .push("Recording", self.input.recording.display())
            .push("Table", &self.table)
            .push("Checked on", page::turns_used(check));
        if let Some(delays) = describe(delays) {
            facts.push("Delays in the table", delays);
        }
        facts.push(
            "Scatter of the speed, RMS",
            format!(
                "{:.4} % before, {:.4} % after ({} intervals)",
                100.0 * check.scatter.before,
                100.0 * check.scatter.after,
                check.scatter.intervals
            ),
        );
        if let Some(reference) = &check.reference {
            facts.push(
                "Error against reference, RMSE",
                format!(
                    "{} before, {} after ({} edges)",
                    si(reference.before_rad, "rad"),
                    si(reference.after_rad, "rad"),
                    reference.edges
                ),
            );
        }
        facts.push("Verdict", page::headline(check));
        facts
    }

    fn judge(&self, check: &Verification) -> Result<(), Failure> {
        match (check.verdict(), check.pattern) {
            (Verdict::Worse, _) => {}
            (Verdict::OtherDisc, Some(pattern)) => {
                return Err(Failure::OtherPattern {
                    table: self.table.path().to_owned(),
                    share: pattern.share,
                });
            }
            _ => return Ok(()),
        }
        let (what, before, after) = page::compared(check);
        let text = |value: f64| match check.reference {
            Some(_) => si(value, "rad").replace('\u{a0}', " "),
            None => format!("{:.4} %", 100.0 * value),
        };
        Err(Failure::Worse {
            table: self.table.path().to_owned(),
            what,
            before: text(before),
            after: text(after),
        })
    }
}

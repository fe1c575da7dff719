//! `quadcal calibrate`: from a recording to an error table.

use clap::{Args, value_parser};

use crate::calibrate::{self, Calibration};
use crate::findings::Findings;
use crate::free_run;
use crate::report::Report;
use crate::reports;
use crate::showcase::{Showcase, showcase};
use crate::survey::Survey;
use crate::table_file;

use super::calibrate_summary::Summary;
use super::failure::Failure;
use super::footer::footer;
use super::input::InputArgs;
use super::loop_args::{LoopArgs, remark_gains};
use super::output::{JsonArg, ReportArg, Target};
use super::sensor_args::SensorArgs;
use super::{EXIT_CODES, Globals};

const EXAMPLES: &str = "\
Examples:
  quadcal calibrate spindle.csv -o spindle.qct --report spindle.html
  quadcal calibrate rig.csv --turns 11 -o rig.qct         leaves later turns to verify on
  quadcal calibrate hall.csv --fraction 0.5 -o hall.qct   learns from the first half
  quadcal calibrate axis.csv --twin axis.toml -o axis.qct undoes the speed loop in axis.toml
  quadcal calibrate crank.csv --lines 60 --missing 2 -o crank.qct

Let the shaft turn at a steady speed, in torque or voltage mode: a stiff speed loop hides the encoder's low orders. Where it must be \
on, give a twin with its gains, or record the torque (--torque): then what it did is undone. Orders that one speed can't tell from \
torque ripple are left alone and listed.

";

/// Learn an encoder's own errors from a recording and write them as an error table
#[derive(Debug, Args)]
#[command(after_help = [EXAMPLES, EXIT_CODES].concat())]
pub struct Calibrate {
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    sensor: SensorArgs,
    /// Calibrate a quadrature encoder without index: the table then holds for this recording only
    #[arg(long, help_heading = "Sensor")]
    no_index: bool,
    /// Learn from this many turns at most
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(3..), conflicts_with = "fraction", help_heading = "Learning")]
    turns: Option<u32>,
    /// Learn from this first part of the recording, 0 to 1
    #[arg(long, value_name = "F", value_parser = fraction, help_heading = "Learning")]
    fraction: Option<f64>,
    /// Error table to write, as the bytes of one flash slot
    #[arg(short, long, value_name = "TABLE", help_heading = "Results")]
    output: Target,
    /// Write the table as CSV too: edge,class,error_rad,standard_error_rad
    #[arg(long, value_name = "PATH", help_heading = "Results")]
    csv: Option<Target>,
    #[command(flatten)]
    speed_loop: LoopArgs,
    #[command(flatten)]
    report: ReportArg,
    #[command(flatten)]
    json: JsonArg,
}

fn fraction(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= 1.0 => Ok(value),
        _ => Err("give a number above 0 and up to 1".to_owned()),
    }
}

impl Calibrate {
    /// Learns and writes everything that was asked for; nothing is written before all of it is known.
    pub fn run(self, globals: Globals) -> Result<(), Failure> {
        let outputs = [
            Some(&self.output),
            self.csv.as_ref(),
            self.report.report.as_ref(),
            self.json.json.as_ref(),
        ];
        for target in outputs.into_iter().flatten() {
            self.input.spare(target)?;
        }
        let path = &self.input.recording;
        let failed = |error| Failure::calibrating(path, self.sensor.twin.as_deref(), error);
        self.input.check_regular()?;
        let rows = self.input.rows(globals)?;
        let source = self.input.source()?;
        let header = rows.recording().header.clone();
        let mut options = self.sensor.options(header.channels)?;
        options.turns = self.turns;
        options.without_index |= self.no_index;
        let mut survey = Survey::of(header, rows)?;
        let plan = calibrate::plan(&survey, &options).map_err(failed)?;
        let twin = self.sensor.twin()?;
        let free =
            self.speed_loop
                .free_run(&self.input, twin.as_ref(), &survey.header, plan, globals)?;
        if let Some(free) = &free {
            survey = free.survey(survey);
        }
        options.until = self
            .fraction
            .map(|fraction| part_of(survey.first, survey.last, fraction));
        let reopen = || {
            let rows = self.input.reopen(globals)?;
            Ok(free_run::rows(free.as_ref(), rows))
        };
        let mut calibration =
            calibrate::learn(survey, plan, reopen()?, &options).map_err(failed)?;

        let findings = Findings::of(&calibration);
        let shown = showcase(&calibration, reopen)
            .map_err(|error| Failure::verifying(path, path, error))?;
        if let Some(free) = &free {
            // What reads the table counts in the recording's own ticks.
            calibration.learned_until = free.recorded(calibration.learned_until);
            remark_gains(free, globals);
        } else {
            self.speed_loop.remark_hidden(&calibration, globals);
        }
        let summary = Summary::new(path, &calibration, &findings, &shown);
        let page = match &self.report.report {
            Some(_) => Some(self.page(&calibration, &findings, &shown)?),
            None => None,
        };
        self.output
            .write(&table_file::bytes_of(&calibration, source))?;
        if let Some(target) = &self.csv {
            target.write(table_file::csv_of(&findings).as_bytes())?;
        }
        if let (Some(target), Some(page)) = (&self.report.report, page) {
            target.write_report(&page)?;
        }
        self.json.write(&summary, &summary.facts(&self.output))
    }

    fn page(
        &self,
        calibration: &Calibration,
        findings: &Findings,
        shown: &Showcase,
    ) -> Result<Report, Failure> {
        let path = &self.input.recording;
        Ok(reports::calibrate::report(
            &path.display().to_string(),
            calibration,
            findings,
            shown,
            footer(&[path])?,
        ))
    }
}

/// The tick at a fraction 0..=1 of the way from `first` to `last`.
#[allow(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss
)]
pub(super) fn part_of(first: u64, last: u64, fraction: f64) -> u64 {
    first + ((last - first) as f64 * fraction).round() as u64
}

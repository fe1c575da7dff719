//! `quadcal calibrate`: from recordings of one encoder to its error table.

mod surveyed;

use std::path::{Path, PathBuf};

use clap::{Args, value_parser};
use quadcal::estimate::{DriveKnowledge, Totals};

use crate::calibrate::{CalibrateError, Calibration, Learner, RecordingUse};
use crate::findings::Findings;
use crate::free_run::{self, FreeRun};
use crate::report::Report;
use crate::reports;
use crate::reports::calibrate::Calibrated;
use crate::showcase::showcase;
use crate::table_file;

use super::calibrate_facts::facts;
use super::calibrate_summary::Summary;
use super::failure::Failure;
use super::footer::footer;
use super::input::{InputArgs, ReadingArgs};
use super::loop_args::{LoopArgs, remark_gains};
use super::output::{JsonArg, ReportArg, Target, spare};
use super::progress::Pass;
use super::sensor_args::SensorArgs;
use super::{EXIT_CODES, Globals};
use surveyed::Surveyed;

const EXAMPLES: &str = "\
Examples:
  quadcal calibrate spindle.csv -o spindle.qct --report spindle.html
  quadcal calibrate slow.csv fast.csv -o spindle.qct      tells torque ripple and delays apart
  quadcal calibrate slow.csv fast.csv --inertia 1.2e-4 -o spindle.qct    gives the ripple in N m
  quadcal calibrate long.csv --goal 5e-6 -o rig.qct       no more turns than it takes
  quadcal calibrate rig.csv --pole-pairs 5 -o rig.qct     one speed; only the motor makes torque
  quadcal calibrate rig.csv --turns 11 -o rig.qct         leaves later turns to verify on
  quadcal calibrate hall.csv --fraction 0.5 -o hall.qct   learns from the first half
  quadcal calibrate axis.csv --twin axis.toml -o axis.qct undoes the speed loop in axis.toml
  quadcal calibrate crank.csv --lines 60 --missing 2 -o crank.qct

Two speeds are best, one half as fast again as the other or more: in one recording, or in two of the
same encoder and timer, with an index to tie them together. Orders that one speed can't tell from
torque ripple are left alone and listed. Drive the shaft in torque or voltage mode: a stiff speed
loop hides the encoder's low orders. Where it must be on, give a twin with its gains, or record the
torque (--torque): then what it did is undone.

";

/// Learn an encoder's own errors from recordings and write them as an error table
#[derive(Debug, Args)]
#[command(after_help = [EXAMPLES, EXIT_CODES].concat())]
pub struct Calibrate {
    /// Recordings of one encoder's edges: native CSV, logic-analyser CSV, VCD, or one column of seconds
    #[arg(value_name = "REC", required = true)]
    recordings: Vec<PathBuf>,
    #[command(flatten)]
    reading: ReadingArgs,
    #[command(flatten)]
    sensor: SensorArgs,
    /// Calibrate a quadrature encoder without index: the table then holds for this recording only
    #[arg(long, help_heading = "Sensor")]
    no_index: bool,
    /// Learn from this many turns of each recording at most
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(3..), conflicts_with = "fraction", help_heading = "Learning")]
    turns: Option<u32>,
    /// Learn from this first part of each recording, 0 to 1
    #[arg(long, value_name = "F", value_parser = fraction, help_heading = "Learning")]
    fraction: Option<f64>,
    /// Stop learning from a recording once the error to expect is this small, rad RMS, or more turns don't help
    #[arg(long, value_name = "RAD", value_parser = goal, help_heading = "Learning")]
    goal: Option<f64>,
    /// Pole pairs of the motor, where nothing else makes torque: ripple is at multiples of N only
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..), help_heading = "Drive")]
    pole_pairs: Option<u16>,
    /// Leave orders up to N alone, as a speed loop that ran while recording may hide them
    #[arg(long, value_name = "N", help_heading = "Drive")]
    hidden_up_to: Option<u16>,
    /// Inertia of all that turns, for torque ripple in N m and for --torque
    #[arg(long, value_name = "KG_M2", value_parser = inertia, help_heading = "Drive")]
    inertia: Option<f64>,
    #[command(flatten)]
    speed_loop: LoopArgs,
    /// Error table to write, as the bytes of one flash slot
    #[arg(short, long, value_name = "TABLE", help_heading = "Results")]
    output: Target,
    /// Write the table as CSV too: edge,class,error_rad,standard_error_rad
    #[arg(long, value_name = "PATH", help_heading = "Results")]
    csv: Option<Target>,
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

fn goal(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value < 1.0 => Ok(value),
        _ => Err("give a number above 0 and below 1, in rad: 2e-6".to_owned()),
    }
}

fn inertia(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("give a number above 0, in kg m^2".to_owned()),
    }
}

impl Calibrate {
    /// Learns and writes everything that was asked for; nothing is written before all of it is known.
    pub fn run(self, globals: Globals) -> Result<(), Failure> {
        let surveyed = self.survey(globals)?;
        let source = surveyed.first().map_or(0, |first| first.source);
        let mut calibration = self.learn(&surveyed, globals)?;
        let findings = Findings::of(&calibration);
        let mut pass = self.pass("Checking", globals);
        let mut shown = Vec::new();
        for (one, used) in surveyed.iter().zip(&calibration.recordings) {
            let path = &one.input.recording;
            let open = || {
                let rows = pass.watch(one.input.reopen()?);
                Ok(free_run::rows(one.free.as_ref(), rows))
            };
            let check = showcase(&calibration, used, open)
                .map_err(|error| Failure::verifying(path, path, error))?;
            shown.push(check);
        }
        drop(pass);
        for (one, used) in surveyed.iter().zip(&mut calibration.recordings) {
            if let Some(free) = &one.free {
                // What reads the table counts in the recording's own ticks.
                used.learned_until = free.recorded(used.learned_until);
                remark_gains(&one.input.recording, free, globals);
            }
        }
        let names = self.names();
        let calibrated = Calibrated {
            names: &names,
            calibration: &calibration,
            findings: &findings,
            shown: &shown,
            inertia_kg_m2: self.inertia,
        };
        let page = match &self.report.report {
            Some(_) => Some(self.page(&calibrated)?),
            None => None,
        };
        let sources = surveyed.iter().map(|one| one.source);
        let learned = calibration.recordings.iter().map(|used| used.learned_until);
        let marks: Vec<(u32, u64)> = sources.zip(learned).collect();
        let mut table = table_file::bytes_of(&calibration, source);
        table.extend_from_slice(&table_file::marks_of(&marks));
        self.output.write(&table)?;
        if let Some(target) = &self.csv {
            target.write(table_file::csv_of(&findings).as_bytes())?;
        }
        if let (Some(target), Some(page)) = (&self.report.report, page) {
            target.write_report(&page)?;
        }
        let text = facts(&calibrated, &self.output);
        self.json
            .write_beside(&self.outputs(), &Summary::new(&calibrated), &text)
    }

    fn learn(&self, surveyed: &[Surveyed], globals: Globals) -> Result<Calibration, Failure> {
        let all: PathBuf = self.names().join(" and ").into();
        // The command line has one recording at least.
        let Some(first) = surveyed.first() else {
            let none = CalibrateError::TooFewTurns(Totals::default());
            return Err(self.failed(&all, none));
        };
        let clock_hz = first.survey.header.clock_hz;
        let drive = DriveKnowledge {
            torque_base: self.pole_pairs.unwrap_or(0),
            hidden_up_to: 0,
        };
        let mut learner =
            Learner::new(first.plan, clock_hz, drive).map_err(|error| self.failed(&all, error))?;
        if surveyed.len() > 1 {
            learner = learner.comparing_discs();
        }
        let mut pass = self.pass("Learning", globals);
        for one in surveyed {
            let rows = free_run::rows(one.free.as_ref(), pass.watch(one.input.open()?));
            learner
                .add(one.survey.clone(), rows, &one.options)
                .map_err(|error| self.not_learned(&one.input.recording, error))?;
        }
        learner.leave_alone_up_to(self.hidden_up_to(surveyed, &learner));
        let runs: Vec<Option<&FreeRun>> = surveyed.iter().map(|one| one.free.as_ref()).collect();
        let solved = learner.solve().map_err(|error| self.failed(&all, error))?;
        Ok(solved.with_loops_undone(&runs))
    }

    /// The orders that a loop may hide, as said, or at the slowest turn learned from where it is not undone.
    fn hidden_up_to(&self, surveyed: &[Surveyed], learner: &Learner) -> u16 {
        let hidden = |(one, used): (&Surveyed, &RecordingUse)| {
            let shape = one.plan.shape().ok().filter(|_| one.free.is_none())?;
            let slowest = used.slowest_turns_per_s();
            Some(self.speed_loop.hidden(slowest, shape.edges())?.last)
        };
        let recordings = surveyed.iter().zip(learner.recordings());
        let last = recordings.filter_map(hidden).max().unwrap_or(0);
        let found = u16::try_from(last).unwrap_or(u16::MAX);
        self.hidden_up_to.unwrap_or(found)
    }

    fn names(&self) -> Vec<String> {
        let names = self.recordings.iter();
        names.map(|path| path.display().to_string()).collect()
    }

    /// An error of one recording, or of it and one before it.
    fn not_learned(&self, recording: &Path, error: CalibrateError) -> Failure {
        let other = match &error {
            CalibrateError::OtherDisc { other, .. } => self.recordings.get(*other),
            _ => None,
        };
        let Some(other) = other else {
            return self.failed(recording, error);
        };
        let both = format!("{} and {}", other.display(), recording.display());
        self.failed(Path::new(&both), error)
    }

    fn failed(&self, recording: &Path, error: CalibrateError) -> Failure {
        Failure::calibrating(recording, self.sensor.twin.as_deref(), error)
    }

    /// Refuses outputs that would take a recording's place.
    fn spare(&self, input: &InputArgs) -> Result<(), Failure> {
        spare(&self.outputs(), &input.recording)
    }

    fn outputs(&self) -> [Option<&Target>; 4] {
        [
            Some(&self.output),
            self.csv.as_ref(),
            self.report.report.as_ref(),
            self.json.json.as_ref(),
        ]
    }

    /// A way through all recordings.
    fn pass(&self, what: &str, globals: Globals) -> Pass {
        let sizes = self.recordings.iter().map(|path| {
            let found = std::fs::metadata(path);
            found.map(|found| found.len())
        });
        Pass::new(what, sizes.sum::<Result<u64, _>>().ok(), globals)
    }

    fn page(&self, calibrated: &Calibrated<'_>) -> Result<Report, Failure> {
        let paths: Vec<&Path> = self.recordings.iter().map(PathBuf::as_path).collect();
        Ok(reports::calibrate::report(calibrated, footer(&paths)?))
    }
}

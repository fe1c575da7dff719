//! `quadcal twin`: a starting twin from recordings alone.

use std::path::{Path, PathBuf};

use clap::{Args, value_parser};
use serde::Serialize;

use crate::starting_twin::{self, Given, Number, Starting};

use super::failure::Failure;
use super::input::{InputArgs, ReadingArgs};
use super::output::{Facts, JsonArg, Target, spare};
use super::progress::Progress;
use super::staged::Staged;
use super::started::Recordings;
use super::{EXIT_CODES, Globals};

const EXAMPLES: &str = "\
Examples:
  quadcal twin healthy.csv -o healthy.toml           sensor, noise, delays, disc
  quadcal diagnose later.csv --twin healthy.toml     what changed since
  quadcal twin healthy.csv --gears -o healthy.toml   its gears, belts and tones too
  quadcal twin slow.csv fast.csv -o rig.toml         tells torque ripple and delays from the disc
  quadcal twin crank.csv --map 'a=Channel 0' -o crank.toml
  quadcal twin hub.csv --lines 15 -o hub.toml        where the recording does not tell
  quadcal twin spindle.csv -o -                      prints it

Every number has its 95 % interval behind it. What a recording can't make sure is marked '# guess:',
with what would make it sure. The drive is left out: the course of the speed is the recording's
own. To simulate the twin, add a drive and an inertia (quadcal simulate --keys).

";

/// Make a starting twin from recordings alone: sensor, noise, delays, disc
#[derive(Debug, Args)]
#[command(after_help = [EXAMPLES, EXIT_CODES].concat())]
pub struct Twin {
    /// Recordings of one rig: native CSV, logic-analyser CSV, VCD, or one column of seconds
    #[arg(value_name = "REC", required = true)]
    recordings: Vec<PathBuf>,
    #[command(flatten)]
    reading: ReadingArgs,
    /// Lines, pole pairs or teeth (missing ones counted) a turn, if not to be found in the recording
    #[arg(long, value_name = "M", value_parser = value_parser!(u32).range(1..=1_000_000), help_heading = "Sensor")]
    lines: Option<u32>,
    /// Teeth missing at the gap of a toothed wheel of --lines teeth
    #[arg(
        long,
        value_name = "K",
        default_value_t = 0,
        hide_default_value = true,
        requires = "lines",
        help_heading = "Sensor"
    )]
    missing: u32,
    /// Look for gears, belts, bearings and tones too: a diagnosis of each recording, which takes longer
    #[arg(long, help_heading = "Machine")]
    gears: bool,
    /// Twin to write, TOML
    #[arg(short, long, value_name = "TWIN", help_heading = "Results")]
    output: Target,
    /// Where the disc's errors go, CSV; TWIN-errors.csv beside the twin if not given
    #[arg(long, value_name = "PATH", help_heading = "Results")]
    errors: Option<PathBuf>,
    #[command(flatten)]
    json: JsonArg,
}

/// The result, as in the JSON.
#[derive(Debug, Serialize)]
struct Summary {
    version: u32,
    recordings: Vec<String>,
    edges: usize,
    turns: f64,
    seconds: f64,
    speed_r_min: [f64; 2],
    encoder: crate::twin::Encoder,
    numbers: Vec<Number>,
}

impl Twin {
    /// Estimates and writes everything that was asked for; nothing is written before all of it is known.
    pub fn run(self, globals: Globals) -> Result<(), Failure> {
        let errors = self.errors_path();
        self.spare(errors.as_deref())?;
        let inputs: Vec<InputArgs> = self.recordings.iter().map(|r| self.reading.of(r)).collect();
        let given = Given {
            lines: self.lines,
            missing: self.missing,
        };
        let recordings = Recordings::read(&inputs, given, globals)?;
        let mut rhythms = Vec::new();
        if self.gears {
            let mut progress = Progress::share("Looking for gears", globals);
            rhythms = recordings.rhythms(&mut |done, what| progress.at(done, what))?;
        }
        let mut progress = Progress::share("Estimating", globals);
        let starting = recordings.estimate(rhythms, &mut |done, what| progress.at(done, what))?;
        drop(progress);
        self.write(&starting, errors)
    }

    /// The disc's errors go beside the twin; where that is no file they need a name.
    fn errors_path(&self) -> Option<PathBuf> {
        let beside = || {
            let Target::File(twin) = &self.output else {
                return None;
            };
            let stem = twin.file_stem()?.to_string_lossy();
            let regular = std::fs::metadata(twin).map_or(true, |found| found.is_file());
            regular.then(|| twin.with_file_name(format!("{stem}-errors.csv")))
        };
        self.errors.clone().or_else(beside)
    }

    fn spare(&self, errors: Option<&Path>) -> Result<(), Failure> {
        let errors = errors.map(|path| Target::File(path.to_owned()));
        let outputs = [Some(&self.output), errors.as_ref(), self.json.json.as_ref()];
        let mut inputs = self.recordings.iter();
        inputs.try_for_each(|input| spare(&outputs, input))
    }

    fn write(&self, starting: &Starting, errors: Option<PathBuf>) -> Result<(), Failure> {
        let names: Vec<String> = self
            .recordings
            .iter()
            .map(|path| path.display().to_string())
            .collect();
        let list = starting_twin::errors_csv(starting).zip(errors);
        // The twin's folder is what its paths are relative to.
        let named = list.as_ref().map(|(_, path)| match &self.output {
            Target::File(twin) if twin.parent() == path.parent() => {
                path.file_name().map_or_else(|| path.clone(), PathBuf::from)
            }
            _ => std::path::absolute(path).unwrap_or_else(|_| path.clone()),
        });
        let text = starting_twin::text(starting, &names, named.as_deref())?;
        let mut staged = Staged::default();
        if let Some((list, path)) = &list {
            staged.add(Target::File(path.clone()), list.as_bytes())?;
        }
        staged.add(self.output.clone(), text.as_bytes())?;
        if let Some(target) = &self.json.json {
            let summary = Summary {
                version: 1,
                recordings: names,
                edges: starting.edges,
                turns: starting.turns,
                seconds: starting.seconds,
                speed_r_min: starting.speed_r_min,
                encoder: starting.found.encoder.clone(),
                numbers: starting_twin::numbers(starting),
            };
            staged.add(target.clone(), &target.json_of(&summary)?)?;
        }
        staged.commit()?;
        if [Some(&self.output), self.json.json.as_ref()].contains(&Some(&Target::Stdout)) {
            return Ok(());
        }
        let mut facts = Facts::default();
        for (name, value) in starting_twin::lines_of(starting) {
            facts.push(name, value);
        }
        facts.push("Written", &self.output);
        if let Some((_, path)) = &list {
            facts.push("Written", path.display());
        }
        Target::Stdout.write(facts.to_string().as_bytes())
    }
}

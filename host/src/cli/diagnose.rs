//! `quadcal diagnose`: what a twin lacks to explain its recordings.

mod catalogue;
mod encoder;
mod new_twins;
mod rig;

use std::path::{Path, PathBuf};

use clap::Args;

use crate::diagnose::diagnosis::Answer;
use crate::diagnose::pipeline;
use crate::diagnose::rig::{DiagnoseError, Recorded};
use crate::diagnose::write;
use crate::mechanism::Mechanism;
use crate::reports;
use crate::starting_twin::{self, Given};
use crate::twin::Twin;

use super::Globals;
use super::failure::Failure;
use super::footer::footer;
use super::input::ReadingArgs;
use super::output::{Facts, JsonArg, ReportArg, Target, spare};
use super::progress::Progress;
use super::staged::Staged;
use super::started::Recordings;
pub use encoder::OtherEncoder;
use new_twins::{Diagnosed, NewFile};
use rig::Named;

const EXAMPLES: &str = "\
Examples:
  quadcal diagnose rig.csv --twin rig.toml --report rig.html
  quadcal diagnose rig.csv --twin rig.toml --write-twin better.toml    the twin with what it lacked
  quadcal simulate better.toml -o again.csv                            runs it
  quadcal diagnose slow.csv fast.csv --twin slow.toml --twin fast.toml --json -
  quadcal diagnose one.csv two.csv three.csv --twin rig.toml           one twin for all
  quadcal diagnose hub.csv --twin hall.toml                            Hall sensors
  quadcal diagnose rig.csv                                             all it shows, without a twin
  quadcal diagnose --mechanisms                                        what it can name
  quadcal diagnose --mechanisms bearing                                what is known of one

The twin says what is known of the rig: encoder, shaft, drive, noise (quadcal simulate --keys). What
it lacks is searched in every coordinate in which physics leaves a mark, named, fitted on the
earlier turns and judged on the last ones. The verdict is one of

  complete   nothing was found that the twin lacks
  explained  everything that was found has a name
  partly     findings have names, and something else is left
  ambiguous  a finding may be one mechanism or another: the recording that would decide is named
  unknown    something is there, and it is none of the known mechanisms

Two recordings at speeds a factor of two apart, or in both directions, tell most look-alikes apart.

";

/// As of all commands, but whatever the verdict is, it was reached.
const EXIT_CODES: &str = "\
Exit codes:
  0  a verdict was reached, whichever
  1  an output cannot be written
  2  recording, twin or command line are wrong; no output file is written";

/// Find what a twin lacks to explain its recordings, name it, and show that it fits
#[derive(Debug, Args)]
#[command(after_help = [EXAMPLES, EXIT_CODES].concat())]
pub struct Diagnose {
    /// Recordings of one rig: native CSV, logic-analyser CSV, VCD, or one column of seconds
    #[arg(value_name = "REC", required_unless_present = "mechanisms")]
    recordings: Vec<PathBuf>,
    /// Twin that should explain the recordings: once for all, or once for each in the same order; without it one of the sensor alone
    #[arg(long = "twin", value_name = "TWIN")]
    twins: Vec<PathBuf>,
    /// Print what a diagnosis can name, or one mechanism's card, and do nothing else
    #[arg(
        long,
        value_name = "ID",
        num_args = 0..=1,
        value_parser = catalogue::mechanism,
        conflicts_with_all = ["recordings", "twins", "write_twin"]
    )]
    mechanisms: Option<Option<Mechanism>>,
    #[command(flatten)]
    reading: ReadingArgs,
    /// Write the twin with the findings in it; of several recordings the others' get a number (new-2.toml)
    #[arg(long, value_name = "PATH", value_parser = file, help_heading = "Results")]
    write_twin: Option<PathBuf>,
    #[command(flatten)]
    report: ReportArg,
    #[command(flatten)]
    json: JsonArg,
}

/// A name of a file, as a twin may come with a list beside it.
fn file(text: &str) -> Result<PathBuf, String> {
    match text {
        "" | "-" => Err("give the name of a file, as in new.toml".to_owned()),
        _ => Ok(text.into()),
    }
}

/// Recordings beside their twins.
struct GivenRig {
    rig: Vec<Recorded>,
    /// Texts and twins as they were given, one for each recording or one for all.
    declared: Vec<(String, Twin)>,
    /// What is said of a twin that was made.
    said: Vec<(&'static str, String)>,
}

impl Diagnose {
    /// Diagnoses and writes everything that was asked for; nothing is written before all of it is known.
    pub fn run(self, globals: Globals) -> Result<(), Failure> {
        if let Some(one) = self.mechanisms {
            return Target::Stdout.write(catalogue::text(one).as_bytes());
        }
        self.spare()?;
        let mut given = if self.twins.is_empty() {
            self.without_twin(globals)?
        } else {
            self.with_twins(globals)?
        };
        let mut progress = Progress::share("Diagnosing", globals);
        let answer = pipeline::diagnose(&mut given.rig, &mut |done, what| progress.at(done, what))?;
        drop(progress);
        self.write(&given, &answer)
    }

    fn with_twins(&self, globals: Globals) -> Result<GivenRig, Failure> {
        let named = Named {
            recordings: &self.recordings,
            twins: &self.twins,
            reading: &self.reading,
        };
        let rig = named.read(globals)?;
        let declared = self.twins.iter().map(|path| Twin::load_with_text(path));
        Ok(GivenRig {
            rig,
            declared: declared.collect::<Result<_, _>>()?,
            said: Vec::new(),
        })
    }

    /// Recordings beside a twin of their sensor and clock: its disc, its noise and its course are found with everything else.
    fn without_twin(&self, globals: Globals) -> Result<GivenRig, Failure> {
        let inputs: Vec<_> = self.recordings.iter().map(|r| self.reading.of(r)).collect();
        let Recordings {
            found,
            clock_hz,
            placed,
        } = Recordings::read(&inputs, Given::default(), globals)?;
        let twin = starting_twin::bare(&found, clock_hz, &[])?;
        let text = starting_twin::bare_text(&found, clock_hz, &[]);
        let mut said = vec![(
            "Twin",
            "no twin given: one was made from the recording, of its sensor and clock; the disc's errors are free".to_owned(),
        )];
        said.extend(found.lines());
        let rig = placed.into_iter().map(|one| Recorded {
            file: one.file,
            edges: one.edges,
            twin: twin.clone(),
        });
        Ok(GivenRig {
            rig: rig.collect(),
            declared: vec![(text, twin)],
            said,
        })
    }

    fn write(&self, given: &GivenRig, answer: &Answer) -> Result<(), Failure> {
        let new = match &self.write_twin {
            Some(first) => Self::new_twins(first, given, answer)?,
            None => Vec::new(),
        };
        let inputs: Vec<&Path> = self.inputs().collect();
        let page = match &self.report.report {
            Some(target) => {
                let page = reports::diagnose::report(answer, footer(&inputs)?);
                Some((target, page.render()))
            }
            None => None,
        };
        let mut staged = Staged::default();
        for file in &new {
            staged.add(Target::File(file.path.clone()), file.text.as_bytes())?;
        }
        if let Some((target, page)) = page {
            staged.add(target.clone(), page.as_bytes())?;
        }
        if let Some(target) = &self.json.json {
            staged.add(target.clone(), &target.json_of(answer)?)?;
        }
        staged.commit()?;
        let asked = [self.report.report.as_ref(), self.json.json.as_ref()];
        if asked.contains(&Some(&Target::Stdout)) {
            return Ok(());
        }
        let mut text = Facts::default();
        for (name, value) in &given.said {
            text.push(*name, value);
        }
        for (name, value) in reports::diagnose::text(answer) {
            text.push(name, value);
        }
        for file in &new {
            text.push("Written", file.path.display());
        }
        Target::Stdout.write(text.to_string().as_bytes())
    }

    /// The files of the twins with the findings in them.
    fn new_twins(first: &Path, given: &GivenRig, answer: &Answer) -> Result<Vec<NewFile>, Failure> {
        let written = write::twins(&given.rig, answer)?;
        let (twins, discs) = written.into_iter().map(|one| (one.twin, one.disc)).unzip();
        let diagnosed = Diagnosed {
            diagnosis: answer.diagnosis.clone(),
            twins,
            discs,
        };
        new_twins::files(first, &diagnosed, &given.declared)
    }

    /// Refuses outputs that would take each other's place, or an input's.
    fn spare(&self) -> Result<(), Failure> {
        let new = self.write_twin.as_deref();
        let new = new.map_or_else(Vec::new, |first| {
            new_twins::names(first, self.recordings.len())
        });
        let new: Vec<Target> = new.into_iter().map(Target::File).collect();
        let asked = [self.report.report.as_ref(), self.json.json.as_ref()];
        let outputs: Vec<Option<&Target>> = new.iter().map(Some).chain(asked).collect();
        self.inputs().try_for_each(|input| spare(&outputs, input))
    }

    fn inputs(&self) -> impl Iterator<Item = &Path> {
        let all = self.recordings.iter().chain(&self.twins);
        all.map(PathBuf::as_path)
    }
}

impl From<DiagnoseError> for Failure {
    fn from(error: DiagnoseError) -> Self {
        match error {
            DiagnoseError::Twin(error) => Self::Twin(error),
            error => Self::Diagnose(Box::new(error)),
        }
    }
}

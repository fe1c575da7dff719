//! The blind trial of the diagnosis: `cargo run --release -p quadcal-host-tests --bin trial`.
#![forbid(unsafe_code)]

use std::fmt::Write as _;
use std::fs;
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, Result, ensure};
use clap::Parser;
use quadcal_blind::draw::{Family, Kind};
use quadcal_host_tests::trial::cases::{Draw, Folders};
use quadcal_host_tests::trial::luck::luck;
use quadcal_host_tests::trial::run::Quadcal;
use quadcal_host_tests::trial::shown::Outcome;
use quadcal_host_tests::trial::speed::{LIMIT_S, minute};
use quadcal_host_tests::trial::under_trial::UnderTrial;
use tempfile::TempDir;

/// Draws blind cases, runs 'quadcal diagnose' on each, and scores its answers against the truth
///
/// The command is given recordings and twins; the truth lies in another folder, is not given to it, and is read when all answers are in.
#[derive(Debug, Parser)]
#[command(
    max_term_width = 100,
    after_help = "\
Examples:
  cargo build --release && cargo run --release -p quadcal-host-tests --bin trial
  ... --bin trial -- --cases 200 --kind nothing --seed 5
  ... --bin trial -- --folder trial --misses           keeps trial/open, trial/sealed, trial/answers
  ... --bin trial -- --open trial/open --sealed trial/sealed --case case-0012 --misses
  ... --bin trial -- --case case-0012 --again 20       luck or bias: the case 20 times more, with other noise
  ... --bin trial -- --markdown docs/blind-trial.md
  ... --bin trial -- --speed

Exit codes:
  0  every figure that has a target reaches it
  1  one does not, or something failed
  2  the command line is wrong"
)]
struct Options {
    /// Cases to draw
    #[arg(long, value_name = "N", default_value_t = 400)]
    cases: usize,
    /// Seed of the cases
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Cases of this kind only
    #[arg(long)]
    kind: Option<Kind>,
    /// Cases of this family, in place of the kinds
    #[arg(long, conflicts_with = "kind")]
    family: Option<Family>,
    /// Cases at work at once
    #[arg(long, value_name = "N", default_value_t = 2)]
    jobs: usize,
    /// Folder to keep cases and answers in; else they are thrown away
    #[arg(long, value_name = "DIR", conflicts_with = "open")]
    folder: Option<PathBuf>,
    /// Score cases drawn before: their open folder
    #[arg(long, value_name = "DIR", requires = "sealed", conflicts_with_all = ["cases", "seed", "kind", "family"])]
    open: Option<PathBuf>,
    /// Score cases drawn before: their sealed folder
    #[arg(long, value_name = "DIR", requires = "open")]
    sealed: Option<PathBuf>,
    /// Folder to keep the answers' JSON in, where the cases are not kept with them
    #[arg(long, value_name = "DIR")]
    answers: Option<PathBuf>,
    /// Try this case only; may be given several times
    #[arg(long, value_name = "NAME")]
    case: Vec<String>,
    /// Record each case so often again, with other noise, and print how far off its parameters are
    #[arg(long, value_name = "N", default_value_t = 0, conflicts_with = "open")]
    again: u64,
    /// Print the wrong answers, one a line
    #[arg(long)]
    misses: bool,
    /// Write figures, matrices and wrong answers as a Markdown document
    #[arg(long, value_name = "OUT.md")]
    markdown: Option<PathBuf>,
    /// Write figures and every case's score as JSON
    #[arg(long, value_name = "OUT.json")]
    json: Option<PathBuf>,
    #[command(flatten)]
    under_trial: UnderTrial,
    /// Time the diagnosis of a minute of 150,000 edges, and do nothing else
    #[arg(long, conflicts_with_all = ["open", "sealed", "answers", "case", "misses", "markdown", "json"])]
    speed: bool,
}

fn main() -> Result<ExitCode> {
    let options = Options::parse();
    let quadcal = options.under_trial.quadcal()?;
    let temporary = TempDir::new()?;
    let folder = options.folder.as_deref().unwrap_or(temporary.path());
    if options.speed {
        fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        return speed(&quadcal, &folder.canonicalize()?);
    }
    let mut folders = match (&options.open, &options.sealed) {
        (Some(open), Some(sealed)) => {
            ensure!(
                !real(sealed)?.starts_with(real(open)?),
                "{} lies within {}: the truth must not lie where the cases are",
                sealed.display(),
                open.display()
            );
            Folders {
                open: open.clone(),
                sealed: sealed.clone(),
                answers: temporary.path().join("answers"),
            }
        }
        _ => draw(&options, folder)?,
    };
    if let Some(answers) = &options.answers {
        folders.answers.clone_from(answers);
    }
    let mut names = folders.names()?;
    if options.open.is_some() && !options.case.is_empty() {
        names.retain(|name| options.case.contains(name));
        ensure!(!names.is_empty(), "--case: no such case");
    }
    let progress = Progress::new("diagnosed", names.len());
    let scores = folders.judge(&names, &quadcal, options.jobs, || progress.step())?;
    progress.end();
    let outcome = Outcome::new(options.command(), quadcal.version(), scores);
    println!("{}", outcome.text());
    if options.again > 0 {
        println!("{}", luck(&outcome.cases));
    }
    if options.misses {
        println!("{}", outcome.misses());
    }
    if let Some(path) = &options.markdown {
        write(path, &outcome.markdown())?;
    }
    if let Some(path) = &options.json {
        write(path, &(serde_json::to_string_pretty(&outcome)? + "\n"))?;
    }
    Ok(exit(outcome.met()))
}

/// Draws the cases within a folder, where there must be none yet.
fn draw(options: &Options, folder: &Path) -> Result<Folders> {
    let folders = Folders::within(folder);
    ensure!(
        !folders.open.exists() && !folders.sealed.exists(),
        "{} has cases in it: score them with --open and --sealed, or give another folder",
        folder.display()
    );
    let draw = Draw {
        cases: options.cases,
        seed: options.seed,
        kind: options.kind,
        family: options.family,
        only: options.case.clone(),
        again: options.again,
    };
    let count = draw.count();
    ensure!(count > 0, "--case: no such case");
    let progress = Progress::new("drawn", count);
    folders.draw(&draw, options.jobs, || progress.step())?;
    progress.end();
    Ok(folders)
}

fn speed(quadcal: &Quadcal, folder: &Path) -> Result<ExitCode> {
    let mut slowest: f64 = 0.0;
    let mut failed = false;
    for timed in minute(quadcal, folder)? {
        println!(
            "{} edges in a minute, missing {}: {:.2} s, named {}",
            timed.edges,
            timed.missing(),
            timed.answer.seconds,
            timed.named()
        );
        failed |= timed.answer.said.is_err();
        slowest = slowest.max(timed.answer.seconds);
    }
    println!("slowest {slowest:.2} s, to reach {LIMIT_S} s or less");
    Ok(exit(!failed && slowest <= LIMIT_S))
}

impl Options {
    /// The command that makes the same trial again.
    fn command(&self) -> String {
        let mut text = "cargo run --release -p quadcal-host-tests --bin trial --".to_owned();
        match (&self.open, &self.sealed) {
            (Some(open), Some(sealed)) => {
                let (open, sealed) = (open.display(), sealed.display());
                let _ = write!(text, " --open {open} --sealed {sealed}");
            }
            _ => {
                let _ = write!(text, " --cases {} --seed {}", self.cases, self.seed);
            }
        }
        if let Some(kind) = self.kind {
            let name = kind.name().replace('_', "-");
            let _ = write!(text, " --kind {name}");
        }
        if let Some(family) = self.family {
            let name = family.name().replace('_', "-");
            let _ = write!(text, " --family {name}");
        }
        for case in &self.case {
            let _ = write!(text, " --case {case}");
        }
        if self.again > 0 {
            let _ = write!(text, " --again {}", self.again);
        }
        if let Some(path) = &self.markdown {
            let _ = write!(text, " --markdown {}", path.display());
        }
        text
    }
}

/// A path that is there, absolute.
fn real(path: &Path) -> Result<PathBuf> {
    fs::canonicalize(path).with_context(|| path.display().to_string())
}

fn write(path: &Path, text: &str) -> Result<()> {
    fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
}

fn exit(well: bool) -> ExitCode {
    if well {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}

/// How far it is, on standard error.
struct Progress {
    what: &'static str,
    of: usize,
    done: AtomicUsize,
    live: bool,
}

impl Progress {
    fn new(what: &'static str, of: usize) -> Self {
        Self {
            what,
            of,
            done: AtomicUsize::new(0),
            live: io::stderr().is_terminal(),
        }
    }

    fn step(&self) {
        let done = 1 + self.done.fetch_add(1, Ordering::Relaxed);
        if self.live {
            eprint!("\r{done} of {} cases {}", self.of, self.what);
        } else if done.is_multiple_of(50) {
            eprintln!("{done} of {} cases {}", self.of, self.what);
        }
    }

    fn end(&self) {
        if self.live {
            eprintln!();
        }
    }
}

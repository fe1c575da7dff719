//! Every mechanism on top of every printed example: `cargo run --release -p quadcal-host-tests --bin guard-grid`.
#![forbid(unsafe_code)]

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::Result;
use clap::Parser;
use quadcal_host::diagnose::diagnosis::Verdict;
use quadcal_host::mechanism::Mechanism;
use quadcal_host_tests::guard::bench::{EXAMPLES, diagnose, example, record};
use quadcal_host_tests::guard::plant::{Plant, Sizing, quiet};
use quadcal_host_tests::guard::{judge, tree};
use quadcal_host_tests::parallel::in_parallel;
use quadcal_host_tests::trial::run::Quadcal;
use quadcal_host_tests::trial::under_trial::UnderTrial;
use toml::Table;

/// Sizes, in detectable ones.
const TIMES: [f64; 4] = [3.0, 5.0, 10.0, 30.0];
/// Least share of right answers at each, and most of false ones at all.
const RIGHT: [Option<f64>; 4] = [None, Some(0.85), Some(0.95), None];
const FALSE: f64 = 0.01;
/// Least share of examples that are complete against their own recording.
const NOTHING: f64 = 1.0;
/// Of how many cells a sample has one.
const SAMPLE: usize = 41;

/// Puts every mechanism on top of every printed example, noisy and quiet, records it and diagnoses it with the example
///
/// A detectable size is one whose edges differ by 5 standard deviations of the noise, start angle and speed left out. What shows
/// at no size, as a play where nothing reverses, is left out. Right is an answer that names the mechanism or leaves it open; false is
/// another one named with more than 99 %. With nothing on top, the
/// answer has to be complete.
#[derive(Debug, Parser)]
#[command(
    max_term_width = 100,
    after_help = "\
Exit codes:
  0  85 % right at 5 times the detectable size, 95 % at 10, false in 1 % at most
  1  not so, or something failed
  2  the command line is wrong"
)]
struct Options {
    /// Examples; all where none is given
    #[arg(long, value_name = "NAME")]
    example: Vec<String>,
    /// Mechanisms by their id; all where none is given
    #[arg(long, value_name = "ID")]
    mechanism: Vec<String>,
    /// A small part of the grid, for a quick look
    #[arg(long)]
    sample: bool,
    /// Recordings of each rig, with other noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seeds: u64,
    /// Cells at work at once
    #[arg(long, value_name = "N", default_value_t = 2)]
    jobs: usize,
    /// Folder to keep twins, recordings and answers in; else they are thrown away
    #[arg(long, value_name = "DIR")]
    folder: Option<PathBuf>,
    #[command(flatten)]
    under_trial: UnderTrial,
}

/// A twin, a mechanism on top of a size, or nothing, and a seed.
struct Cell {
    twin: usize,
    plant: Option<(Plant, usize)>,
    seed: u64,
}

impl Cell {
    /// What is on top.
    fn name(&self) -> &'static str {
        self.plant
            .map_or("nothing", |(plant, _)| plant.mechanism.id())
    }
}

/// What came of a cell.
struct Row {
    /// Which of the sizes; none where nothing is on top.
    times: Option<usize>,
    right: bool,
    is_false: bool,
    seconds: f64,
    text: String,
}

fn main() -> Result<ExitCode> {
    let options = Options::parse();
    let quadcal = options.under_trial.quadcal()?;
    let temporary = tempfile::TempDir::new()?;
    let folder = options.folder.as_deref().unwrap_or(temporary.path());
    let twins = twins(&options, &quadcal)?;
    let cells = cells(&options, &twins);
    let rows = in_parallel(options.jobs, cells.len(), |at| {
        let folder = folder.join(format!("{at:05}"));
        let (name, twin) = &twins[cells[at].twin];
        let row = attempt(&quadcal, name, twin, &cells[at], &folder);
        if options.folder.is_none() {
            let _ = std::fs::remove_dir_all(&folder);
        }
        match &row {
            Ok(Some(row)) => println!("{}", row.text),
            Ok(None) => {}
            Err(why) => println!("{name} {}: {why:#}", cells[at].name()),
        }
        row
    });
    let failed = rows.iter().filter(|row| row.is_err()).count();
    let rows: Vec<Row> = rows
        .into_iter()
        .filter_map(|row| row.ok().flatten())
        .collect();
    if failed > 0 {
        println!("{failed} cells that can't be simulated");
    }
    Ok(ExitCode::from(u8::from(!summary(&rows) || failed > 0)))
}

/// The examples, each noisy and quiet.
fn twins(options: &Options, quadcal: &Quadcal) -> Result<Vec<(String, Table)>> {
    let given: Vec<&str> = options.example.iter().map(String::as_str).collect();
    let names = if given.is_empty() {
        &EXAMPLES[..]
    } else {
        &given
    };
    let mut all = Vec::new();
    for name in names {
        let twin = example(quadcal, name)?;
        all.push((format!("{name}, quiet"), quiet(&twin)));
        all.push(((*name).to_owned(), twin));
    }
    Ok(all)
}

fn cells(options: &Options, twins: &[(String, Table)]) -> Vec<Cell> {
    let wanted = |mechanism: &Mechanism| {
        let id = mechanism.id();
        options.mechanism.is_empty() || options.mechanism.iter().any(|one| one == id)
    };
    let mut all = Vec::new();
    for (at, (_, twin)) in twins.iter().enumerate() {
        let mut add = |plant| {
            all.extend((1..=options.seeds).map(|seed| Cell {
                twin: at,
                plant,
                seed,
            }));
        };
        if options.mechanism.is_empty() {
            add(None);
        }
        for mechanism in Mechanism::ALL.into_iter().filter(wanted) {
            let Some(plant) = Plant::of(mechanism, twin) else {
                continue;
            };
            let sizes = if plant.sizing == Sizing::Whole {
                2..3
            } else {
                0..TIMES.len()
            };
            for times in sizes {
                add(Some((plant, times)));
            }
        }
    }
    if options.sample {
        all = all.into_iter().step_by(SAMPLE).collect();
    }
    all
}

/// Records the rig of a cell and diagnoses it with the twin; none where nothing of it shows.
fn attempt(
    quadcal: &Quadcal,
    name: &str,
    twin: &Table,
    cell: &Cell,
    folder: &Path,
) -> Result<Option<Row>> {
    let mut rig = twin.clone();
    let mut size = String::new();
    if let Some((plant, times)) = &cell.plant {
        let Some(detectable) = plant.detectable(twin)? else {
            return Ok(None);
        };
        let times = TIMES[*times];
        rig = plant.on(twin, times * detectable);
        if tree::twin(&rig).is_err() {
            // So large that it is no rig any more.
            return Ok(None);
        }
        size = format!("{times} x {detectable:.3e}");
    }
    record(quadcal, &rig, cell.seed, folder)?;
    let answer = diagnose(quadcal, twin, folder)?;
    let (right, is_false, line) = match &answer.said {
        Ok(said) => match &cell.plant {
            Some((plant, _)) => (
                judge::named(said, plant.mechanism),
                !judge::false_names(said, plant.mechanism).is_empty(),
                judge::line(said),
            ),
            None => (
                said.verdict == Verdict::Complete,
                said.findings
                    .iter()
                    .any(|found| found.confidence > judge::SURE),
                judge::line(said),
            ),
        },
        Err(why) => (false, false, format!("failed: {why}")),
    };
    let verdict = match (is_false, right) {
        (true, _) => "FALSE",
        (false, true) => "right",
        (false, false) => "MISSED",
    };
    let text = format!(
        "{name:<18} {:<20} {size:<14} {:>6.1} s  {verdict:<7} {line}",
        cell.name(),
        answer.seconds
    );
    Ok(Some(Row {
        times: cell.plant.map(|(_, times)| times),
        right,
        is_false,
        seconds: answer.seconds,
        text,
    }))
}

/// Prints the shares; whether they reach what they have to.
fn summary(rows: &[Row]) -> bool {
    let mut met = true;
    let mut share = |what: &str, count: usize, of: usize, reached: &dyn Fn(f64) -> bool| {
        let share = count as f64 / of.max(1) as f64;
        let missed = if of > 0 && !reached(share) {
            "  MISSED"
        } else {
            ""
        };
        println!("{what}: {count} of {of}, {:.1} %{missed}", 100.0 * share);
        met &= missed.is_empty();
    };
    for (at, times) in TIMES.into_iter().enumerate() {
        let of = rows.iter().filter(|row| row.times == Some(at));
        let right = of.clone().filter(|row| row.right).count();
        let least = RIGHT[at].unwrap_or(0.0);
        share(
            &format!("right at {times} times the detectable size"),
            right,
            of.count(),
            &|share| share >= least,
        );
    }
    let nothing = rows.iter().filter(|row| row.times.is_none());
    let right = nothing.clone().filter(|row| row.right).count();
    share(
        "complete where nothing is on top",
        right,
        nothing.count(),
        &|share| share >= NOTHING,
    );
    let is_false = rows.iter().filter(|row| row.is_false).count();
    share("something false for sure", is_false, rows.len(), &|share| {
        share <= FALSE
    });
    let slowest = rows
        .iter()
        .fold(0.0, |most: f64, row| most.max(row.seconds));
    println!("slowest: {slowest:.1} s");
    met
}

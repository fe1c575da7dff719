//! Twins changed in one place, against recordings of the whole: `cargo run --release -p quadcal-host-tests --bin leave-one-out`.
#![forbid(unsafe_code)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::Parser;
use quadcal_host_tests::guard::bench::{diagnose, example, record};
use quadcal_host_tests::guard::change::{Change, changes};
use quadcal_host_tests::guard::{judge, sight, tree};
use quadcal_host_tests::parallel::in_parallel;
use quadcal_host_tests::trial::run::Quadcal;
use quadcal_host_tests::trial::under_trial::UnderTrial;
use toml::Table;

/// d' below which a change does not show.
const SHOWS: f64 = 3.0;
/// Least share of the changes that show of which the answer is right.
const RIGHT: f64 = 0.95;
/// Least share of all changes in which nothing false is said for sure.
const NOTHING_FALSE: f64 = 0.98;
/// Of how many changes a sample has one.
const SAMPLE: usize = 12;

/// Takes out, halves, doubles and turns each number of physics in a twin, and diagnoses recordings of the whole twin with what is left
///
/// Right is an answer that names what was taken out, or gives the true number, as a correction or anew. False is any other mechanism
/// named with more than 99 %. What an ideal detector could not see (d' below 3) need not be said.
#[derive(Debug, Parser)]
#[command(
    max_term_width = 100,
    after_help = "\
Exit codes:
  0  95 % right, and nothing false in 98 %
  1  not so, or something failed
  2  the command line is wrong"
)]
struct Options {
    /// Twins in place of the printed example 'mechanisms' and those of host-tests/twins
    #[arg(value_name = "TWIN")]
    twins: Vec<PathBuf>,
    /// One change in a dozen, for a quick look
    #[arg(long)]
    sample: bool,
    /// Seed of the recordings' noise
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Changes at work at once
    #[arg(long, value_name = "N", default_value_t = 2)]
    jobs: usize,
    /// Folder to keep twins, recordings and answers in; else they are thrown away
    #[arg(long, value_name = "DIR")]
    folder: Option<PathBuf>,
    #[command(flatten)]
    under_trial: UnderTrial,
}

/// What came of one change.
struct Row {
    twin: String,
    change: Change,
    shown: f64,
    right: bool,
    said: String,
    false_names: usize,
    seconds: f64,
}

impl Row {
    fn shows(&self) -> bool {
        self.shown >= SHOWS
    }

    fn verdict(&self) -> &'static str {
        match (self.false_names > 0, self.right, self.shows()) {
            (true, _, _) => "FALSE",
            (false, true, _) => "right",
            (false, false, true) => "MISSED",
            (false, false, false) => "does not show",
        }
    }
}

fn main() -> Result<ExitCode> {
    let options = Options::parse();
    let quadcal = options.under_trial.quadcal()?;
    let temporary = tempfile::TempDir::new()?;
    let folder = options.folder.as_deref().unwrap_or(temporary.path());
    let mut rows = Vec::new();
    println!(
        "{:<12} {:<38} {:<8} {:>9} {:>6}  {:<13} said",
        "twin", "key", "change", "d'", "s", ""
    );
    for (name, whole) in twins(&options, &quadcal)? {
        let folder = folder.join(&name);
        let mut all = changes(&whole);
        if options.sample {
            all = all.into_iter().step_by(SAMPLE).collect();
        }
        record(&quadcal, &whole, options.seed, &folder)?;
        let tried = in_parallel(options.jobs, all.len(), |at| {
            let folder = folder.join(format!("{at:03}"));
            attempt(&quadcal, &name, &whole, &all[at], &folder)
        });
        for row in tried {
            let row = row?;
            println!(
                "{:<12} {:<38} {:<8} {:>9.3e} {:>6.1}  {:<13} {}",
                row.twin,
                tree::shown(&row.change.path),
                row.change.how.word(),
                row.shown,
                row.seconds,
                row.verdict(),
                row.said
            );
            rows.push(row);
        }
    }
    Ok(ExitCode::from(u8::from(!summary(&rows))))
}

/// Names and trees of the twins.
fn twins(options: &Options, quadcal: &Quadcal) -> Result<Vec<(String, Table)>> {
    let load = |path: &Path| -> Result<(String, Table)> {
        let text = fs::read_to_string(path).with_context(|| path.display().to_string())?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        Ok((name.into_owned(), tree::parse(&text)?))
    };
    if !options.twins.is_empty() {
        return options.twins.iter().map(|path| load(path)).collect();
    }
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("twins");
    let mut all = vec![("mechanisms".to_owned(), example(quadcal, "mechanisms")?)];
    for name in ["speed-loop", "hall-motor", "run-down"] {
        all.push(load(&own.join(name).with_extension("toml"))?);
    }
    Ok(all)
}

/// Diagnoses the recording of the whole twin, which lies in the folder above, with a changed one.
fn attempt(
    quadcal: &Quadcal,
    name: &str,
    whole: &Table,
    change: &Change,
    folder: &Path,
) -> Result<Row> {
    fs::create_dir_all(folder)?;
    fs::copy(folder.join("../rec.csv"), folder.join("rec.csv"))?;
    let shown = sight::distance(whole, &change.twin)?;
    let answer = diagnose(quadcal, &change.twin, folder)?;
    fs::remove_file(folder.join("rec.csv"))?;
    let mut row = Row {
        twin: name.to_owned(),
        change: change.clone(),
        shown,
        right: false,
        said: String::new(),
        false_names: 0,
        seconds: answer.seconds,
    };
    match answer.said {
        Ok(said) => {
            row.right = judge::says(&said, whole, change);
            row.false_names = judge::false_names(&said, change.mechanism).len();
            row.said = judge::line(&said);
        }
        Err(why) => row.said = format!("failed: {why}"),
    }
    Ok(row)
}

/// Prints the shares; whether they reach what they have to.
fn summary(rows: &[Row]) -> bool {
    let showing: Vec<&Row> = rows.iter().filter(|row| row.shows()).collect();
    let right = showing.iter().filter(|row| row.right).count();
    let nothing_false = rows.iter().filter(|row| row.false_names == 0).count();
    let mut met = true;
    for (what, count, of, least) in [
        ("right, of those that show", right, showing.len(), RIGHT),
        (
            "nothing false said for sure",
            nothing_false,
            rows.len(),
            NOTHING_FALSE,
        ),
    ] {
        let share = count as f64 / of.max(1) as f64;
        let missed = if of > 0 && share < least {
            "  MISSED"
        } else {
            ""
        };
        println!(
            "{what}: {count} of {of}, {:.1} %, to reach {:.0} %{missed}",
            100.0 * share,
            100.0 * least
        );
        met &= missed.is_empty();
    }
    met
}

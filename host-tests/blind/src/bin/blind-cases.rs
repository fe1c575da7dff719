//! Draws blind cases: `cargo run --release -p quadcal-blind -- --cases 400 --seed 1 --out cases --sealed truth`.
#![forbid(unsafe_code)]

use std::collections::BTreeMap;
use std::num::NonZero;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use anyhow::{Result, ensure};
use clap::Parser;
use quadcal_blind::draw::{Family, Kind, again, plan};
use quadcal_blind::write;

/// Draws cases for a blind trial of the diagnosis: recordings with their twin into one folder, the truth into another
#[derive(Parser)]
#[command(after_help = "\
Examples:
  blind-cases --cases 400 --seed 1 --out cases --sealed truth
  blind-cases --cases 200 --seed 2 --kind nothing --out cases --sealed truth
  blind-cases --cases 400 --seed 1 --one 17 --out cases --sealed truth     case 17 of the first again

Each case has a folder of its number: rec.csv (or rec1.csv, rec2.csv: one rig at two speeds), twin.toml (twin2.toml: the same
rig at the second recording's speed), errors.csv where the disc's errors are known; truth.json in the other folder. The same
cases, seed and kind give the same bytes.")]
struct Options {
    /// Cases to draw
    #[arg(long, default_value_t = 400)]
    cases: usize,
    /// Seed of everything
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder for recordings and twins
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Folder for the truth; not within the other
    #[arg(long, value_name = "DIR")]
    sealed: PathBuf,
    /// Draw cases of this kind only
    #[arg(long)]
    kind: Option<Kind>,
    /// Draw cases of this family in place of the kinds
    #[arg(long, conflicts_with = "kind")]
    family: Option<Family>,
    /// Write this case only, by its number from 0
    #[arg(long, value_name = "N")]
    one: Option<usize>,
    /// Print neither progress nor a summary
    #[arg(short, long)]
    quiet: bool,
}

fn main() -> Result<()> {
    let options = Options::parse();
    ensure!(
        !options.sealed.starts_with(&options.out),
        "{} lies within {}: the truth must not lie where the cases are",
        options.sealed.display(),
        options.out.display()
    );
    let plan = match options.family {
        Some(family) => family.plan(options.cases, options.seed),
        None => plan(options.cases, options.seed, options.kind),
    };
    let places: Vec<usize> = match options.one {
        Some(one) => {
            ensure!(
                one < plan.len(),
                "--one {one}: there are {} cases, counted from 0",
                plan.len()
            );
            vec![one]
        }
        None => (0..plan.len()).collect(),
    };
    let next = AtomicUsize::new(0);
    let done = AtomicUsize::new(0);
    let counts = Mutex::new(BTreeMap::<&str, usize>::new());
    let draw = || -> Result<()> {
        while let Some(&place) = places.get(next.fetch_add(1, Ordering::Relaxed)) {
            let (kind, _) = plan[place];
            let case = again(options.seed, place, options.family, plan[place], 0);
            let name = format!("case-{place:04}");
            write::open_folder(&options.out.join(&name), &case.runs)?;
            write::sealed(&options.sealed.join(&name), &case.truth)?;
            if let Ok(mut counts) = counts.lock() {
                *counts.entry(kind.name()).or_insert(0) += 1;
            }
            let done = 1 + done.fetch_add(1, Ordering::Relaxed);
            if !options.quiet {
                eprint!("\r{done} of {} cases", places.len());
            }
        }
        Ok(())
    };
    let workers = thread::available_parallelism().map_or(1, NonZero::get);
    thread::scope(|scope| -> Result<()> {
        let running: Vec<_> = (0..workers).map(|_| scope.spawn(draw)).collect();
        for worker in running {
            match worker.join() {
                Ok(result) => result?,
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        Ok(())
    })?;
    if !options.quiet {
        eprintln!();
        println!("{} cases in {}", places.len(), options.out.display());
        // One case by itself: its kind would give it away.
        if options.one.is_none() && options.kind.is_none() {
            for (kind, count) in counts.into_inner().unwrap_or_default() {
                println!("  {kind:<11}{count:>5}");
            }
        }
    }
    Ok(())
}

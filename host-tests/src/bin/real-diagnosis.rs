//! Diagnoses real recordings: `cargo run --release -p quadcal-host-tests --bin real-diagnosis`.
#![forbid(unsafe_code)]

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::Parser;
use quadcal_host_tests::real::command::Bench;
use quadcal_host_tests::real::line::Line;
use quadcal_host_tests::real::table::RECORDINGS;
use quadcal_host_tests::real::{flywheel, hall};
use quadcal_host_tests::trial::run::Quadcal;
use quadcal_host_tests::trial::under_trial::UnderTrial;

/// Runs 'quadcal diagnose' on recordings of real machines, with twins that know little, and holds the answers against what is known
///
/// The two Hall recordings are the project's own. The flywheel's is GPL-3.0, so it is not shipped: openrowingmonitor,
/// recordings/Concept2_RowErg_Session_2000meters.csv.
#[derive(Debug, Parser)]
#[command(
    max_term_width = 100,
    after_help = "\
Exit codes:
  0  every figure that has a target reaches it
  1  one does not, or something failed
  2  the command line is wrong"
)]
struct Options {
    /// Recording of a flywheel with six magnets: seconds between pulses, one a line
    #[arg(long, value_name = "PATH")]
    flywheel: Option<PathBuf>,
    /// Folder of recordings: each of the table that is there is diagnosed, and what is said of it printed
    #[arg(long, value_name = "DIR")]
    recordings: Option<PathBuf>,
    /// Twins of the table say nothing of the drive
    #[arg(long, requires = "recordings")]
    no_drive: bool,
    /// Folder to keep twins, answers and reports in; else they are thrown away
    #[arg(long, value_name = "DIR")]
    folder: Option<PathBuf>,
    #[command(flatten)]
    under_trial: UnderTrial,
}

fn main() -> Result<ExitCode> {
    let options = Options::parse();
    let temporary = tempfile::TempDir::new()?;
    let folder = options.folder.as_deref().unwrap_or(temporary.path());
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let Quadcal { program } = options.under_trial.quadcal()?;
    let bench = Bench {
        program,
        arguments: Vec::new(),
        folder: folder.to_owned(),
    };
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host/recordings");
    let mut met = true;
    let mut show = |lines: Vec<Line>| {
        for line in lines {
            println!("{line}");
            met &= line.met;
        }
    };
    show(hall::spindle(&bench, &shipped)?);
    show(hall::hub(&bench, &shipped)?);
    if let Some(path) = &options.flywheel {
        show(flywheel::flywheel(&bench, path)?);
    }
    if let Some(recordings) = &options.recordings {
        for recording in &RECORDINGS {
            show(recording.diagnose(&bench, recordings, !options.no_drive)?);
        }
    }
    Ok(ExitCode::from(u8::from(!met)))
}

//! Diagnoses real recordings: `cargo run --release -p quadcal-host-tests --bin real-diagnosis`.
#![forbid(unsafe_code)]

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Context, Result};
use clap::Parser;
use quadcal_host_tests::real::command::Bench;
use quadcal_host_tests::real::line::Line;
use quadcal_host_tests::real::{flywheel, hall};

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
    /// Folder to keep twins, answers and reports in; else they are thrown away
    #[arg(long, value_name = "DIR")]
    folder: Option<PathBuf>,
    /// The command under trial; else the quadcal that is built beside this one
    #[arg(long, value_name = "PROGRAM")]
    quadcal: Option<PathBuf>,
}

fn main() -> Result<ExitCode> {
    let options = Options::parse();
    let temporary = tempfile::TempDir::new()?;
    let folder = options.folder.as_deref().unwrap_or(temporary.path());
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    let bench = Bench {
        program: program(options.quadcal.as_deref())?,
        folder: folder.to_owned(),
    };
    let recordings = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host/recordings");
    let mut met = true;
    let mut show = |lines: Vec<Line>| {
        for line in lines {
            println!("{line}");
            met &= line.met;
        }
    };
    show(hall::spindle(&bench, &recordings)?);
    show(hall::hub(&bench, &recordings)?);
    if let Some(path) = &options.flywheel {
        show(flywheel::flywheel(&bench, path)?);
    }
    Ok(ExitCode::from(u8::from(!met)))
}

/// The command under trial.
fn program(given: Option<&Path>) -> Result<PathBuf> {
    if let Some(path) = given {
        return std::fs::canonicalize(path).with_context(|| path.display().to_string());
    }
    let own = std::env::current_exe()?;
    let suffix = std::env::consts::EXE_SUFFIX;
    ["quadcal-under-test", "quadcal"]
        .map(|name| own.with_file_name(format!("{name}{suffix}")))
        .into_iter()
        .find(|path| path.is_file())
        .with_context(|| {
            format!(
                "no quadcal beside {}: build it first (cargo build --release), or give --quadcal",
                own.display()
            )
        })
}

//! Recordings and diagnoses of twins, by the command.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};
use toml::Table;

use crate::trial::run::Quadcal;
use crate::trial::score::Answer;

/// Names that `quadcal simulate --example` prints.
pub const EXAMPLES: [&str; 12] = [
    "paper",
    "wander",
    "hall",
    "wheel",
    "run-down",
    "speed-loop",
    "delays",
    "load-step",
    "mechanisms",
    "stick-slip",
    "pair-slow",
    "pair-fast",
];

/// A printed example.
///
/// # Errors
/// Where the command fails.
pub fn example(quadcal: &Quadcal, name: &str) -> Result<Table> {
    let output = Command::new(&quadcal.program)
        .args(["simulate", "--example", name])
        .output()
        .with_context(|| quadcal.program.display().to_string())?;
    ensure!(output.status.success(), "no example {name}");
    super::tree::parse(&String::from_utf8_lossy(&output.stdout))
}

/// Records a rig into `rec.csv` in a folder, with a seed of its noise. The disc keeps the twin's own seed.
///
/// # Errors
/// The command's words where it fails.
pub fn record(quadcal: &Quadcal, rig: &Table, seed: u64, folder: &Path) -> Result<()> {
    fs::create_dir_all(folder)?;
    let mut rig = rig.clone();
    keep_disc(&mut rig);
    super::tree::set(&mut rig, "seed", i64::try_from(seed)?);
    fs::write(folder.join("rig.toml"), rig.to_string())?;
    let output = Command::new(&quadcal.program)
        .current_dir(folder)
        .args(["simulate", "rig.toml", "-o", "rec.csv", "--quiet"])
        .stdin(Stdio::null())
        .output()
        .with_context(|| quadcal.program.display().to_string())?;
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "simulate: {}", said.trim());
    Ok(())
}

/// Diagnoses `rec.csv` in a folder against a twin.
///
/// # Errors
/// Where the twin can't be written.
pub fn diagnose(quadcal: &Quadcal, twin: &Table, folder: &Path) -> Result<Answer> {
    let mut twin = twin.clone();
    keep_disc(&mut twin);
    fs::write(folder.join("twin.toml"), twin.to_string())?;
    let json = fs::canonicalize(folder)?.join("answer.json");
    Ok(quadcal.diagnose(folder, &json))
}

/// Gives the disc the seed that it has by the twin's, so that another seed of the noise leaves it as it is.
fn keep_disc(twin: &mut Table) {
    if super::tree::number(twin, "errors.seed").is_none() && twin.contains_key("errors") {
        let seed = twin.get("seed").and_then(toml::Value::as_integer);
        super::tree::set(twin, "errors.seed", seed.unwrap_or(0));
    }
}

//! A small rig on the disk and the command to work on it.
// Each test program uses its part.
#![allow(dead_code)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

/// A small encoder, so that a run takes no time: 50 lines, 600 r/min, 20 turns.
pub const TWIN: &str = "seed = 4
duration = { turns = 20 }
[encoder.quadrature]
lines = 50
index = true
[errors]
position = { uniform = { amplitude_rad = 2e-3 } }
width_a_rad = 4e-3
quadrature_rad = 6e-3
[shaft]
inertia_kg_m2 = 1e-4
viscous_n_m_s = 1e-4
[drive.constant]
r_min = 600
[timer]
clock_hz = 84_000_000
";

pub fn quadcal(folder: &Path, arguments: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_quadcal"))
        .current_dir(folder)
        .args(arguments.split_whitespace())
        .output()
        .unwrap()
}

/// Runs a command that must work and gives its stdout.
pub fn done(folder: &Path, arguments: &str) -> String {
    let output = quadcal(folder, arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// Runs a command that must fail: one line, no file more than before.
pub fn refused(folder: &TempDir, arguments: &str, code: i32) -> String {
    let before = names(folder);
    let output = quadcal(folder.path(), arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments}: {message}");
    assert_eq!(message.lines().count(), 1, "{arguments}: {message}");
    assert!(message.contains("; "), "no advice: {message}");
    assert_eq!(names(folder), before, "{arguments}");
    message
}

pub fn names(folder: &TempDir) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// A folder with twin, recording, reference and table.
pub fn workshop() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("rig.toml"), TWIN).unwrap();
    done(
        at,
        "simulate rig.toml -o rig.csv --reference ref.csv --ratio 8 --truth truth.csv",
    );
    done(at, "calibrate rig.csv --turns 11 -o rig.qct");
    folder
}

/// Three Hall sensors in the place of [`QUADRATURE`].
pub const HALL: &str = "[encoder.hall]\npole_pairs = 2";
/// The encoder of [`TWIN`].
pub const QUADRATURE: &str = "[encoder.quadrature]\nlines = 50\nindex = true";

/// A folder with a twin, its recording, and the twin and recording of three Hall sensors.
pub fn bench() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let hall = TWIN
        .replace(QUADRATURE, HALL)
        .replace("quadrature_rad = 6e-3", "");
    fs::write(at.join("rig.toml"), TWIN).unwrap();
    fs::write(at.join("hall.toml"), hall).unwrap();
    done(at, "simulate rig.toml -o rig.csv");
    done(at, "simulate rig.toml --seed 9 -o again.csv");
    done(at, "simulate hall.toml -o hall.csv");
    folder
}

pub fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap()
}

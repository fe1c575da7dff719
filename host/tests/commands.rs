//! Simulate, calibrate, verify and demo as a user meets them: the whole way, and every way it can go wrong.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::TempDir;

/// A small encoder, so that a run takes no time: 50 lines, 600 r/min, 20 turns.
const TWIN: &str = "seed = 4
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

fn quadcal(folder: &Path, arguments: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_quadcal"))
        .current_dir(folder)
        .args(arguments.split_whitespace())
        .output()
        .unwrap()
}

/// Runs a command that must work and gives its stdout.
fn done(folder: &Path, arguments: &str) -> String {
    let output = quadcal(folder, arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// Runs a command that must fail: one line, no file more than before.
fn refused(folder: &TempDir, arguments: &str, code: i32) -> String {
    let before = names(folder);
    let output = quadcal(folder.path(), arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{arguments}: {message}");
    assert_eq!(message.lines().count(), 1, "{arguments}: {message}");
    assert!(message.contains("; "), "no advice: {message}");
    assert_eq!(names(folder), before, "{arguments}");
    message
}

fn names(folder: &TempDir) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// A folder with twin, recording, reference and table.
fn workshop() -> TempDir {
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

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn from_a_twin_to_a_table_that_holds_on_later_turns_and_against_the_reference() {
    let folder = workshop();
    let at = folder.path();
    let recording = fs::read_to_string(at.join("rig.csv")).unwrap();
    assert!(!recording.contains("error") && recording.contains("ticks,a,b,z"));
    let found = json(&done(
        at,
        "calibrate rig.csv --turns 11 -o again.qct --csv table.csv --report cal.html --json -",
    ));
    assert_eq!(found["lines"], 50);
    assert_eq!(found["turns"]["used"], 11);
    let bytes = |name| fs::read(at.join(name)).unwrap();
    assert_eq!(bytes("rig.qct"), bytes("again.qct"));
    // Every row of the table agrees with the truth, which only this test puts beside it; the angle's zero is free.
    let column = |name: &str, at_column: usize| -> Vec<f64> {
        let text = fs::read_to_string(at.join(name)).unwrap();
        let rows = text.lines().skip(1);
        rows.map(|row| row.split(',').nth(at_column).unwrap().parse().unwrap())
            .collect()
    };
    let (table, truth) = (column("table.csv", 2), column("truth.csv", 1));
    assert_eq!((table.len(), truth.len()), (200, 200));
    let rest: Vec<f64> = table.iter().zip(&truth).map(|(a, b)| a - b).collect();
    let mean = rest.iter().sum::<f64>() / 200.0;
    assert!(rest.iter().all(|e| (e - mean).abs() < 4e-5), "{rest:?}");
    let check = json(&done(
        at,
        "verify rig.csv --table rig.qct --reference ref.csv --ratio 8 --report ver.html --json -",
    ));
    assert_eq!(check["verdict"], "better");
    assert_eq!(check["same_recording"], true);
    let rmse = |key: &str| check["reference"][key].as_f64().unwrap();
    assert!(
        rmse("rmse_after_rad") < 0.02 * rmse("rmse_before_rad"),
        "{check}"
    );
    for report in ["cal.html", "ver.html"] {
        let page = fs::read_to_string(at.join(report)).unwrap();
        assert!(page.contains("<svg") && !page.contains("NaN"), "{report}");
    }
}

#[test]
fn a_table_serves_another_recording_of_its_encoder() {
    let folder = workshop();
    let at = folder.path();
    // Same disc at another speed; the disc comes from the seed.
    fs::write(at.join("fast.toml"), TWIN.replace("= 600", "= 900")).unwrap();
    done(at, "simulate fast.toml -o fast.vcd");
    let check = json(&done(at, "verify fast.vcd --table rig.qct --json -"));
    assert_eq!(check["same_recording"], false);
    assert_eq!(check["verdict"], "better");
}

#[test]
fn a_table_that_makes_it_worse_is_exit_code_1() {
    let folder = workshop();
    let at = folder.path();
    let perfect = TWIN
        .replace("2e-3", "1e-9")
        .replace("4e-3", "0")
        .replace("6e-3", "0");
    fs::write(at.join("perfect.toml"), perfect).unwrap();
    done(at, "simulate perfect.toml -o perfect.csv");
    let message = refused(&folder, "verify perfect.csv --table rig.qct", 1);
    assert!(
        message.starts_with("quadcal: rig.qct: this table makes the encoder WORSE"),
        "{message}"
    );
}

#[test]
fn bad_recordings_and_twins_are_refused_with_the_reason() {
    let folder = workshop();
    let at = folder.path();
    let write = |name: &str, text: &str| fs::write(at.join(name), text).unwrap();
    let recording = fs::read_to_string(at.join("rig.csv")).unwrap();
    let without_z: Vec<String> = recording
        .lines()
        .map(|line| match line.rsplit_once(',') {
            Some((rest, "z" | "0" | "1")) => rest.to_owned(),
            _ => line.to_owned(),
        })
        .collect();
    write("no-z.csv", &(without_z.join("\n") + "\n"));
    let short: Vec<&str> = recording.lines().take(500).collect();
    write("short.csv", &(short.join("\n") + "\n"));
    write("wrong.toml", &TWIN.replace("lines = 50", "lines = 60"));
    write("typo.toml", &TWIN.replace("width_a_rad", "widht_a_rad"));
    write("range.toml", &TWIN.replace("lines = 50", "lines = 0"));
    write(
        "hall.toml",
        &TWIN
            .replace(
                "[encoder.quadrature]\nlines = 50\nindex = true",
                "[encoder.hall]\npole_pairs = 2",
            )
            .replace("quadrature_rad = 6e-3", ""),
    );
    for (arguments, expected) in [
        (
            "calibrate no-z.csv --lines 50 -o t.qct",
            "no-z.csv: no index pulse",
        ),
        ("calibrate short.csv -o t.qct", "short.csv: "),
        (
            "calibrate short.csv --lines 50 -o t.qct",
            "whole turns can be used and three are needed",
        ),
        (
            "calibrate rig.csv --lines 60 -o t.qct",
            "the encoder has 50 lines, not 60; use --lines 50",
        ),
        (
            "calibrate rig.csv --twin wrong.toml -o t.qct",
            "use --lines 50 in place of --twin wrong.toml",
        ),
        (
            "calibrate rig.csv --twin hall.toml -o t.qct",
            "hall.toml: the twin declares three Hall sensors",
        ),
        (
            "calibrate rig.csv --twin typo.toml -o t.qct",
            "typo.toml:8:1: ",
        ),
        (
            "calibrate rig.csv --twin none.toml -o t.qct",
            "none.toml: can't read the twin",
        ),
        ("simulate typo.toml -o t.csv", "typo.toml:8:1: "),
        (
            "simulate range.toml -o t.csv --truth t2.csv",
            "range.toml:4:9: encoder.quadrature.lines = 0",
        ),
        (
            "simulate rig.toml -o t.txt",
            "t.txt: cannot tell the format",
        ),
        (
            "simulate rig.toml -o rig.toml",
            "rig.toml: is the input itself",
        ),
        (
            "calibrate rig.csv -o rig.csv",
            "rig.csv: is the input itself",
        ),
        (
            "calibrate missing.csv -o t.qct",
            "missing.csv: no such file",
        ),
    ] {
        let message = refused(&folder, arguments, 2);
        assert!(message.contains(expected), "{arguments}: {message}");
    }
}

#[test]
fn bad_tables_and_references_are_refused_with_the_reason() {
    let folder = workshop();
    let at = folder.path();
    let table = fs::read(at.join("rig.qct")).unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(at.join(name), bytes).unwrap();
    write("cut.qct", &table[..100]);
    write("none.qct", b"");
    let mut changed = table.clone();
    changed[80] ^= 1;
    write("changed.qct", &changed);
    changed = table.clone();
    changed[4] = 9;
    write("newer.qct", &changed);
    let other = TWIN.replace("lines = 50", "lines = 40");
    write("other.toml", other.as_bytes());
    done(at, "simulate other.toml -o other.csv");
    done(at, "calibrate other.csv -o other.qct");
    let reference = fs::read_to_string(at.join("ref.csv")).unwrap();
    let mut rows: Vec<&str> = reference.lines().collect();
    rows[9] = "0.01,NaN";
    write("nan.csv", rows.join("\n").as_bytes());
    write("late.csv", b"time,angle_rad\n1000,0\n1001,1\n");
    for (arguments, expected) in [
        ("--table rig.csv", "rig.csv: not an error table"),
        ("--table none.qct", "none.qct: the table is empty"),
        (
            "--table cut.qct",
            "cut.qct: the table is cut off: 100 of 468 bytes",
        ),
        (
            "--table changed.qct",
            "changed.qct: the table is damaged: its check sum",
        ),
        (
            "--table newer.qct",
            "newer.qct: the table has format version 9",
        ),
        ("--table gone.qct", "gone.qct: cannot be read"),
        (
            "--table other.qct",
            "other.qct: the table is for 160 edges a turn in 4 classes, the recording shows 200 in 4",
        ),
        (
            "--table rig.qct --reference nan.csv",
            "nan.csv:10: 'NaN' in column 'angle_rad'",
        ),
        (
            "--table rig.qct --reference late.csv",
            "late.csv: no edge of the recording",
        ),
        ("--table rig.qct --reference rig.csv", "rig.csv"),
    ] {
        let arguments = format!("verify rig.csv {arguments} --report t.html --json t.json");
        let message = refused(&folder, &arguments, 2);
        assert!(message.contains(expected), "{arguments}: {message}");
    }
}

#[test]
fn a_table_without_index_holds_for_its_own_recording_only() {
    let folder = workshop();
    let at = folder.path();
    let no_index = TWIN.replace("index = true", "index = false");
    fs::write(at.join("free.toml"), no_index).unwrap();
    done(at, "simulate free.toml -o free.csv");
    done(at, "simulate free.toml --seed 5 -o free2.csv");
    let text = done(
        at,
        "calibrate free.csv --twin free.toml --fraction 0.6 -o free.qct",
    );
    assert!(
        text.contains("the first edge (holds for this recording only)"),
        "{text}"
    );
    done(at, "verify free.csv --table free.qct");
    for recording in ["free2.csv", "rig.csv"] {
        let message = refused(&folder, &format!("verify {recording} --table free.qct"), 2);
        assert!(
            message.contains("holds only for the recording it was learned from"),
            "{message}"
        );
    }
    done(at, "calibrate free.csv --twin free.toml -o all.qct");
    let message = refused(&folder, "verify free.csv --table all.qct", 2);
    assert!(message.contains("no whole turn is left"), "{message}");
}

#[test]
fn a_wheel_with_a_gap_is_simulated_calibrated_and_verified() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("wheel.toml"), done(at, "simulate --example wheel")).unwrap();
    done(at, "simulate wheel.toml -o wheel.csv --turns 30");
    done(
        at,
        "calibrate wheel.csv --twin wheel.toml --turns 15 -o wheel.qct --report w.html",
    );
    let check = json(&done(
        at,
        "verify wheel.csv --table wheel.qct --missing 2 --json -",
    ));
    assert_eq!(check["verdict"], "better", "{check}");
}

#[test]
fn the_demo_writes_its_folder_and_its_files_work() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let text = done(at, "demo");
    assert!(text.contains("demo.html"), "{text}");
    let page = fs::read_to_string(at.join("quadcal-demo/demo.html")).unwrap();
    assert!(page.contains("137.50") && page.contains("hall-spindle") && !page.contains("NaN"));
    for name in ["paper-rig", "hall-spindle"] {
        let arguments =
            format!("verify quadcal-demo/{name}.csv --table quadcal-demo/{name}.qct --json -");
        let check = json(&done(at, &arguments));
        assert_eq!(check["verdict"], "better", "{name}");
        assert_eq!(check["same_recording"], true, "{name}");
    }
}

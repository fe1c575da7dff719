//! The `quadcal` command as a user meets it: what it prints, how it ends, and what it leaves behind.

mod workshop;

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use workshop::names;

/// Recordings that cannot be read.
const BAD: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cmd/bad-input.in");
/// Recordings shipped with the project.
const SHIPPED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/recordings");

fn quadcal(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_quadcal"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

#[test]
fn the_command_prints_what_is_written_down() {
    trycmd::TestCases::new()
        .env("COLUMNS", "100")
        .case("tests/cmd/*.trycmd");
}

#[test]
fn a_bad_recording_leaves_no_output_behind() {
    let mut tried = 0;
    for entry in fs::read_dir(BAD).unwrap() {
        let path = entry.unwrap().path();
        let list = if path.ends_with("list-times.txt") {
            "times"
        } else {
            "auto"
        };
        for name in ["out.csv", "out.vcd"] {
            let folder = tempfile::tempdir().unwrap();
            let path = path.to_str().unwrap();
            let output = quadcal(
                folder.path(),
                &["convert", path, "--list", list, "-o", name],
            );
            let message = stderr(&output);
            assert_eq!(output.status.code(), Some(2), "{path}: {message}");
            assert!(
                message.starts_with(&format!("quadcal: {path}")),
                "{message}"
            );
            assert_eq!(message.lines().count(), 1, "{message}");
            assert!(message.contains("; "), "no advice: {message}");
            assert_eq!(names(&folder), [""; 0], "{path}");
            tried += 1;
        }
    }
    assert!(tried >= 28, "{tried}");
}

#[test]
fn a_bad_recording_leaves_an_older_output_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("out.csv"), "precious").unwrap();
    let bad = format!("{BAD}/time-back.csv");
    let output = quadcal(folder.path(), &["convert", &bad, "-o", "out.csv"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(
        fs::read(folder.path().join("out.csv")).unwrap(),
        b"precious"
    );
    assert_eq!(names(&folder), ["out.csv"]);
}

#[test]
fn a_shipped_recording_survives_the_way_to_vcd_and_back() {
    let folder = tempfile::tempdir().unwrap();
    let original = format!("{SHIPPED}/hall-spindle.csv");
    for arguments in [
        ["convert", &original, "-o", "a.vcd"],
        ["convert", "a.vcd", "-o", "b.csv"],
    ] {
        let output = quadcal(folder.path(), &arguments);
        assert!(output.status.success(), "{}", stderr(&output));
        assert!(output.stdout.is_empty());
        let remark = format!("{}: 28700 rows written\n", arguments[3]);
        assert_eq!(stderr(&output), remark);
    }
    let rows = |path: &Path| -> Vec<String> {
        let text = fs::read_to_string(path).unwrap();
        let rows = text.lines().filter(|line| !line.starts_with('#'));
        rows.map(str::to_owned).collect()
    };
    let back = rows(&folder.path().join("b.csv"));
    assert_eq!(back.len(), 28_701);
    assert!(back == rows(original.as_ref()), "rows differ");
}

#[test]
fn the_input_is_never_the_output() {
    let folder = tempfile::tempdir().unwrap();
    let text = "# clock_hz = 1000\nticks,a\n1,0\n2,1\n";
    fs::write(folder.path().join("rec.csv"), text).unwrap();
    for arguments in [
        &["convert", "rec.csv", "-o", "./rec.csv"][..],
        &["info", "rec.csv", "--json", "rec.csv"],
    ] {
        let output = quadcal(folder.path(), arguments);
        assert_eq!(output.status.code(), Some(2));
        let message = stderr(&output);
        assert!(
            message.contains("rec.csv: is the input itself; "),
            "{message}"
        );
    }
    let after = fs::read_to_string(folder.path().join("rec.csv")).unwrap();
    assert_eq!(after, text);
}

#[test]
fn an_output_that_cannot_be_written_is_no_fault_of_the_input() {
    let folder = tempfile::tempdir().unwrap();
    let original = format!("{SHIPPED}/hall-hub-motor.csv");
    let output = quadcal(folder.path(), &["convert", &original, "-o", "none/out.csv"]);
    assert_eq!(output.status.code(), Some(1));
    let message = stderr(&output);
    assert!(
        message.starts_with("quadcal: none/out.csv: cannot be written (")
            && message.lines().count() == 1,
        "{message}"
    );
    let output = quadcal(folder.path(), &["convert", &original, "-o", "out.dat"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(names(&folder).is_empty());
}

#[test]
fn a_reader_that_has_seen_enough_is_no_failure() {
    let original = format!("{SHIPPED}/hall-spindle.csv");
    let mut child = Command::new(env!("CARGO_BIN_EXE_quadcal"))
        .args(["convert", &original, "-o", "-", "--to", "csv"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut first = String::new();
    let stdout = child.stdout.take().unwrap();
    BufReader::with_capacity(64, stdout)
        .read_line(&mut first)
        .unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(first, "# clock_hz = 30000\n");
    assert_eq!(stderr(&output), "");
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn json_goes_to_a_file_beside_the_text_or_to_stdout_alone() {
    let folder = tempfile::tempdir().unwrap();
    let original = format!("{SHIPPED}/hall-hub-motor.csv");
    let both = quadcal(folder.path(), &["info", &original, "--json", "info.json"]);
    assert!(both.stdout.starts_with(b"File "));
    let alone = quadcal(folder.path(), &["info", &original, "--json", "-"]);
    let written = fs::read(folder.path().join("info.json")).unwrap();
    assert_eq!(alone.stdout, written);
    let value: serde_json::Value = serde_json::from_slice(&written).unwrap();
    assert_eq!(value["channels"], "hall");
    assert_eq!(value["edges"], 2843);
}

#[test]
fn every_shell_gets_a_script_that_knows_the_commands() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = quadcal(folder.path(), &["completions", shell]);
        let script = String::from_utf8(output.stdout).unwrap();
        assert!(
            output.status.success() && script.contains("convert"),
            "{shell}"
        );
    }
}

//! `quadcal device watch`, and what Ctrl-C does.
#![cfg(unix)]

mod pretended;

use std::fs;
use std::process::Stdio;

use pretended::{Bench, QUICK, number, small};
use serde_json::Value;

#[test]
fn watching_shows_a_rough_speed_before_and_a_smooth_one_after() {
    let bench = Bench::start(&small());
    bench.done(&format!("{QUICK} --commit"));
    let lines = bench.done("watch --turns 25 --rate 100 --json -");
    let lines: Vec<Value> = lines
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let (summary, samples) = lines.split_last().unwrap();
    assert_eq!(summary["kind"], "summary");
    assert!(samples.len() > 10 && samples.iter().all(|sample| sample["kind"] == "sample"));
    assert_eq!(summary["samples"], samples.len());
    assert!(
        (25.0..200.0).contains(&number(&summary["turns"])),
        "{summary}"
    );
    assert!(
        (number(&summary["rev_per_min_mean"]) - 1500.0).abs() < 15.0,
        "{summary}"
    );
    let before = number(&summary["rev_per_min_scatter_before"]);
    let after = number(&summary["rev_per_min_scatter_after"]);
    assert!(before > 5.0 * after, "{before} {after}");
    assert!(samples.last().unwrap()["referenced"] == true);
    // Without a terminal, a line a sample and the facts; quietly, the facts alone.
    let text = bench.done("watch --seconds 0.4 --rate 50");
    assert!(text.starts_with("time_s  r_min_before"), "{text}");
    assert!(
        text.contains("Scatter after correction") && text.lines().count() > 10,
        "{text}"
    );
    assert!(
        bench
            .done("watch --seconds 0.2 --quiet")
            .starts_with("Port ")
    );
    // Into a file, the text stays.
    let text = bench.done("watch --seconds 0.2 --quiet --json samples.json");
    let written = fs::read_to_string(bench.path().join("samples.json")).unwrap();
    assert!(text.starts_with("Port ") && written.contains("\"kind\":\"summary\""));
}

#[test]
fn watching_ends_cleanly_on_ctrl_c() {
    let bench = Bench::start(&small());
    let mut child = bench
        .command("watch --json -")
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let first = pretended::line(child.stdout.as_mut());
    assert!(first.contains("sample"), "{first}");
    pretended::interrupt(&child);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.lines().last().unwrap().contains("summary"), "{text}");
}

#[test]
fn a_calibration_ended_by_ctrl_c_is_aborted_on_the_device() {
    let mut pretend = small();
    pretend.r_min = 0.0;
    let bench = Bench::start(&pretend);
    let mut child = bench
        .command(QUICK)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let first = pretended::line(child.stderr.as_mut());
    assert_eq!(first, "waiting for the shaft to turn");
    pretended::interrupt(&child);
    let output = child.wait_with_output().unwrap();
    let text = pretended::message(&output, 1);
    assert!(text.contains("told to abort"), "{text}");
    assert!(String::from_utf8_lossy(&output.stdout).contains("stopped; "));
    assert_eq!(bench.json("status")["stage"], "idle");
}

#[test]
fn while_it_waits_for_a_speed_it_says_how_the_shaft_turns() {
    let bench = Bench::start(&small());
    let mut command = bench.command(&format!("{QUICK} --from 3000 --to 4000"));
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut told = String::new();
    while !told.contains(" r/min is below 3000 r/min") {
        told = pretended::line(child.stderr.as_mut());
        assert!(!told.is_empty());
    }
    pretended::interrupt(&child);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(bench.json("status")["stage"], "idle");
}

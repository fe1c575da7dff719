//! `quadcal device` where the drive says no, the new table is no better, or a table does not fit.
#![cfg(unix)]

mod pretended;

use std::fs;

use pretended::{Bench, QUICK, message, small};
use quadcal::recalibrate::Obstacle;
use quadcal_host::pretend::Pretend;

#[test]
fn the_drive_may_refuse_to_calibrate_and_to_commit() {
    let mut pretend = small();
    pretend.calibrate_obstacle = Some(Obstacle::Disabled);
    let bench = Bench::start(&pretend);
    let text = bench.refused(QUICK, 1);
    assert!(
        text.contains("the drive is not enabled; enable it"),
        "{text}"
    );
    pretend.calibrate_obstacle = None;
    pretend.commit_obstacle = Some(Obstacle::Moving);
    let bench = Bench::start(&pretend);
    let output = bench.run(&format!("{QUICK} --commit"));
    let text = message(&output, 1);
    assert!(
        text.contains("'commit' is refused: the shaft turns; bring it to rest"),
        "{text}"
    );
    assert!(
        text.contains("the new table waits, 15 min: then use 'quadcal device commit'"),
        "{text}"
    );
    let shown = String::from_utf8(output.stdout).unwrap();
    assert!(
        shown.contains("certainly better") && shown.contains("the new table waits, 15 min"),
        "{shown}"
    );
    // The table is not lost by it, nor is the session left open.
    assert_eq!(bench.json("status")["session_open"], false);
    assert_eq!(bench.json("status")["stage"], "ready_to_commit");
    assert_eq!(bench.json("status")["table"], serde_json::Value::Null);
    assert!(bench.refused("commit", 1).contains("waits, 15 min"));
    bench.done("abort");
    let output = bench.run(&format!("{QUICK} --commit --json -"));
    message(&output, 1);
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(result["outcome"], "waiting");
    assert_eq!(result["proof"]["better"], true);
    assert_eq!(result["table"], serde_json::Value::Null);
    bench.done("abort");
    let text = bench.refused("erase --yes", 1);
    assert!(text.contains("the shaft turns"), "{text}");
    let window = bench.refused(&format!("{QUICK} --from 900 --to 800"), 1);
    assert!(window.contains("widen --from and --to"), "{window}");
}

#[test]
fn a_table_that_is_no_better_is_refused_with_its_figures() {
    let bench = Bench::start(&small());
    bench.done("recalibrate --turns 60 --commit");
    // A tenth of the turns is no match for that.
    let output = bench.run("recalibrate --turns 6 --commit --json -");
    let text = message(&output, 1);
    assert!(text.contains("not better than the one in use"), "{text}");
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(result["outcome"], "failed");
    assert_eq!(result["failure"]["reason"], "not_better");
    assert_eq!(result["proof"]["better"], false);
    assert_eq!(result["table"], serde_json::Value::Null);
    let status = bench.json("status");
    assert_eq!(status["failure"]["reason"], "not_better");
    assert_eq!(status["table"]["sequence"], 0);
}

#[test]
fn a_loaded_table_that_is_worse_is_committed_only_by_force() {
    let bench = Bench::start(&small());
    bench.done(&format!("{QUICK} --commit"));
    bench.done("dump -o own.qct");
    let other = Bench::start(&Pretend { seed: 2, ..small() });
    other.done(&format!("{QUICK} --commit"));
    other.done("dump -o other.qct");
    let own = bench.path().join("own.qct").display().to_string();
    // Better than none, on a drive with the same disc.
    let fresh = Bench::start(&small());
    let output = fresh.run(&format!("load {own} --commit --json -"));
    assert!(output.status.success() && output.stderr.is_empty());
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(result["proof"]["better"], true);
    assert_eq!(result["proof"]["worse"], false);
    // Another disc's.
    let table = other.path().join("other.qct");
    let load = format!("load {} --commit", table.display());
    let output = bench.run(&format!("{load} --json -"));
    let refused = message(&output, 1);
    assert!(
        refused.contains("WORSE than the table in use, so it is not committed; it waits"),
        "{refused}"
    );
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (&result["outcome"], &result["committed"]),
        (&"worse".into(), &false.into())
    );
    let status = bench.json("status");
    assert_eq!(status["stage"], "ready_to_commit");
    assert_eq!(status["table"]["sequence"], 0);
    bench.done("abort");
    let output = bench.run(&format!("{load} --force"));
    let [text, warning] =
        [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    assert!(
        warning.starts_with("Warning: on fresh turns the loaded table is WORSE"),
        "{warning}"
    );
    assert!(
        text.contains("The new table is          WORSE")
            && text.contains("times as much")
            && text.contains("the new table is in flash and in use")
            && text.contains("number 1 at place B"),
        "{text}"
    );
    assert_eq!(bench.json("preview")["proof"]["worse"], true);
    // At a standstill there is nothing to go by.
    let still = Bench::start(&Pretend {
        r_min: 0.0,
        ..small()
    });
    let result = still.json(&format!("load {own} --commit"));
    assert_eq!(result["proof"], serde_json::Value::Null);
    assert_eq!(
        (&result["outcome"], &result["committed"]),
        (&"committed".into(), &true.into())
    );
    let text = still.done(&format!("load {own} --commit"));
    assert!(
        text.contains("not compared: the shaft stands still"),
        "{text}"
    );
}

#[test]
fn a_table_that_does_not_fit_is_refused_before_anything_is_sent() {
    let bench = Bench::start(&small());
    bench.done(&format!("{QUICK} --commit"));
    bench.done("dump -o good.qct");
    let good = fs::read(bench.path().join("good.qct")).unwrap();
    let mut larger = small();
    larger.lines = 80;
    let other = Bench::start(&larger);
    let mut stranger = small();
    stranger.serial = 8;
    let stranger = Bench::start(&stranger);
    let table = bench.path().join("good.qct");
    let load = format!("load {} --commit", table.display());
    let text = other.refused(&load, 2);
    assert!(
        text.contains("256 edges a turn in 4 classes, the device's has 320 in 4; "),
        "{text}"
    );
    let text = stranger.refused(&load, 2);
    assert!(
        text.contains("of encoder 7, the device has encoder 8; "),
        "{text}"
    );
    let mut damaged = good.clone();
    damaged[200] ^= 4;
    fs::write(bench.path().join("bad.qct"), damaged).unwrap();
    assert!(
        bench
            .refused("load bad.qct", 2)
            .contains("bad.qct: the table is damaged")
    );
    fs::write(bench.path().join("bad.qct"), &good[..300]).unwrap();
    assert!(bench.refused("load bad.qct", 2).contains("cut off"));
    assert!(bench.refused("load none.qct", 2).contains("cannot be read"));
    assert_eq!(bench.json("status")["stage"], "done");
    // Longer files are taken as far as the table goes.
    let mut longer = good;
    longer.extend([1, 2, 3]);
    fs::write(bench.path().join("long.qct"), longer).unwrap();
    assert_eq!(bench.json("load long.qct --commit")["committed"], true);
}

#[test]
fn a_dump_leaves_an_older_file_as_it_was_when_it_fails() {
    let bench = Bench::start(&small());
    fs::write(bench.path().join("old.qct"), "precious").unwrap();
    assert!(bench.refused("dump -o old.qct", 1).contains("has no table"));
    assert_eq!(fs::read(bench.path().join("old.qct")).unwrap(), b"precious");
    assert_eq!(bench.files(), ["old.qct"]);
    bench.done(&format!("{QUICK} --commit"));
    assert!(
        bench
            .refused("dump -o missing/t.qct", 1)
            .contains("cannot be written")
    );
}

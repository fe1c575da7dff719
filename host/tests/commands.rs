//! Simulate, calibrate, verify and demo as a user meets them, the whole way.

mod workshop;

use std::fs;

use workshop::{TWIN, done, json, workshop};

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
fn every_start_without_an_index_finds_the_place_that_the_index_has() {
    let folder = workshop();
    let at = folder.path();
    // Same disc, forward and at another speed; and the recording learned from, on later turns.
    fs::write(at.join("fast.toml"), TWIN.replace("= 600", "= 900")).unwrap();
    done(at, "simulate fast.toml -o fast.csv");
    for (recording, same) in [("fast.csv", false), ("rig.csv", true)] {
        let arguments = format!("locate {recording} --table rig.qct --starts 50 --json -");
        let found = json(&done(at, &arguments));
        assert_eq!(found["same_recording"], same);
        let number = |key: &str| found[key].as_f64().unwrap();
        // The last start or two have too few edges left.
        assert!(number("found") >= 45.0, "{found}");
        // Before its first index a recording can't bear a place out.
        assert!(number("agree_with_index") >= 45.0, "{found}");
        assert_eq!(found["disagree_with_index"], 0);
        assert_eq!(found["refused"], 0);
        assert!(number("error_probability") < 1e-7, "{found}");
        assert!(number("degrees_most") < 150.0, "{found}");
    }
    // A table whose zero is the first edge is of use for other recordings too.
    let free = TWIN.replace("index = true", "index = false");
    fs::write(at.join("free.toml"), free).unwrap();
    done(at, "simulate free.toml -o free.csv");
    done(at, "calibrate free.csv --twin free.toml -o free.qct");
    let text = done(at, "locate fast.csv --table free.qct --starts 20");
    assert!(text.contains("can't be checked"), "{text}");
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

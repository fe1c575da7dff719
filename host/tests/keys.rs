//! `quadcal simulate --keys` names every key that a twin may have and none besides; the examples run.

mod workshop;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use quadcal_host::twin::Twin;
use workshop::{done, json};

/// What may stand in the table `path` (`ripple[]`, `errors.position`), as the reader itself says of a key that may not.
fn allowed_in(path: &str) -> BTreeSet<String> {
    let text = match path {
        "" => "zzz = 1\n".to_owned(),
        list if list.ends_with("[]") => format!("[[{}]]\nzzz = 1\n", list.trim_end_matches("[]")),
        table => format!("[{table}]\nzzz = 1\n"),
    };
    let message = Twin::parse(&text, "t").unwrap_err().to_string();
    if let Some((_, keys)) = message.split_once("available keys: ") {
        let keys = keys.split(';').next().unwrap_or_default();
        return keys.split(", ").map(str::to_owned).collect();
    }
    let (_, expected) = message
        .split_once("expected ")
        .unwrap_or_else(|| panic!("{path}: {message}"));
    expected
        .split('`')
        .skip(1)
        .step_by(2)
        .map(str::to_owned)
        .collect()
}

#[test]
fn every_key_is_listed_and_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let text = done(folder.path(), "simulate --keys");
    let keys: Vec<&str> = text
        .lines()
        .skip(1)
        // Notes follow behind an empty line.
        .take_while(|line| !line.is_empty())
        .map(|line| line.split_whitespace().next().unwrap())
        .collect();
    assert!(keys.len() > 60, "{text}");
    // What the list has under each table on the way to a key.
    let mut listed: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for key in keys {
        let mut path = String::new();
        for name in key.split('.') {
            let bare = name.trim_end_matches("[]").to_owned();
            listed.entry(path.clone()).or_default().insert(bare);
            path = if path.is_empty() {
                name.to_owned()
            } else {
                format!("{path}.{name}")
            };
        }
    }
    for (path, names) in listed {
        assert_eq!(names, allowed_in(&path), "in '{path}'");
    }
}

#[test]
fn the_pair_tells_torque_from_eccentricity_and_the_delays_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for name in ["pair-slow", "pair-fast", "delays", "load-step"] {
        let twin = done(at, &format!("simulate --example {name}"));
        fs::write(at.join(format!("{name}.toml")), twin).unwrap();
        done(at, &format!("simulate {name}.toml -o {name}.csv"));
    }
    let arguments =
        "calibrate pair-slow.csv pair-fast.csv --inertia 1e-4 -o t.qct --csv t.csv --json -";
    let found = json(&done(at, arguments));
    let ripple = found["torque_ripple"].as_array().unwrap();
    for (order, torque) in [(5, 1e-3), (10, 5e-4)] {
        let there = ripple
            .iter()
            .find(|ripple| ripple["order"] == order)
            .unwrap();
        let size = there["torque_n_m"].as_f64().unwrap();
        assert!((size / torque - 1.0).abs() < 0.05, "{there}");
    }
    let (before, after) = ("expected_error_before_rad", "expected_error_after_rad");
    let number = |key: &str| found[key].as_f64().unwrap();
    assert!(number(after) < 0.1 * number(before), "{found}");
    let found = json(&done(at, "calibrate delays.csv -o t.qct --json -"));
    assert_eq!(found["delays"].as_array().unwrap().len(), 3, "{found}");
}

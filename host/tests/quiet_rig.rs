//! Rigs so quiet that what is missing is all that there is of noise.

mod workshop;

use std::fs;
use std::path::Path;

use serde_json::Value;
use workshop::{done, json};

/// The printed paper twin, of fewer lines, with its ripples and without.
fn paper(at: &Path, lines: u32) -> (String, String) {
    let lines = format!("lines = {lines}");
    let twin = done(at, "simulate --example paper").replace("lines = 2500", &lines);
    let ripples = twin.find("# 5 pole pairs").unwrap()..twin.find("[timer]").unwrap();
    let plain = twin.replace(&twin[ripples], "");
    (twin, plain)
}

/// What a twin lacks of the rig of another one.
fn missing(at: &Path, rig: &str, twin: &str) -> Vec<Value> {
    fs::write(at.join("rig.toml"), rig).unwrap();
    fs::write(at.join("twin.toml"), twin).unwrap();
    done(at, "simulate rig.toml -o rec.csv");
    let answer = json(&done(at, "diagnose rec.csv --twin twin.toml --json -"));
    answer["findings"].as_array().unwrap().clone()
}

#[test]
fn three_ripples_that_are_missing_are_found_at_their_orders_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let (rig, twin) = paper(folder.path(), 250);
    let mut orders: Vec<u32> = Vec::new();
    for finding in missing(folder.path(), &rig, &twin) {
        assert_eq!(finding["mechanism"], "torque_ripple", "{finding}");
        let of = finding["where"]["orders"].as_array().unwrap().iter();
        orders.extend(of.map(|order| order.as_f64().unwrap().round() as u32));
    }
    orders.sort_unstable();
    assert_eq!(orders, [5, 10, 15]);
}

#[test]
fn a_tilt_that_moves_other_edges_to_where_the_shaft_starts_is_a_tilt() {
    let folder = tempfile::tempdir().unwrap();
    let (_, twin) = paper(folder.path(), 1000);
    let twin = twin
        .replace("index = true", "index = false")
        .replace("[shaft]\n", "[shaft]\ninitial_angle_rad = 6.0\n");
    let twin = format!("{twin}jitter_s = 3e-7\n[noise.white]\npsd_n2_m2_s = 1e-13\n");
    let tilt = "tilt = { amplitude_rad = 6e-3, phase_rad = 0.4 }\n[shaft]\n";
    let rig = twin.replace("[shaft]\n", tilt);
    let found = missing(folder.path(), &rig, &twin);
    let names = found.iter().map(|finding| &finding["mechanism"]);
    assert_eq!(names.collect::<Vec<_>>(), ["disc_tilt"]);
}

//! `quadcal diagnose` as a user meets it: what is refused and why, and what is written.

mod workshop;

use std::fs;

use quadcal_host::twin::Twin;
use workshop::{QUADRATURE, TWIN, bench, done, json, refused};

#[test]
fn bad_twins_are_refused_with_their_line() {
    let folder = bench();
    for (name, change, with, expected) in [
        (
            "typo.toml",
            "width_a_rad",
            "widht_a_rad",
            "typo.toml:8:1: errors.widht_a_rad: unknown field",
        ),
        (
            "unit.toml",
            "inertia_kg_m2",
            "inertia",
            "unit.toml:11:1: shaft",
        ),
        (
            "text.toml",
            "r_min = 600",
            "r_min = \"600 r/min\"",
            "text.toml:14:9: drive.constant",
        ),
        (
            "range.toml",
            "lines = 50",
            "lines = 0",
            "range.toml:4:9: encoder.quadrature.lines = 0",
        ),
        ("cross.toml", "4e-3", "1.5", "cross.toml: errors: edge "),
    ] {
        fs::write(folder.path().join(name), TWIN.replace(change, with)).unwrap();
        let message = refused(&folder, &format!("diagnose rig.csv --twin {name}"), 2);
        assert!(message.contains(expected), "{name}: {message}");
    }
    let message = refused(&folder, "diagnose rig.csv --twin gone.toml", 2);
    assert!(message.contains("gone.toml: can't read"), "{message}");
}

#[test]
fn a_twin_of_another_encoder_is_refused() {
    let folder = bench();
    let at = folder.path();
    let write = |name: &str, text: &str| fs::write(at.join(name), text).unwrap();
    let columns = |keep: usize| -> String {
        let text = fs::read_to_string(at.join("rig.csv")).unwrap();
        let lines = text.lines().map(|line| match line.starts_with('#') {
            true => line.to_owned(),
            false => line.split(',').take(keep).collect::<Vec<_>>().join(","),
        });
        lines.collect::<Vec<_>>().join("\n") + "\n"
    };
    write("ab.csv", &columns(3));
    write("a.csv", &columns(2));
    write("60.toml", &TWIN.replace("lines = 50", "lines = 60"));
    write("no-z.toml", &TWIN.replace("index = true", "index = false"));
    write(
        "clock.toml",
        &TWIN.replace("clock_hz = 84_000_000", "clock_hz = 72_000_000"),
    );
    write(
        "wheel.toml",
        &TWIN
            .replace(QUADRATURE, "[encoder.wheel]\nteeth = 5")
            .replace("quadrature_rad = 6e-3", ""),
    );
    write(
        "30.toml",
        &TWIN
            .replace(QUADRATURE, "[encoder.hall]\npole_pairs = 3")
            .replace("quadrature_rad = 6e-3", ""),
    );
    for (arguments, expected) in [
        (
            "rig.csv --twin 60.toml",
            "declares 60 lines a turn, the recording's edges between two index pulses make 50",
        ),
        (
            "hall.csv --twin 30.toml",
            "declares 3 pole pairs a turn, the recording's header says 2",
        ),
        (
            "rig.csv --twin hall.toml",
            "rig.csv: another encoder than in hall.toml: the twin declares three Hall sensors",
        ),
        ("rig.csv --twin wheel.toml", "declares a toothed wheel"),
        (
            "rig.csv --twin clock.toml",
            "rig.csv: its header says clock_hz = 84000000, clock.toml says timer.clock_hz = 72000000",
        ),
        ("a.csv --twin rig.toml", "the recording is of one channel"),
        ("ab.csv --twin rig.toml", "set index = false"),
        (
            "rig.csv hall.csv --twin rig.toml --twin hall.toml",
            "hall.toml: declares another encoder than rig.toml",
        ),
        ("rig.csv rig.csv --twin rig.toml", "the same recording"),
        (
            "rig.csv --twin rig.toml --twin rig.toml",
            "given 2 times for 1 recording",
        ),
    ] {
        let message = refused(&folder, &format!("diagnose {arguments}"), 2);
        assert!(message.contains(expected), "{arguments}: {message}");
    }
}

#[test]
fn results_that_would_take_each_others_place_are_refused() {
    let folder = bench();
    for (results, expected) in [
        ("--json one --report one", "one: named for two results"),
        (
            "--json new.toml --write-twin new.toml",
            "named for two results",
        ),
        (
            "--report new.errors.csv --write-twin new.toml",
            "new.errors.csv: named for two results",
        ),
        ("--write-twin rig.toml", "rig.toml: is the input itself"),
        ("--json rig.csv", "rig.csv: is the input itself"),
        ("--json ./one --report one", "./one: named for two results"),
        (
            "--json - --report -",
            "quadcal: standard output: named for two results; give each its own file",
        ),
    ] {
        let arguments = format!("diagnose rig.csv --twin rig.toml {results}");
        let message = refused(&folder, &arguments, 2);
        assert!(message.contains(expected), "{arguments}: {message}");
    }
    let message = refused(
        &folder,
        "diagnose rig.csv --twin rig.toml --json found.json --write-twin gone/new.toml",
        1,
    );
    assert!(
        message.starts_with("quadcal: gone/new.")
            && message.contains(": cannot be written (No such file or directory"),
        "{message}"
    );
    assert!(!message.contains(".part"), "{message}");
}

#[test]
fn a_report_on_stdout_stands_alone() {
    let folder = bench();
    let page = done(
        folder.path(),
        "diagnose rig.csv --twin rig.toml --report - --json found.json",
    );
    assert!(
        page.starts_with("<!") && page.trim_end().ends_with("</html>"),
        "{page}"
    );
}

#[test]
fn everything_asked_for_is_written() {
    let folder = bench();
    let at = folder.path();
    let text = done(
        at,
        "diagnose rig.csv again.csv --twin rig.toml --json found.json --report found.html --write-twin new.toml",
    );
    let found = json(&fs::read_to_string(at.join("found.json")).unwrap());
    assert_eq!(found["version"], 2);
    let verdict = found["verdict"].as_str().unwrap();
    let said = text.lines().next().unwrap();
    assert!(
        said.starts_with("Verdict") && said.contains(&format!(" {verdict}: ")),
        "{text}"
    );
    assert_eq!(found["recordings"][1]["file"], "again.csv");
    assert_eq!(found["recordings"][1]["twin"], "rig.toml");
    let page = fs::read_to_string(at.join("found.html")).unwrap();
    assert!(
        page.contains("rig.csv and again.csv against rig.toml"),
        "{page}"
    );
    let new = Twin::load(&at.join("new.toml")).unwrap();
    assert_eq!(new.encoder, Twin::parse(TWIN, "rig.toml").unwrap().encoder);
    done(at, "simulate new.toml -o new.csv");
    let printed = done(at, "diagnose rig.csv --twin rig.toml --json -");
    assert_eq!(json(&printed)["recordings"][0]["file"], "rig.csv");
}

#[test]
fn what_a_diagnosis_can_name_is_printed_in_a_list_and_card_by_card() {
    let folder = bench();
    let list = done(folder.path(), "diagnose --mechanisms");
    let ids: Vec<&str> = list
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .collect();
    assert_eq!(ids.len(), 28);
    for id in ids {
        let card = done(folder.path(), &format!("diagnose --mechanisms {id}"));
        assert!(card.starts_with(&format!("{id}: ")), "{card}");
        assert!(card.contains("\nPhysics ") && card.contains("\nTold apart by "));
    }
    let card = done(folder.path(), "diagnose --mechanisms edge_delay");
    for part in [
        "Equation         e = -w (d_rise - d_fall) on rising levels, 0 on falling ones\n",
        "Size in angle    speed^1\n",
        "In the twin      edge_delay\n",
        "Look-alikes      width_error, threshold_drift\n",
        "  b.rise_less_fall_s  s  -0.05 to 0.05     the same of B\n",
    ] {
        assert!(card.contains(part), "{part}\n{card}");
    }
    for (arguments, expected) in [
        ("--mechanisms gremlins", "'--mechanisms' alone prints"),
        (
            "rig.csv --twin rig.toml --mechanisms",
            "cannot be used with",
        ),
    ] {
        let output = workshop::quadcal(folder.path(), &format!("diagnose {arguments}"));
        assert_eq!(output.status.code(), Some(2), "{arguments}");
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains(expected), "{message}");
    }
}

//! The turns that a calibration throws out, as a user is told of them.

mod workshop;

use std::fs;
use std::path::Path;

use workshop::{TWIN, done, json};

#[test]
fn the_turns_that_a_load_hits_are_named_with_number_time_and_reason() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let twin = Path::new(env!("CARGO_MANIFEST_DIR")).join("twins/load-step.toml");
    fs::copy(twin, at.join("load.toml")).unwrap();
    done(at, "simulate load.toml -o load.csv");
    let text = done(
        at,
        "calibrate load.csv -o t.qct --json t.json --report t.html",
    );
    let found = json(&fs::read_to_string(at.join("t.json")).unwrap());
    let rejected = found["recordings"][0]["turns_rejected"].as_array().unwrap();
    let hit: Vec<_> = rejected
        .iter()
        .map(|turn| turn["turn"].as_u64().unwrap())
        .collect();
    assert!([6, 9, 10].iter().all(|turn| hit.contains(turn)), "{hit:?}");
    // Beside them the turn after may be left out, in which the shaft comes back.
    assert!(
        hit.iter().all(|turn| [6, 7, 9, 10, 11].contains(turn)),
        "{hit:?}"
    );
    assert_eq!(found["turns"]["disagrees"], hit.len());
    assert_eq!(found["recordings"][0]["turns_rejected_not_listed"], 0);
    let sixth = &rejected[0];
    assert_eq!(
        (&sixth["turn"], &sixth["reason"]),
        (&6.into(), &"disagrees".into())
    );
    // Five turns and the 0.15 of one before the index, of 0.1 s each.
    let start = sixth["start_s"].as_f64().unwrap();
    assert!((start - 0.515).abs() < 1e-3, "{start}");
    assert!((sixth["seconds"].as_f64().unwrap() - 0.1).abs() < 1e-3);
    assert!(
        text.contains("    Turn 6 ")
            && text.contains("disagrees with its neighbours; begins at 0.51"),
        "{text}"
    );
    let page = fs::read_to_string(at.join("t.html")).unwrap();
    assert!(
        page.contains("Turns rejected of load.csv")
            && page.contains("disagrees with its neighbours")
    );
}

#[test]
fn of_many_broken_turns_the_terminal_names_five_and_the_json_all() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    // An edge amid each of nine turns; 200 edges a turn.
    let lost: Vec<String> = (6..15).map(|turn| (200 * turn + 100).to_string()).collect();
    let faults = format!("{TWIN}[faults]\nlost_edges = [{}]\n", lost.join(", "));
    fs::write(at.join("lossy.toml"), faults).unwrap();
    done(at, "simulate lossy.toml -o lossy.csv");
    let text = done(at, "calibrate lossy.csv -o t.qct --json t.json");
    let found = json(&fs::read_to_string(at.join("t.json")).unwrap());
    let rejected = found["recordings"][0]["turns_rejected"].as_array().unwrap();
    let numbers: Vec<_> = rejected
        .iter()
        .map(|turn| turn["turn"].as_u64().unwrap())
        .collect();
    let first = numbers[0];
    assert_eq!(numbers, (first..first + 9).collect::<Vec<_>>(), "{found}");
    for turn in rejected {
        assert_eq!(turn["reason"], "broken");
        assert_eq!(turn["why"], "broken edges");
        assert!(
            (turn["seconds"].as_f64().unwrap() - 0.1).abs() < 1e-3,
            "{turn}"
        );
    }
    assert_eq!(text.matches("    Turn ").count(), 5, "{text}");
    assert!(text.contains("    and 4 more"), "{text}");
}

#[test]
fn a_coarse_clock_rejects_hardly_a_turn() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let example = done(at, "simulate --example hall");
    fs::write(at.join("hall.toml"), example).unwrap();
    done(at, "simulate hall.toml -o hall.csv");
    let text = done(at, "calibrate hall.csv -o t.qct --json t.json");
    let found = json(&fs::read_to_string(at.join("t.json")).unwrap());
    assert!(found["turns"]["used"].as_u64().unwrap() > 390, "{found}");
    // The header says two pole pairs; the intervals seem to repeat after others.
    assert!(
        text.contains("three Hall sensors, 2 pole pairs, counted"),
        "{text}"
    );
    let recording = fs::read_to_string(at.join("hall.csv")).unwrap();
    fs::write(
        at.join("silent.csv"),
        recording.replace("# pole_pairs = 2\n", ""),
    )
    .unwrap();
    let text = done(at, "calibrate silent.csv -o t.qct");
    assert!(
        text.contains("guessed from how the intervals repeat; --lines says it"),
        "{text}"
    );
}

#[test]
fn the_step_of_a_logic_analyser_s_times_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let example = done(at, "simulate --example hall");
    fs::write(
        at.join("hall.toml"),
        example.replace("30_000", "24_000_000"),
    )
    .unwrap();
    done(at, "simulate hall.toml -o hall.csv");
    // The same as an analyser of 24 MHz exports it.
    let recording = fs::read_to_string(at.join("hall.csv")).unwrap();
    let rows = recording.lines().filter_map(|line| line.split_once(','));
    let logic = rows.filter_map(|(ticks, levels)| {
        let seconds = ticks.parse::<f64>().ok()? / 24e6;
        Some(format!("{seconds:.9},{levels}\n"))
    });
    let logic: String = logic.collect();
    fs::write(at.join("logic.csv"), format!("Time [s],A,B,C\n{logic}")).unwrap();
    let text = done(at, "info logic.csv");
    assert!(
        text.contains("a step of 41.7 ns, as if sampled at 24.0 MHz"),
        "{text}"
    );
    let found = json(&done(at, "info logic.csv --json -"));
    assert!((found["time_step_s"].as_f64().unwrap() * 24e6 - 1.0).abs() < 1e-9);
    assert!(!done(at, "info hall.csv").contains("a step of"));
}

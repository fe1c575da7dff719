//! What a check refuses: another disc's table, less than a turn, a reference of another run; and which turns it leaves out.

mod workshop;

use std::fs;
use std::path::Path;

use workshop::{TWIN, done, json, refused, workshop};

fn simulated(at: &Path, name: &str, twin: &str, options: &str) {
    fs::write(at.join(format!("{name}.toml")), twin).unwrap();
    done(at, &format!("simulate {name}.toml -o {name}.csv {options}"));
}

#[test]
fn the_table_of_another_disc_is_refused_though_its_widths_fit() {
    let folder = workshop();
    let at = folder.path();
    // Widths and quadrature alike, line errors another disc's: the scatter is better all the same.
    let other = TWIN
        .replace("2e-3", "5e-4")
        .replace("[errors]", "[errors]\nseed = 9");
    simulated(at, "other", &other, "");
    simulated(at, "own", &other.replace("= 600", "= 900"), "");
    let first = other.replace("seed = 9", "seed = 10");
    simulated(at, "first", &first, "");
    done(at, "calibrate first.csv -o first.qct");
    done(at, "calibrate other.csv --turns 11 -o other.qct");
    let arguments = "verify other.csv --table first.qct";
    let message = refused(&folder, arguments, 1);
    assert!(
        message.starts_with("quadcal: first.qct: this table belongs to another disc"),
        "{message}"
    );
    let output = workshop::quadcal(at, &format!("{arguments} --report v.html --json -"));
    let check = json(&String::from_utf8(output.stdout).unwrap());
    assert_eq!(check["verdict"], "other_disc");
    let better = |key: &str| check[key].as_f64().unwrap();
    assert!(
        better("scatter_after") < better("scatter_before"),
        "{check}"
    );
    let page = fs::read_to_string(at.join("v.html")).unwrap();
    assert!(page.contains("The table is of another disc") && page.contains("verdict bad"));
    for recording in ["other.csv", "own.csv"] {
        let arguments = format!("verify {recording} --table other.qct --json -");
        let check = json(&done(at, &arguments));
        assert_eq!(check["verdict"], "better");
        let found = check["pattern_found"].as_f64().unwrap();
        assert!((found - 1.0).abs() < 0.05, "{check}");
    }
}

#[test]
fn less_than_a_turn_is_too_little_to_check_on() {
    let folder = workshop();
    let at = folder.path();
    // One turn follows those learned from, and a few edges: so much can be held against the turn about it.
    simulated(at, "short", TWIN, "--turns 14.1");
    done(at, "calibrate short.csv --turns 11 -o short.qct");
    let message = refused(&folder, "verify short.csv --table short.qct", 2);
    assert!(
        message.contains(
            "intervals are left that the table was not learned from, less than a turn of 200"
        ),
        "{message}"
    );
}

#[test]
fn a_reference_of_another_run_or_ratio_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let wander =
        format!("{TWIN}[noise.speed_wander]\nrms_fraction = 0.01\ncorrelation_rad = 0.5\n");
    simulated(at, "rig", &wander, "--reference ref.csv --ratio 8");
    let again = wander
        .replace("seed = 4", "seed = 5")
        .replace("[errors]", "[errors]\nseed = 4");
    simulated(at, "again", &again, "--reference again-ref.csv --ratio 8");
    done(at, "calibrate rig.csv --turns 11 -o rig.qct --pole-pairs 5");
    let fits = "verify rig.csv --table rig.qct --reference ref.csv --ratio 8";
    let check = json(&done(at, &format!("{fits} --json -")));
    assert_eq!(check["verdict"], "better");
    for reference in [
        "ref.csv --ratio 8.05",
        "ref.csv --ratio -8",
        "ref.csv",
        "again-ref.csv --ratio 8",
    ] {
        let arguments = format!("verify rig.csv --table rig.qct --reference {reference}");
        let message = refused(&folder, &arguments, 2);
        let name = reference.split_whitespace().next().unwrap();
        let start = format!("quadcal: {name}: the reference does not fit this recording");
        assert!(message.starts_with(&start), "{message}");
    }
}

#[test]
fn turns_learned_from_are_left_out_of_every_recording() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for (name, r_min) in [("slow", "= 300"), ("fast", "= 1200")] {
        simulated(at, name, &TWIN.replace("= 600", r_min), "");
    }
    done(at, "calibrate slow.csv fast.csv --turns 11 -o both.qct");
    let intervals = |recording: &str, table: &str| {
        let arguments = format!("verify {recording} --table {table} --json -");
        let check = json(&done(at, &arguments));
        assert_eq!(check["verdict"], "better");
        (
            check["same_recording"].as_bool().unwrap(),
            check["intervals"].as_u64().unwrap(),
        )
    };
    for recording in ["slow.csv", "fast.csv"] {
        let (same, found) = intervals(recording, "both.qct");
        // Of twenty turns one sets the speed, eleven are learned from, and half a turn at either end has no turn about it.
        assert!(
            same && (1_000..1_700).contains(&found),
            "{recording}: {found}"
        );
    }
    // A table of one recording is the slot and nothing behind it, and knows no other.
    done(at, "calibrate slow.csv --turns 11 -o one.qct");
    let bytes = |name: &str| fs::metadata(at.join(name)).unwrap().len();
    assert_eq!(bytes("both.qct") - bytes("one.qct"), 8 + 2 * 12);
    assert!(!intervals("fast.csv", "one.qct").0);
}

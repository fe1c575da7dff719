//! When learning ends, and what of several recordings does not go together.

mod workshop;

use std::fs;

use workshop::{TWIN, done, json, quadcal, refused};

/// A twin whose speed wanders.
fn wandering() -> String {
    format!("{TWIN}\n[noise.speed_wander]\nrms_fraction = 0.001\ncorrelation_rad = 0.5\n")
}

#[test]
fn learning_ends_when_the_goal_is_met_and_says_how_it_got_there() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("rig.toml"), wandering()).unwrap();
    done(at, "simulate rig.toml -o rig.csv --turns 40");
    let all = json(&done(
        at,
        "calibrate rig.csv --pole-pairs 5 -o t.qct --json -",
    ));
    assert!(all["goal"].is_null());
    let progress = all["progress"].as_array().unwrap();
    let error = |after: &serde_json::Value| after["expected_error_rad"].as_f64().unwrap();
    let (first, last) = (error(&progress[0]), error(&progress[progress.len() - 1]));
    assert!(last < 0.7 * first, "{first} {last}");
    // A goal half way is met with fewer turns, and one beyond reach with all.
    let goal = f64::midpoint(first, last);
    let arguments = format!("calibrate rig.csv --pole-pairs 5 --goal {goal:e} -o t.qct");
    let early = json(&done(at, &format!("{arguments} --json -")));
    assert!(early["turns"]["used"].as_u64() < all["turns"]["used"].as_u64());
    // What is expected turn by turn and what solving finds agree within a tenth.
    let solved = early["expected_error_after_rad"].as_f64().unwrap();
    assert!(solved < 1.1 * goal, "{solved} {goal}");
    let easy = json(&done(
        at,
        &format!(
            "calibrate rig.csv --pole-pairs 5 --goal {:e} -o t.qct --json -",
            1.2 * first
        ),
    ));
    assert_eq!(easy["goal"], "goal_met");
    let text = done(at, &arguments);
    assert!(text.contains("goal"), "{text}");
    let far = json(&done(
        at,
        "calibrate rig.csv --pole-pairs 5 --goal 1e-9 -o t.qct --json -",
    ));
    assert_eq!(far["goal"], "go_on");
    assert_eq!(far["turns"]["used"], all["turns"]["used"]);
    let output = quadcal(at, "calibrate rig.csv --goal 0 -o t.qct");
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn recordings_of_two_discs_are_not_taken_together() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let twin = |lines: &str, r_min: &str, seed: &str| {
        TWIN.replace("lines = 50", lines)
            .replace("e-3", "e-4")
            .replace("r_min = 600", r_min)
            .replace("[errors]", &format!("[errors]\nseed = {seed}"))
    };
    for (name, r_min, seed) in [
        ("slow", "r_min = 300", "1"),
        ("same", "r_min = 1200", "1"),
        ("other", "r_min = 1200", "2"),
        ("near", "r_min = 310", "2"),
    ] {
        let twin = twin("lines = 500", r_min, seed);
        fs::write(at.join(format!("{name}.toml")), twin).unwrap();
        done(
            at,
            &format!("simulate {name}.toml -o {name}.csv --turns 14"),
        );
    }
    done(at, "calibrate slow.csv same.csv -o t.qct");
    fs::remove_file(at.join("t.qct")).unwrap();
    for other in ["other", "near"] {
        let arguments = format!("calibrate slow.csv same.csv {other}.csv -o t.qct");
        let message = refused(&folder, &arguments, 2);
        let start = format!("quadcal: slow.csv and {other}.csv: ");
        assert!(message.starts_with(&start), "{message}");
        assert!(message.contains("not of one disc"), "{message}");
    }
}

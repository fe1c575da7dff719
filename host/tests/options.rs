//! Options that say nothing of the recording they are given with.

mod workshop;

use std::fs;

use workshop::{TWIN, done, refused, workshop};

#[test]
fn options_that_say_nothing_of_the_recording_are_refused_or_remarked() {
    let folder = workshop();
    let at = folder.path();
    let message = refused(&folder, "calibrate rig.csv --no-index -o t.qct", 2);
    assert!(
        message.starts_with("quadcal: --no-index: rig.csv has an index"),
        "{message}"
    );
    for command in [
        "calibrate rig.csv -o t.qct",
        "verify rig.csv --table rig.qct",
    ] {
        let message = refused(&folder, &format!("{command} --missing 2"), 2);
        assert!(
            message.starts_with("quadcal: --missing: rig.csv is not of a toothed wheel"),
            "{message}"
        );
    }
    fs::write(at.join("hall.toml"), done(at, "simulate --example hall")).unwrap();
    done(at, "simulate hall.toml -o hall.csv");
    let message = refused(&folder, "calibrate hall.csv --no-index -o t.qct", 2);
    assert!(
        message.contains("is not of a quadrature encoder"),
        "{message}"
    );
    // One speed tells no torque, two do.
    let useless = |recordings: &str| {
        let text = done(
            at,
            &format!("calibrate {recordings} --inertia 1e-4 -o t.qct"),
        );
        text.contains("--inertia ") && text.contains("has no use here: all turns ran at one speed")
    };
    assert!(useless("rig.csv"));
    fs::write(at.join("fast.toml"), TWIN.replace("= 600", "= 1200")).unwrap();
    done(at, "simulate fast.toml -o fast.csv");
    assert!(!useless("rig.csv fast.csv"));
}

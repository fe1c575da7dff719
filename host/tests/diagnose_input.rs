//! What `quadcal diagnose` says of files that are no twin, and of recordings that are too short.

mod workshop;

use std::fs;

use workshop::{bench, refused};

#[test]
fn a_recording_that_is_too_short_is_said_to_be() {
    let folder = bench();
    let at = folder.path();
    for (name, recording, keep) in [
        ("some.csv", "rig.csv", 44),
        ("turn.csv", "rig.csv", 500),
        ("hall.csv", "hall.csv", 40),
    ] {
        let text = fs::read_to_string(at.join(recording)).unwrap();
        let kept: Vec<&str> = text.lines().take(keep).collect();
        fs::write(at.join(name), kept.join("\n") + "\n").unwrap();
        let twin = recording.replace("csv", "toml");
        let message = refused(&folder, &format!("diagnose {name} --twin {twin}"), 2);
        let expected = format!("quadcal: {name}: too short: ");
        assert!(
            message.starts_with(&expected)
                && message.contains("; record 3 turns and 200 edges or more"),
            "{message}"
        );
    }
    let head: Vec<String> = fs::read_to_string(at.join("rig.csv"))
        .unwrap()
        .lines()
        .take_while(|line| !line.starts_with(|c: char| c.is_ascii_digit()))
        .map(str::to_owned)
        .collect();
    fs::write(at.join("head.csv"), head.join("\n") + "\n").unwrap();
    let message = refused(&folder, "diagnose head.csv --twin rig.toml", 2);
    assert!(
        message.contains("head.csv: no edges in the recording"),
        "{message}"
    );
}

#[test]
fn what_is_no_twin_is_said_to_be_none() {
    let folder = bench();
    let at = folder.path();
    fs::write(at.join("empty.toml"), "").unwrap();
    fs::write(at.join("remarks.toml"), "# my rig\n").unwrap();
    fs::write(at.join("binary.toml"), b"seed = 1\n\x7fELF\xff\xfe").unwrap();
    fs::write(at.join("seed.toml"), "seed = 1\n").unwrap();
    fs::create_dir(at.join("folder")).unwrap();
    for (twin, expected) in [
        (
            "empty.toml",
            "quadcal: empty.toml: no key is in it; write what is known of the rig (",
        ),
        (
            "remarks.toml",
            "quadcal: remarks.toml: no key is in it; write ",
        ),
        (
            "binary.toml",
            "quadcal: binary.toml:2: not text; a twin is a TOML file in UTF-8\n",
        ),
        (
            "folder",
            "quadcal: folder: is a folder; name the twin's file in it\n",
        ),
        (
            "again.csv",
            "quadcal: again.csv: a recording, not a twin; give ",
        ),
        (
            "seed.toml",
            "quadcal: seed.toml: (top level): missing field `encoder`; add it (",
        ),
    ] {
        for command in ["diagnose rig.csv --twin", "simulate -o new.csv"] {
            let message = refused(&folder, &format!("{command} {twin}"), 2);
            assert!(message.starts_with(expected), "{command} {twin}: {message}");
        }
    }
}

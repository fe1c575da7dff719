//! A twin that declares everything its rig has explains a recording of that rig, whatever acts together in it.
#![allow(missing_docs)]

use std::path::Path;
use std::process::Command;

use quadcal_host::diagnose::diagnosis::Verdict;
use quadcal_host_tests::real::command::Bench;

/// Seeds of the noise, none of which the twin knows.
const SEEDS: [u64; 2] = [71, 72];
/// Recordings in which something is said to be missing, of twelve.
const MOST_WRONG: usize = 6;

#[test]
fn a_twin_is_complete_against_its_own_recording() {
    let twins = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/own_recording");
    let folder = tempfile::tempdir().unwrap();
    let bench = Bench {
        program: env!("CARGO_BIN_EXE_quadcal-under-test").into(),
        arguments: Vec::new(),
        folder: folder.path().to_owned(),
    };
    let recording = folder.path().join("rec.csv");
    let (mut tried, mut wrong) = (0, Vec::new());
    for twin in std::fs::read_dir(twins).unwrap() {
        let twin = twin.unwrap().path();
        for seed in SEEDS {
            let simulated = Command::new(&bench.program)
                .args(["simulate", "--quiet", "--seed", &seed.to_string(), "-o"])
                .args([&recording, &twin])
                .output()
                .unwrap();
            assert!(simulated.status.success(), "{simulated:?}");
            let said = bench.diagnose(&recording, &twin, "own").unwrap();
            let names = said.names();
            if said.diagnosis.verdict != Verdict::Complete {
                wrong.push(format!("{twin:?} {seed}: {names}"));
            }
            tried += 1;
        }
    }
    assert_eq!(tried, 12);
    // All of them is the aim.
    assert!(wrong.len() <= MOST_WRONG, "{}", wrong.join("\n"));
}

/// What everybody tries first. Not here, as the diagnosis does not know their physics yet: `mechanisms`, whose capture task is no part of
/// the model, and `stick-slip`.
#[test]
fn every_example_is_complete_against_its_own_recording() {
    const EXAMPLES: [&str; 10] = [
        "paper",
        "wander",
        "hall",
        "wheel",
        "run-down",
        "speed-loop",
        "delays",
        "load-step",
        "pair-slow",
        "pair-fast",
    ];
    let folder = tempfile::tempdir().unwrap();
    let bench = Bench {
        program: env!("CARGO_BIN_EXE_quadcal-under-test").into(),
        arguments: Vec::new(),
        folder: folder.path().to_owned(),
    };
    let (recording, twin) = (
        folder.path().join("rec.csv"),
        folder.path().join("twin.toml"),
    );
    let simulate = |args: &[&std::ffi::OsStr]| {
        let done = Command::new(&bench.program)
            .args(["simulate", "--quiet"])
            .args(args)
            .output()
            .unwrap();
        assert!(done.status.success(), "{done:?}");
        done.stdout
    };
    for example in EXAMPLES {
        let text = simulate(&["--example".as_ref(), example.as_ref()]);
        std::fs::write(&twin, text).unwrap();
        simulate(&["-o".as_ref(), recording.as_ref(), twin.as_ref()]);
        let said = bench.diagnose(&recording, &twin, "own").unwrap();
        let verdict = said.diagnosis.verdict;
        assert_eq!(verdict, Verdict::Complete, "{example}: {}", said.names());
    }
}

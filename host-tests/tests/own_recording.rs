//! A twin that declares everything its rig has explains a recording of that rig, whatever acts together in it.
#![allow(missing_docs)]

use std::path::Path;
use std::process::Command;

use quadcal_host::diagnose::diagnosis::Verdict;
use quadcal_host::mechanism::Mechanism;
use quadcal_host_tests::real::command::Bench;

/// Seeds of the noise, none of which the twin knows.
const SEEDS: [u64; 2] = [71, 72];
/// Recordings in which something is said to be missing, of twelve.
const MOST_WRONG: usize = 2;

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

/// What everybody tries first. Not here, as the diagnosis does not know its physics yet: `stick-slip`.
#[test]
fn every_example_is_complete_against_its_own_recording() {
    const EXAMPLES: [&str; 11] = [
        "paper",
        "wander",
        "hall",
        "wheel",
        "run-down",
        "speed-loop",
        "delays",
        "load-step",
        "mechanisms",
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

/// Twins that do not declare the capture task of `mechanisms`, or declare another one.
#[test]
fn a_task_that_holds_captures_up_is_measured() {
    const SECTION: &str = "[capture_latency]\ntask_hz = 1000\nbusy_s = 2e-5\nphase_s = 3e-4\n";
    let folder = tempfile::tempdir().unwrap();
    let bench = Bench {
        program: env!("CARGO_BIN_EXE_quadcal-under-test").into(),
        arguments: Vec::new(),
        folder: folder.path().to_owned(),
    };
    let recording = folder.path().join("rec.csv");
    let twin = folder.path().join("twin.toml");
    let simulate = |args: &[&std::ffi::OsStr]| {
        let done = Command::new(&bench.program)
            .args(["simulate", "--quiet"])
            .args(args)
            .output()
            .unwrap();
        assert!(done.status.success(), "{done:?}");
        String::from_utf8(done.stdout).unwrap()
    };
    let text = simulate(&["--example".as_ref(), "mechanisms".as_ref()]);
    assert!(text.contains(SECTION));
    std::fs::write(&twin, &text).unwrap();
    simulate(&["-o".as_ref(), recording.as_ref(), twin.as_ref()]);
    let others = ["task_hz = 2000", "busy_s = 1e-5", "phase_s = 6e-4"];
    let was = ["task_hz = 1000", "busy_s = 2e-5", "phase_s = 3e-4"];
    let wrong = was
        .iter()
        .zip(others)
        .map(|(was, is)| text.replace(was, is));
    for text in wrong.chain([text.replace(SECTION, "")]) {
        std::fs::write(&twin, text).unwrap();
        let said = bench.diagnose(&recording, &twin, "task").unwrap();
        let findings = &said.diagnosis.findings;
        assert_eq!(findings.len(), 1, "{}", said.names());
        assert_eq!(findings[0].mechanism, Mechanism::CaptureLatency);
        for (name, truth) in [("task_hz", 1000.0), ("busy_s", 2e-5), ("phase_s", 3e-4)] {
            let number = &findings[0].parameters[name];
            let [low, high] = number.ci95.unwrap();
            assert!((low..=high).contains(&truth), "{name}: {number:?}");
            assert!(high - low < 0.02 * truth, "{name}: {number:?}");
        }
    }
}

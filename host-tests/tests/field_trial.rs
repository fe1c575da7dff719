//! A drive in QEMU, recalibrated by command, and the `quadcal device` commands at its port.
#![cfg(unix)]

use std::process::{Command, Output};

use quadcal::slot::Slot;
use quadcal_host_tests::field_trial::drive::KEY;
use quadcal_host_tests::field_trial::{Bench, Trial};

/// A trial that is soon over.
const QUICK: Trial = Trial {
    seed: 5,
    r_min: 600.0,
    turns: 16,
    proof_turns: 6,
    samples: 200,
};

/// All RAM of the chip that is not core-coupled, bytes.
const RAM: u64 = 128 << 10;

/// Runs `quadcal device` with these words at a drive's port.
fn device(bench: &Bench, words: &str) -> Output {
    let key: String = KEY.iter().map(|byte| format!("{byte:02x}")).collect();
    let output = Command::new(env!("CARGO_BIN_EXE_quadcal-under-test"))
        .current_dir(bench.folder())
        .arg("device")
        .args(words.split_ascii_whitespace())
        .env("QUADCAL_PORT", bench.drive.address().to_string())
        .env("QUADCAL_KEY", key)
        .output()
        .unwrap();
    assert!(output.status.success(), "{words}: {output:?}");
    output
}

/// What it prints.
fn said(bench: &Bench, words: &str) -> String {
    String::from_utf8(device(bench, words).stdout).unwrap()
}

/// The same without blanks, as JSON may have them anywhere.
fn packed(bench: &Bench, words: &str) -> String {
    said(bench, words).split_whitespace().collect()
}

#[test]
fn a_drive_in_qemu_learns_by_command_and_starts_again_with_what_it_learned() {
    let (outcome, bench) = QUICK.run(|_| ()).unwrap_or_else(|error| panic!("{error}"));
    let (before, after) = (&outcome.before, &outcome.after);
    println!("{before:?}\n{after:?}\n{:?}", outcome.figures);
    assert!(outcome.is_better() && outcome.figures.better);
    // The table makes the difference, not the shaft.
    assert!((before.given / before.raw - 1.0).abs() < 1e-6 && before.raw > 0.1);
    assert!(after.raw > before.raw / 1.5);
    // The encoder runs on as before all the while.
    let meanwhile = outcome.meanwhile.given / before.given;
    assert!((0.6..1.6).contains(&meanwhile), "{meanwhile}");
    for ripple in [before, after] {
        assert!(
            (ripple.r_min / QUICK.r_min - 1.0).abs() < 1e-2,
            "{ripple:?}"
        );
    }
    assert_eq!((outcome.table.place, outcome.table.sequence), (0, 0));
    assert!(outcome.memory.statics + outcome.memory.stack < RAM);

    let identity = packed(&bench, "identify --json -");
    assert!(identity.contains(r#""edges_per_turn":10000"#), "{identity}");
    assert!(identity.contains(r#""serial":405"#), "{identity}");
    let status = packed(&bench, "status --json -");
    assert!(status.contains(r#""stage":"idle""#), "{status}");
    assert!(status.contains(r#""sequence":0"#), "{status}");
    let watched = said(&bench, "watch --seconds 1 --json -");
    let lines: Vec<&str> = watched.lines().collect();
    assert!(lines.len() > 10, "{watched}");
    let (summary, samples) = lines.split_last().unwrap();
    assert!(
        samples
            .iter()
            .all(|line| line.contains(r#""kind":"sample""#))
    );
    assert!(summary.contains(r#""kind":"summary""#), "{summary}");

    device(&bench, "dump -o drive.qct");
    let dumped = std::fs::read(bench.folder().join("drive.qct")).unwrap();
    let slot = Slot::parse(&dumped).unwrap();
    assert_eq!(slot.header.turns, outcome.learned.turns);
    let flash = std::fs::read(bench.flash()).unwrap();
    assert!(flash.windows(dumped.len()).any(|bytes| bytes == dumped));
    // Handed over again it becomes the next one, and taken back the first one counts again.
    device(&bench, "load drive.qct --commit");
    assert!(said(&bench, "status").contains("number 1 at place B"));
    device(&bench, "rollback");
    assert!(said(&bench, "status").contains("number 0 at place A"));
}

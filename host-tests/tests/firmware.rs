//! Firmware images in QEMU against the same work on the host.

use std::path::PathBuf;
use std::time::Duration;

use quadcal::edge::{Levels, Sample};
use quadcal::replay::{Header, Tally, TimerWidth, Wiring};
use quadcal_host_tests::events::{Events, Latency, events};
use quadcal_host_tests::firmware::{FirmwareError, build, run_qemu, size, symbols};

const LIMIT: Duration = Duration::from_secs(120);

fn image() -> PathBuf {
    build("qemu_replay", &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn header(timer: TimerWidth) -> Header {
    Header {
        timer,
        wiring: Wiring::Quadrature,
        lines: 2500,
        clock_hz: 84_000_000,
        turns: 11,
    }
}

/// A shaft that runs up and slows down again: intervals of 200 to 20 000 ticks.
fn stream(timer: TimerWidth) -> Events {
    let samples: Vec<Sample> = (0..60_000_u64)
        .scan(5_000_u64, |ticks, index| {
            *ticks += 200 + index.abs_diff(30_000) * 2 / 3;
            Some(Sample {
                ticks: *ticks,
                levels: Levels([1, 3, 2, 0][(index % 4) as usize]),
            })
        })
        .collect();
    events(
        &samples,
        timer,
        Latency {
            max: 20_000,
            seed: 7,
        },
    )
}

#[test]
fn image_sees_every_event_the_host_sent() {
    let elf = image();
    for timer in [TimerWidth::Bits16, TimerWidth::Bits32] {
        let sent = stream(timer);
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("in.qcev"), sent.file(&header(timer))).unwrap();
        let run = run_qemu(&elf, &["in.qcev", "out.bin"], folder.path(), LIMIT)
            .unwrap_or_else(|error| panic!("{error}"));
        assert!(run.success, "{}", run.stderr);

        let mut tally = Tally::default();
        sent.events.iter().for_each(|event| tally.add(event));
        assert_eq!(
            std::fs::read(folder.path().join("out.bin")).unwrap(),
            tally.emit()
        );
        assert_eq!(tally.captures, 60_000);

        let events = run.value("events").unwrap();
        assert_eq!(events, sent.events.len() as u64);
        let each = run.value("instructions").unwrap() as f64 / events as f64;
        println!(
            "{timer:?}: {events} events, {each:.1} instructions each; {}",
            run.stdout.trim()
        );
        // A checksum over 8 bytes takes some 7 instructions a byte; a miscounted timer would be far off.
        assert!(
            (40.0..250.0).contains(&each),
            "{each} instructions an event"
        );
        let (stack, fixed) = (
            run.value("stack_bytes").unwrap(),
            run.value("static_bytes").unwrap(),
        );
        let size = size(&elf).unwrap();
        assert!((100..16 << 10).contains(&stack), "{stack} bytes of stack");
        assert!(
            fixed.abs_diff(size.data + size.bss) < 8,
            "{fixed} bytes of statics, ELF has {size:?}"
        );
    }
}

#[test]
fn runs_are_repeatable_to_the_instruction() {
    let elf = image();
    let folder = tempfile::tempdir().unwrap();
    let timer = TimerWidth::Bits16;
    std::fs::write(
        folder.path().join("in.qcev"),
        stream(timer).file(&header(timer)),
    )
    .unwrap();
    let run = || {
        run_qemu(&elf, &["in.qcev", "out.bin"], folder.path(), LIMIT)
            .unwrap()
            .stdout
    };
    assert_eq!(run(), run());
}

#[test]
fn image_names_what_is_wrong_with_its_input_and_fails() {
    let elf = image();
    let folder = tempfile::tempdir().unwrap();
    let good = stream(TimerWidth::Bits16).file(&header(TimerWidth::Bits16));
    let mut kind = good.clone();
    kind[28] = 9;
    for (bytes, complaint) in [
        (&b"QCEV"[..], "byte 4: the file ends inside a record"),
        (&[0; 64][..], "byte 0: not an event file"),
        (
            &good[..100_003],
            "byte 99996: the file ends inside a record",
        ),
        (&kind[..], "byte 28: kind of record 9 is not known"),
    ] {
        std::fs::write(folder.path().join("in.qcev"), bytes).unwrap();
        let run = run_qemu(&elf, &["in.qcev", "out.bin"], folder.path(), LIMIT).unwrap();
        assert!(!run.success);
        assert!(run.stderr.contains(complaint), "{}", run.stderr);
        assert!(!folder.path().join("out.bin").exists());
    }
    let run = run_qemu(&elf, &[], folder.path(), LIMIT).unwrap();
    assert!(
        !run.success && run.stderr.contains("usage"),
        "{}",
        run.stderr
    );
}

#[test]
fn a_hanging_machine_is_killed_and_reported() {
    let folder = tempfile::tempdir().unwrap();
    // The guest blocks in a read of a pipe that nobody writes to.
    let pipe = folder.path().join("in.qcev");
    assert!(
        std::process::Command::new("mkfifo")
            .arg(&pipe)
            .status()
            .unwrap()
            .success()
    );
    let error = run_qemu(
        &image(),
        &["in.qcev", "out.bin"],
        folder.path(),
        Duration::from_secs(1),
    )
    .unwrap_err();
    assert!(
        matches!(error, FirmwareError::Hang { seconds: 1, .. }),
        "{error}"
    );
}

#[test]
fn symbols_name_the_image_s_functions() {
    let symbols = symbols(&image()).unwrap();
    let main = symbols.iter().find(|symbol| symbol.name == "main").unwrap();
    assert!(main.code && main.size > 0);
    assert!(
        symbols
            .iter()
            .any(|symbol| symbol.name.ends_with("counter::WRAPS") && !symbol.code)
    );
}

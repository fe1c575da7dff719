//! What is written is read back.

use std::fs;
use std::io::Write;

use proptest::prelude::*;
use quadcal::edge::{Levels, Sample};

use super::super::write::{AtomicFile, NativeWriter, VcdWriter, WriteError};
use super::super::{Channels, Header, ReadOptions, Row};
use super::open_bytes;

fn header(clock_hz: u64, channels: Channels) -> Header {
    Header {
        clock_hz,
        channels,
        notes: vec![
            ("clock_hz".into(), clock_hz.to_string()),
            ("source".into(), "bench 3, a = b".into()),
        ],
    }
}

fn native(header: &Header, rows: &[Row]) -> Vec<u8> {
    let mut writer = NativeWriter::new(Vec::new(), header).unwrap();
    rows.iter().for_each(|row| writer.row(row).unwrap());
    writer.finish().unwrap()
}

fn vcd(header: &Header, rows: &[Row]) -> Vec<u8> {
    let mut writer = VcdWriter::new(Vec::new(), header).unwrap();
    rows.iter().for_each(|row| writer.row(row).unwrap());
    writer.finish().unwrap()
}

fn channels() -> impl Strategy<Value = Channels> {
    prop_oneof![
        Just(Channels::Quadrature { index: true }),
        Just(Channels::Quadrature { index: false }),
        Just(Channels::Hall),
        Just(Channels::Wheel),
        Just(Channels::Pulses),
    ]
}

/// Rows whose levels change from each to the next, with equal times and long pauses among them.
fn some_rows(channels: Channels, steps: Vec<(u64, u8)>) -> Vec<Row> {
    let bits = match channels {
        Channels::Quadrature { index: true } | Channels::Hall => 7,
        Channels::Quadrature { index: false } => 3,
        Channels::Wheel | Channels::Pulses => 1,
    };
    let mut sample = Sample::default();
    steps
        .into_iter()
        .map(|(pause, flip)| {
            sample.ticks += pause;
            let flip = if flip & bits == 0 { 1 } else { flip & bits };
            sample.levels = match channels {
                Channels::Pulses => Levels(1),
                _ => Levels(sample.levels.0 ^ flip),
            };
            sample
        })
        .collect()
}

proptest! {
    #[test]
    fn native_and_vcd_give_back_header_and_rows(
        channels in channels(),
        clock_hz in prop_oneof![Just(30_000), Just(84_000_000), Just(1_000_000_000), 1u64..200_000_000],
        steps in proptest::collection::vec((0u64..3_000_000, any::<u8>()), 1..50),
    ) {
        let header = header(clock_hz, channels);
        let rows = some_rows(channels, steps);
        for (name, bytes) in [("r.csv", native(&header, &rows)), ("r.vcd", vcd(&header, &rows))] {
            let mut recording = open_bytes(name, &bytes, &ReadOptions::default()).unwrap();
            prop_assert_eq!(&recording.header, &header);
            let read: Result<Vec<_>, _> = recording.by_ref().collect();
            prop_assert_eq!(read.unwrap(), rows.clone(), "{}", name);
            prop_assert_eq!(recording.repeated_rows(), 0);
        }
    }
}

#[test]
fn notes_cannot_break_out_of_their_line_and_raw_captures_are_not_claimed() {
    let mut header = header(1_000, Channels::Wheel);
    header.notes = vec![
        ("timer_bits".into(), "16".into()),
        ("note".into(), "two\nlines $end #5".into()),
    ];
    let rows = some_rows(Channels::Wheel, vec![(70_000, 1), (1, 1)]);
    for (name, bytes) in [
        ("r.csv", native(&header, &rows)),
        ("r.vcd", vcd(&header, &rows)),
    ] {
        let mut recording = open_bytes(name, &bytes, &ReadOptions::default()).unwrap();
        assert_eq!(
            recording.header.notes[0],
            ("clock_hz".into(), "1000".into()),
            "{name}"
        );
        assert_eq!(recording.header.notes[1].0, "note");
        assert!(recording.header.notes[1].1.starts_with("two lines"));
        assert_eq!(
            recording.by_ref().map(Result::unwrap).collect::<Vec<_>>(),
            rows
        );
    }
}

#[test]
fn rows_out_of_order_and_impossible_clocks_are_refused() {
    let header_ok = header(1_000, Channels::Wheel);
    let row = |ticks| Sample {
        ticks,
        levels: Levels(1),
    };
    let mut writer = NativeWriter::new(Vec::new(), &header_ok).unwrap();
    writer.row(&row(5)).unwrap();
    assert!(matches!(
        writer.row(&row(4)),
        Err(WriteError::TimeFalls {
            ticks: 4,
            previous: 5
        })
    ));
    let mut writer = VcdWriter::new(Vec::new(), &header(84_000_000, Channels::Wheel)).unwrap();
    assert!(matches!(
        writer.row(&row(u64::MAX)),
        Err(WriteError::TimeOverflow { .. })
    ));
    let zero = header(0, Channels::Wheel);
    assert!(matches!(
        NativeWriter::new(Vec::new(), &zero),
        Err(WriteError::Clock { clock_hz: 0 })
    ));
    assert!(matches!(
        VcdWriter::new(Vec::new(), &zero),
        Err(WriteError::Clock { clock_hz: 0 })
    ));
}

#[test]
fn a_file_appears_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("table.csv");
    fs::write(&target, "old").unwrap();
    let names = || fs::read_dir(folder.path()).unwrap().count();

    let mut dropped = AtomicFile::create(&target).unwrap();
    dropped.write_all(b"half").unwrap();
    assert_eq!(names(), 2);
    drop(dropped);
    assert_eq!(
        (names(), fs::read_to_string(&target).unwrap().as_str()),
        (1, "old")
    );

    let mut file = AtomicFile::create(&target).unwrap();
    file.write_all(b"new").unwrap();
    assert_eq!(fs::read_to_string(&target).unwrap(), "old");
    file.commit().unwrap();
    assert_eq!(
        (names(), fs::read_to_string(&target).unwrap().as_str()),
        (1, "new")
    );
    assert!(AtomicFile::create(&folder.path().join("none/table.csv")).is_err());
}

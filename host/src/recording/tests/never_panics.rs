//! No bytes make a reader panic, return falling times, or go on after an error.

use proptest::prelude::*;

use super::super::{Channels, Format, ListKind, ReadOptions};
use super::open_bytes;

const NATIVE: &str = "# clock_hz = 84000000\n# timer_bits = 16\nticks,a,b,z\n65000,0,0,0\n65100,1,0,0\n200,1,1,1\n400,0,1,0\n";
const LOGIC: &str = "Time [s],A,B,Z\n-0.5,0,0,0\n-1e-3,1,0,0\n+0.25,1,1,1\n1.75e1,0,1,0\n";
const LIST: &str = "# wheel\n0.080654\n0.071426\n5.8965e-2\n0.050558\n";
const VCD: &str = "$comment clock_hz = 84000000 $end $timescale 10 ps $end $scope module m $end $var wire 1 ! a $end\n\
    $var wire 1 % b $end $upscope $end $enddefinitions $end\n$dumpvars 0! x% $end\n#0 0%\n#1190 1!\n#2381\n1%\n";

const SAMPLES: [(Format, &str); 4] = [
    (Format::Native, NATIVE),
    (Format::Logic, LOGIC),
    (Format::List, LIST),
    (Format::Vcd, VCD),
];

/// Reads to the end and checks what every recording promises.
fn exercise(bytes: &[u8], format: Option<Format>, list: ListKind) {
    let options = ReadOptions {
        format,
        list,
        ..ReadOptions::default()
    };
    let mut recording = match open_bytes("f", bytes, &options) {
        Ok(recording) => recording,
        Err(error) => return assert!(!error.to_string().contains('\n')),
    };
    let pulses = recording.header.channels == Channels::Pulses;
    let mut last = None;
    while let Some(row) = recording.next() {
        match row {
            Ok(row) => {
                assert!(row.levels.0 < 8);
                if let Some((ticks, levels)) = last {
                    assert!(row.ticks >= ticks);
                    assert!(pulses || row.levels != levels);
                }
                last = Some((row.ticks, row.levels));
            }
            Err(error) => {
                assert!(!error.to_string().contains('\n'));
                assert!(recording.next().is_none());
            }
        }
    }
}

fn list_kind() -> impl Strategy<Value = ListKind> {
    prop_oneof![
        Just(ListKind::Auto),
        Just(ListKind::Intervals),
        Just(ListKind::Times)
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1024))]

    #[test]
    fn arbitrary_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..200), list in list_kind()) {
        exercise(&bytes, None, list);
        for (format, _) in SAMPLES {
            exercise(&bytes, Some(format), list);
        }
    }

    #[test]
    fn good_files_with_bytes_put_in_taken_out_and_moved(
        which in 0..SAMPLES.len(),
        edits in proptest::collection::vec((any::<prop::sample::Index>(), 0..4u8, any::<u8>()), 0..6),
        list in list_kind(),
    ) {
        let (format, text) = SAMPLES[which];
        let mut bytes = text.as_bytes().to_vec();
        for (place, edit, value) in edits {
            if bytes.is_empty() {
                break;
            }
            let place = place.index(bytes.len());
            match edit {
                0 => bytes[place] = value,
                1 => bytes.insert(place, b"0123456789,.-+eE#$!%\n\r\" \0\xffxzbr"[usize::from(value) % 30]),
                2 => drop(bytes.drain(place..(place + usize::from(value)).min(bytes.len()))),
                _ => bytes.rotate_left(place),
            }
        }
        exercise(&bytes, None, list);
        exercise(&bytes, Some(format), list);
    }
}

#[test]
fn the_samples_themselves_are_good() {
    for (format, text) in SAMPLES {
        let recording = open_bytes("f", text.as_bytes(), &ReadOptions::default()).unwrap();
        assert_eq!(recording.format(), format);
        assert!(recording.map(Result::unwrap).count() >= 3, "{format:?}");
    }
}

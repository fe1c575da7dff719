//! What good files of every format are read as.

use std::path::Path;

use super::super::{Channels, Format, ListKind, ReadOptions, open};
use super::{mapped, open_bytes, rows};

fn plain() -> ReadOptions {
    ReadOptions::default()
}

#[test]
fn the_shipped_recordings_are_three_hall_sensors_at_30_khz() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("recordings");
    for (name, edges, last) in [
        ("hall-spindle.csv", 28_699, 863_790),
        ("hall-hub-motor.csv", 2_843, 581_552),
    ] {
        let mut recording = open(&folder.join(name), &plain()).unwrap();
        assert_eq!(recording.header.clock_hz, 30_000);
        assert_eq!(recording.header.channels, Channels::Hall);
        assert_eq!(recording.header.notes.len(), 2);
        let rows: Vec<_> = recording.by_ref().map(Result::unwrap).collect();
        // The first row is where the levels start, not an edge.
        assert_eq!(rows.len(), edges + 1, "{name}");
        assert_eq!(rows[1].ticks, if edges > 20_000 { 43_488 } else { 43_160 });
        assert_eq!((rows[edges].ticks, rows[edges].levels.0), (last, 0b101));
        assert_eq!(recording.repeated_rows(), 0);
        assert_eq!(Some(recording.bytes_read()), recording.total_bytes());
    }
}

#[test]
fn native_columns_say_what_the_channels_are() {
    for (columns, row, channels, levels) in [
        (
            "ticks,a,b,z",
            "5,1,0,1",
            Channels::Quadrature { index: true },
            0b101,
        ),
        (
            "ticks,a,b",
            "5,1,0",
            Channels::Quadrature { index: false },
            0b01,
        ),
        ("ticks,a,b,c", "5,0,0,1", Channels::Hall, 0b100),
        ("ticks,a", "5,1", Channels::Wheel, 1),
        ("ticks", "5", Channels::Pulses, 1),
        ("torque,ticks", "0.5,5", Channels::Pulses, 1),
        (
            "Z,torque, B ,TICKS,\"a\"",
            "1,-2e3,0,5,1",
            Channels::Quadrature { index: true },
            0b101,
        ),
        (
            "ticks;a;b",
            " 5 ;\"1\"; 0",
            Channels::Quadrature { index: false },
            0b01,
        ),
    ] {
        let text = format!("# clock_hz = 84_000_000\n# note\n{columns}\r\n{row}\r\n");
        let recording = open_bytes("r.csv", text.as_bytes(), &plain()).unwrap();
        assert_eq!(recording.header.channels, channels, "{columns}");
        assert_eq!(recording.header.clock_hz, 84_000_000);
        assert_eq!(
            rows("r.csv", &text, &plain()).unwrap(),
            [(5, levels)],
            "{columns}"
        );
    }
}

#[test]
fn repeated_levels_are_counted_and_left_out_but_not_for_pulses() {
    let text = "# clock_hz = 1\nticks,a\n1,0\n2,0\n# a note between\n\n3,1\n3,1\n4,0\n";
    let mut recording = open_bytes("r.csv", text.as_bytes(), &plain()).unwrap();
    assert_eq!(recording.by_ref().count(), 3);
    assert_eq!(recording.repeated_rows(), 2);
    assert_eq!(
        rows("r.csv", "# clock_hz = 1\nticks\n1\n1\n9\n", &plain())
            .unwrap()
            .len(),
        3
    );
}

#[test]
fn raw_captures_are_extended_at_every_wrap() {
    let text = "# clock_hz = 1\n# timer_bits = 16\nticks,a\n65000,0\n100,1\n100,0\n99,1\n";
    let expected = [(65_000, 0), (65_636, 1), (65_636, 0), (131_171, 1)];
    assert_eq!(rows("r.csv", text, &plain()).unwrap(), expected);
    let text = "# clock_hz = 1\n# timer_bits = 32\nticks\n4294967295\n0\n";
    assert_eq!(
        rows("r.csv", text, &plain()).unwrap(),
        [(u32::MAX.into(), 1), (1 << 32, 1)]
    );
}

#[test]
fn logic_analyser_times_are_exact_and_start_at_zero() {
    let text = "\u{feff}Time [s],\"Channel 0\", channel 1 ,Channel 2\n-0.000000002,0,0,1\n1.5e-3,1,0,1\n9007199.254740993,1,1,1\n";
    let options = mapped(&["a=CHANNEL 0", "b=Channel 1"]);
    let recording = open_bytes("r.csv", text.as_bytes(), &options).unwrap();
    assert_eq!(recording.format(), Format::Logic);
    assert_eq!(recording.header.clock_hz, 1_000_000_000);
    assert_eq!(
        recording.header.channels,
        Channels::Quadrature { index: false }
    );
    let expected = [(0, 0), (1_500_002, 1), (9_007_199_254_740_995, 3)];
    assert_eq!(rows("r.csv", text, &options).unwrap(), expected);
    assert_eq!(
        rows("r.csv", "Time [ms],A\n1,0\n1.5,1\n", &plain()).unwrap(),
        [(0, 0), (500_000, 1)]
    );
    assert_eq!(
        rows("r.csv", "Stamp,A\n1,0\n2,1\n", &mapped(&["time=stamp"])).unwrap()[1].0,
        1_000_000_000
    );
}

#[test]
fn lists_are_times_when_they_rise_and_intervals_when_not() {
    let rising = "10.5\n10.75\n11\n";
    assert_eq!(
        rows("l.csv", rising, &plain()).unwrap(),
        [(0, 1), (250_000_000, 1), (500_000_000, 1)]
    );
    let falling = "0.25\n0.125\n0.125\n";
    let pulses = [(0, 1), (250_000_000, 1), (375_000_000, 1), (500_000_000, 1)];
    assert_eq!(rows("l.csv", falling, &plain()).unwrap(), pulses);
    let forced = ReadOptions {
        list: ListKind::Intervals,
        ..plain()
    };
    assert_eq!(rows("l.csv", rising, &forced).unwrap()[3].0, 32_250_000_000);
    assert_eq!(
        rows("l.csv", "Interval [s]\n1\n2\n", &plain()).unwrap()[2].0,
        3_000_000_000
    );
    let steady = "0.5\n".repeat(100);
    let recording = open_bytes("l.csv", steady.as_bytes(), &plain()).unwrap();
    assert_eq!(recording.list_kind(), Some(ListKind::Intervals));
    assert_eq!(
        rows("l.csv", &steady, &plain()).unwrap()[100].0,
        50_000_000_000
    );
}

const VCD: &str = "$date today $end $timescale 10 ns $end\n$scope module top $end\n$var wire 1 ! A $end\n$var wire 1 \" B [0] $end\n\
    $var reg 8 # other $end\n$upscope $end $enddefinitions $end\n$dumpvars x! 0\" bx # $end\n#10 b101 #\n#20 1!\n#30 1\" 0!\n\
    #30 1!\n#40 b0 \" 1\"\n#50\n";

#[test]
fn changes_at_one_time_of_a_vcd_are_one_row() {
    let mut recording = open_bytes("v.vcd", VCD.as_bytes(), &plain()).unwrap();
    assert_eq!(recording.header.clock_hz, 100_000_000);
    assert_eq!(
        recording.header.channels,
        Channels::Quadrature { index: false }
    );
    let rows: Vec<_> = recording
        .by_ref()
        .map(|row| row.map(|r| (r.ticks, r.levels.0)).unwrap())
        .collect();
    assert_eq!(rows, [(20, 0b01), (30, 0b10), (30, 0b11)]);
    assert_eq!(recording.repeated_rows(), 1);
    assert_eq!(recording.bytes_read(), VCD.len() as u64);
}

#[test]
fn signals_of_a_vcd_are_found_by_mapped_path() {
    let text = VCD.replace(" A $end", " enc_a $end");
    let read = rows("v", &text, &mapped(&["a = TOP.enc_a"])).unwrap();
    assert_eq!(read[0], (20, 1));
    assert!(rows("v", &text, &plain()).is_err());
}

#[test]
fn a_vcd_need_not_end_with_a_line_end() {
    let text = VCD.trim_end().trim_end_matches("#50").trim_end();
    assert_eq!(rows("v", text, &plain()).unwrap().len(), 3);
}

//! One line for every way a file can be wrong, with the place.

use super::super::{Format, ListKind, ReadError, ReadOptions, open};
use super::{mapped, open_bytes, rows};

/// The message for a file read to its end.
fn message(name: &str, text: &str, options: &ReadOptions) -> String {
    let error = rows(name, text, options).expect_err("the file is wrong");
    let message = error.to_string();
    assert!(
        !message.contains('\n') && message.contains("; "),
        "{message}"
    );
    message
}

#[track_caller]
fn check(text: &str, start: &str) {
    let message = message("r.csv", text, &ReadOptions::default());
    assert!(message.starts_with(start), "{message}");
}

const HEAD: &str = "# clock_hz = 1000\nticks,a,b,z\n10,0,0,0\n";

#[test]
fn native_rows() {
    check(
        &format!("{HEAD}9,1,0,0\n"),
        "r.csv:4:ticks: time falls from 10 to 9 (ticks)",
    );
    check(&format!("{HEAD}11,1,2,0\n"), "r.csv:4:b: level is '2'");
    check(&format!("{HEAD}11,1,,0\n"), "r.csv:4:b: level is ''");
    check(
        &format!("{HEAD}11,1,0,high and a great deal more than anyone would want to see\n"),
        "r.csv:4:z: level is 'high and a great deal more than anyone w...'",
    );
    check(
        &format!("{HEAD}NaN,1,0,0\n"),
        "r.csv:4:ticks: the time is 'NaN'",
    );
    check(
        &format!("{HEAD}-inf,1,0,0\n"),
        "r.csv:4:ticks: the time is '-inf'",
    );
    check(
        &format!("{HEAD}1.5,1,0,0\n"),
        "r.csv:4:ticks: '1.5' is not a whole number",
    );
    check(
        &format!("{HEAD}-1,1,0,0\n"),
        "r.csv:4:ticks: '-1' is not a whole number",
    );
    check(
        &format!("{HEAD}18446744073709551616,1,0,0\n"),
        "r.csv:4:ticks: time '18446744073709551616' is beyond",
    );
    check(
        &format!("{HEAD}11,1\n12,0,0,0\n"),
        "r.csv:4: 2 fields where the column line has 4",
    );
    check(&format!("{HEAD}11,1,0,0,0\n"), "r.csv:4: 5 fields");
    check(
        &format!("{HEAD}11,1,0"),
        "r.csv:4: the file is cut off within its last row",
    );
    check(&format!("{HEAD}11,1,0,\0\n"), "r.csv:4: not text");
    check(
        "# clock_hz = 1\n# timer_bits = 16\nticks\n65536\n",
        "r.csv:4:ticks: '65536' is not within the header's timer_bits",
    );
}

#[test]
fn native_headers() {
    check(
        "ticks,a,b\n1,0,0\n",
        "r.csv:1: the tick rate is not given; add a line '# clock_hz",
    );
    check(
        "# clock_hz = 0\nticks\n1\n",
        "r.csv:1:clock_hz: clock_hz is '0'; it must be a whole number",
    );
    check(
        "# clock_hz = 1\n# timer_bits = 24\nticks\n1\n",
        "r.csv:2:timer_bits: timer_bits is '24'; it must be 16 or 32",
    );
    check(
        "# clock_hz = 1\na,b,z\n0,0,0\n",
        "r.csv:2: no column ticks, found a, b, z",
    );
    check(
        "# clock_hz = 1\nticks,b,z\n0,0,0\n",
        "r.csv:2: no column a, found ticks, b, z",
    );
    check(
        "# clock_hz = 1\nticks,x,y\n0,0,0\n",
        "r.csv:2: no column a, found ticks, x, y",
    );
    check(
        "# clock_hz = 1\nticks,a,a\n0,0,0\n",
        "r.csv:2:a: more than one column",
    );
    check(
        "# clock_hz = 1\n",
        "r.csv:1: no column ticks, found no column line",
    );
    check(
        "# clock_hz = 1\nticks,a\n",
        "r.csv: no edges in the recording",
    );
}

#[test]
fn whole_files() {
    check(
        "# A motor.\n\nseed = 1\n[shaft]\n",
        "r.csv:3: a twin, not a known recording; give native CSV",
    );
    check(
        "[encoder.hall]\npole_pairs = 2\n",
        "r.csv:1: a twin, not a known recording",
    );
    check("", "r.csv: the file is empty");
    check(" \r\n\n", "r.csv: the file is empty");
    check(
        "one,two\n1,2\n",
        "r.csv:1: found one, two, not a known recording; give native CSV",
    );
    check("PK\x03\x04...", "r.csv: a zip archive");
    check("ticks\n\0\0\0", "r.csv:2: not text");
    let endless = format!("{HEAD}{}", "1".repeat(70_000));
    check(&endless, "r.csv:4: longer than 65536 bytes");
    let error = open("no/such\nfile.csv".as_ref(), &ReadOptions::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "no/such?file.csv: no such file; check the path"
    );
    let folder = open(env!("CARGO_MANIFEST_DIR").as_ref(), &ReadOptions::default());
    assert!(matches!(folder, Err(ReadError::Io { .. })));
}

#[test]
fn logic_rows() {
    check(
        "Time [s],A\n-1,0\n2,1\n-1,0\n",
        "r.csv:4:Time [s]: time falls from 2000000000 to -1000000000 (ns)",
    );
    check(
        "Time [s],A,B\n0,0,0\n-1,1,0\n",
        "r.csv:3:Time [s]: time falls from 0 to -1000000000 (ns)",
    );
    check(
        "Time [s],A,B\n0,0,0\n2,1,0\n1,1,1\n",
        "r.csv:4:Time [s]: time falls",
    );
    check(
        "Time [s],A,B\n0,0,0\nnan,1,0\n",
        "r.csv:3:Time [s]: the time is 'nan'",
    );
    check(
        "Time [s],A,B\n0,0,0\n1e30,1,0\n",
        "r.csv:3:Time [s]: time '1e30' is beyond 64-bit",
    );
    check("Time [s],A,B\n0,0,0\n1,1,X\n", "r.csv:3:B: level is 'X'");
    check("Time [s],A,B\n0,0,0\n1,1", "r.csv:3: the file is cut off");
    check("Time [s],A,B\n0,0,0\n1,1,", "r.csv:3: the file is cut off");
    check(
        "Time [h],A,B\n0,0,0\n",
        "r.csv:1:Time [h]: the unit of time is 'h'",
    );
    check(
        "Time [s],Channel 0\n0,0\n",
        "r.csv:1: no column a, found Time [s], Channel 0",
    );
    let message = message("r.csv", "Time [s],A,B\n0,0,0\n", &mapped(&["z=Index"]));
    assert!(
        message.starts_with("r.csv:1: no column Index, found Time [s], A, B"),
        "{message}"
    );
}

#[test]
fn list_values() {
    check("0.5\n-0.1\n", "r.csv:2:1: negative interval '-0.1'");
    check("0.5\ninf\n", "r.csv:2:1: the time is 'inf'");
    check(
        "0.5\n0.4\nabc\n",
        "r.csv:3:1: 'abc' is not a decimal number",
    );
    check("9e9\n8e9\n7e9\n", "r.csv:3:1: time '7e9' is beyond 64-bit");
    let times = ReadOptions {
        list: ListKind::Times,
        ..ReadOptions::default()
    };
    let message = message("r.csv", "1\n2\n1.5\n", &times);
    assert!(
        message.starts_with("r.csv:3:1: time falls from 2000000000 to 1500000000 (ns)"),
        "{message}"
    );
}

const VCD: &str = "$timescale 1ns $end\n$var wire 1 ! a $end\n$var wire 1 % b $end\n$enddefinitions $end\n\
    $dumpvars\n0!\n0%\n$end\n#123\n1!\n#456\n1%\n";

#[test]
fn vcd_contents() {
    check(
        &VCD.replace("#456", "#12"),
        "r.csv:11: time falls from 123 to 12",
    );
    check(
        &VCD.replace("#456\n1%", "#456\nx%"),
        "r.csv:12:b: level becomes 'x'",
    );
    check(
        &VCD.replace("$timescale 1ns $end\n", ""),
        "r.csv:3: the tick rate is not given",
    );
    check(&VCD.replace("1ns", "3 ns"), "r.csv:1: $timescale is '3 ns'");
    check(
        &VCD.replace(" a ", " q "),
        "r.csv:4: no column a, found q, b",
    );
    check(
        &VCD.replace("wire 1 %", "wire 2 %"),
        "r.csv:3:b: the signal's width is '2'",
    );
    check(
        &VCD.replace(" b ", " a "),
        "r.csv:3:a: more than one column",
    );
    check(
        &VCD.replace("#456", "?456"),
        "r.csv:11: not valid VCD (unexpected character",
    );
    check(
        &VCD.replace("#456", "#99999999999999999999"),
        "r.csv:11: not valid VCD (number too large",
    );
    check(
        &format!("$comment {}", "x".repeat(70_000)),
        "r.csv:1: longer than 65536 bytes",
    );
    check(
        &VCD.replace("#123\n1!\n#456\n1%\n", "").replace("0!\n", ""),
        "r.csv: no edges",
    );
    let zero = ReadOptions {
        format: Some(Format::Vcd),
        ..ReadOptions::default()
    };
    assert!(message("r.csv", "ticks\n1\n", &zero).starts_with("r.csv:1: not valid VCD"));
}

#[test]
fn a_vcd_cut_anywhere_is_an_error_or_a_shorter_recording() {
    let whole = rows("v.vcd", VCD, &ReadOptions::default()).unwrap();
    assert_eq!(whole, [(0, 0), (123, 1), (456, 3)]);
    let definitions = VCD.find("#123").unwrap();
    let defined = VCD.find("$dumpvars").unwrap() - 1;
    for cut in 1..VCD.len() - 1 {
        match rows("v.vcd", &VCD[..cut], &ReadOptions::default()) {
            Ok(rows) => assert!(
                cut >= definitions - 1 && whole.starts_with(&rows),
                "cut at {cut}: {rows:?}"
            ),
            // Definitions with nothing behind them are whole.
            Err(ReadError::NoRows { .. }) => {
                assert!((defined..=defined + 1).contains(&cut), "cut at {cut}")
            }
            Err(error) => assert!(
                matches!(error, ReadError::Truncated { .. }),
                "cut at {cut}: {error}"
            ),
        }
    }
    let within = |text: &str| message("v.vcd", text, &ReadOptions::default());
    assert!(
        within(&VCD[..VCD.find("$enddef").unwrap()]).contains("cut off before $enddefinitions")
    );
    assert!(within(&VCD[..definitions - 6]).contains("cut off within a $dump section"));
    assert!(within(VCD.trim_end_matches("56\n1%\n")).contains("cut off within a time"));
}

#[test]
fn an_error_ends_the_recording() {
    let text = format!("{HEAD}9,1,0,0\n11,1,1,0\n");
    let mut recording = open_bytes("r.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
    assert!(recording.next().unwrap().is_ok());
    let error = recording.next().unwrap().unwrap_err();
    assert_eq!(error.place().line, Some(4));
    assert!(recording.next().is_none());
}

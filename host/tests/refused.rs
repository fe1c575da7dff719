//! Every way in which simulate, calibrate and verify can go wrong: one line, an exit code, and no file left behind.

mod workshop;

use std::fs;

use workshop::{TWIN, done, refused, workshop};

#[test]
fn a_table_that_makes_it_worse_is_exit_code_1() {
    let folder = workshop();
    let at = folder.path();
    let perfect = TWIN
        .replace("2e-3", "1e-9")
        .replace("4e-3", "0")
        .replace("6e-3", "0");
    fs::write(at.join("perfect.toml"), perfect).unwrap();
    done(at, "simulate perfect.toml -o perfect.csv");
    let message = refused(&folder, "verify perfect.csv --table rig.qct", 1);
    assert!(
        message.starts_with("quadcal: rig.qct: this table makes the encoder WORSE"),
        "{message}"
    );
}

#[test]
fn a_table_of_another_disc_is_refused_by_its_fingerprint() {
    let folder = workshop();
    let at = folder.path();
    done(at, "simulate rig.toml --seed 5 -o other.csv");
    let message = refused(&folder, "locate other.csv --table rig.qct --starts 9", 1);
    assert!(
        message.starts_with("quadcal: rig.qct: this table belongs to another disc"),
        "{message}"
    );
    let perfect = TWIN.replace("2e-3", "1e-9");
    fs::write(at.join("perfect.toml"), perfect).unwrap();
    done(at, "simulate perfect.toml -o perfect.csv");
    done(at, "calibrate perfect.csv --turns 11 -o perfect.qct");
    let message = refused(&folder, "locate perfect.csv --table perfect.qct", 1);
    assert!(
        message.contains("no place was found at any of 100 starts"),
        "{message}"
    );
    done(at, "calibrate rig.csv -o all.qct");
    fs::write(
        at.join("few.toml"),
        TWIN.replace("lines = 50", "lines = 12"),
    )
    .unwrap();
    done(at, "simulate few.toml -o few.csv");
    done(at, "calibrate few.csv --turns 11 -o few.qct");
    for (arguments, expected) in [
        (
            "few.csv --table few.qct",
            "few.qct: the table has 48 edges a turn",
        ),
        (
            "few.csv --table rig.qct",
            "rig.qct: the table is for 200 edges a turn in 4 classes, the recording shows 48 in 4",
        ),
        ("rig.csv --table all.qct", "rig.csv: no edge is left"),
        ("rig.csv --table rig.csv", "rig.csv: not an error table"),
        ("rig.csv --table gone.qct", "gone.qct: cannot be read"),
    ] {
        let message = refused(&folder, &format!("locate {arguments}"), 2);
        assert!(message.contains(expected), "{arguments}: {message}");
    }
}

#[test]
fn bad_recordings_and_twins_are_refused_with_the_reason() {
    let folder = workshop();
    let at = folder.path();
    let write = |name: &str, text: &str| fs::write(at.join(name), text).unwrap();
    let recording = fs::read_to_string(at.join("rig.csv")).unwrap();
    let without_z: Vec<String> = recording
        .lines()
        .map(|line| match line.rsplit_once(',') {
            Some((rest, "z" | "0" | "1")) => rest.to_owned(),
            _ => line.to_owned(),
        })
        .collect();
    write("no-z.csv", &(without_z.join("\n") + "\n"));
    let short: Vec<&str> = recording.lines().take(500).collect();
    write("short.csv", &(short.join("\n") + "\n"));
    write("wrong.toml", &TWIN.replace("lines = 50", "lines = 60"));
    write("typo.toml", &TWIN.replace("width_a_rad", "widht_a_rad"));
    write("range.toml", &TWIN.replace("lines = 50", "lines = 0"));
    write(
        "hall.toml",
        &TWIN
            .replace(
                "[encoder.quadrature]\nlines = 50\nindex = true",
                "[encoder.hall]\npole_pairs = 2",
            )
            .replace("quadrature_rad = 6e-3", ""),
    );
    for (arguments, expected) in [
        (
            "calibrate no-z.csv --lines 50 -o t.qct",
            "no-z.csv: no index pulse",
        ),
        ("calibrate short.csv -o t.qct", "short.csv: "),
        (
            "calibrate short.csv --lines 50 -o t.qct",
            "whole turns can be used and three are needed",
        ),
        (
            "calibrate rig.csv --lines 60 -o t.qct",
            "the encoder has 50 lines, not 60; use --lines 50",
        ),
        (
            "calibrate rig.csv --twin wrong.toml -o t.qct",
            "use --lines 50 in place of --twin wrong.toml",
        ),
        (
            "calibrate rig.csv --twin hall.toml -o t.qct",
            "hall.toml: the twin declares three Hall sensors",
        ),
        (
            "calibrate rig.csv --twin typo.toml -o t.qct",
            "typo.toml:8:1: ",
        ),
        (
            "calibrate rig.csv --twin none.toml -o t.qct",
            "none.toml: can't read the twin",
        ),
        ("simulate typo.toml -o t.csv", "typo.toml:8:1: "),
        (
            "simulate range.toml -o t.csv --truth t2.csv",
            "range.toml:4:9: encoder.quadrature.lines = 0",
        ),
        (
            "simulate rig.toml -o t.txt",
            "t.txt: cannot tell the format",
        ),
        (
            "simulate rig.toml -o rig.toml",
            "rig.toml: is the input itself",
        ),
        (
            "calibrate rig.csv -o rig.csv",
            "rig.csv: is the input itself",
        ),
        (
            "calibrate missing.csv -o t.qct",
            "missing.csv: no such file",
        ),
    ] {
        let message = refused(&folder, arguments, 2);
        assert!(message.contains(expected), "{arguments}: {message}");
    }
}

#[test]
fn recordings_that_do_not_go_together_are_refused_by_both_names() {
    let folder = workshop();
    let at = folder.path();
    for (name, twin) in [
        ("other", TWIN.replace("lines = 50", "lines = 40")),
        (
            "clock",
            TWIN.replace("clock_hz = 84_000_000", "clock_hz = 72_000_000"),
        ),
        ("free", TWIN.replace("index = true", "index = false")),
        (
            "hall",
            TWIN.replace(
                "[encoder.quadrature]\nlines = 50\nindex = true",
                "[encoder.hall]\npole_pairs = 2",
            )
            .replace("quadrature_rad = 6e-3", ""),
        ),
    ] {
        fs::write(at.join(format!("{name}.toml")), twin).unwrap();
        done(at, &format!("simulate {name}.toml -o {name}.csv"));
    }
    for (arguments, expected) in [
        (
            "rig.csv other.csv",
            "other.csv: does not go with rig.csv: this one shows 40 lines a turn, the other 50; ",
        ),
        (
            "rig.csv clock.csv",
            "clock.csv: does not go with rig.csv: this one has a clock of 72000000 Hz, the other of 84000000 Hz; ",
        ),
        (
            "rig.csv hall.csv",
            "hall.csv: does not go with rig.csv: this one is of three Hall sensors, the other of a quadrature encoder; ",
        ),
        (
            "rig.csv free.csv --lines 50 --no-index",
            "free.csv: does not go with rig.csv: without an index or a gap nothing ties",
        ),
        (
            "rig.csv rig.csv",
            "rig.csv: does not go with rig.csv: both are the same recording",
        ),
        ("rig.csv none.csv", "none.csv: no such file; "),
        ("none.csv rig.csv", "none.csv: no such file; "),
    ] {
        let arguments =
            format!("calibrate {arguments} -o t.qct --csv t.csv --report t.html --json t.json");
        let message = refused(&folder, &arguments, 2);
        assert!(
            message.starts_with(&format!("quadcal: {expected}")),
            "{arguments}: {message}"
        );
    }
    let recording = fs::read_to_string(at.join("rig.csv")).unwrap();
    // Another start, so that it is no part of the same recording.
    let stub: Vec<&str> = recording.lines().skip(300).take(300).collect();
    let head = "# clock_hz = 84000000\nticks,a,b,z\n";
    fs::write(
        at.join("stub.csv"),
        head.to_owned() + &stub.join("\n") + "\n",
    )
    .unwrap();
    let message = refused(&folder, "calibrate rig.csv stub.csv --lines 50 -o t.qct", 2);
    assert!(
        message.starts_with("quadcal: stub.csv: 0 whole turns can be used"),
        "{message}"
    );
    fs::copy(at.join("other.csv"), at.join("second.csv")).unwrap();
    let message = refused(&folder, "calibrate rig.csv second.csv -o second.csv", 2);
    assert!(
        message.contains("second.csv: is the input itself"),
        "{message}"
    );
}

#[test]
fn bad_tables_and_references_are_refused_with_the_reason() {
    let folder = workshop();
    let at = folder.path();
    let table = fs::read(at.join("rig.qct")).unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(at.join(name), bytes).unwrap();
    write("cut.qct", &table[..100]);
    write("none.qct", b"");
    let mut changed = table.clone();
    changed[80] ^= 1;
    write("changed.qct", &changed);
    changed = table.clone();
    changed[4] = 9;
    write("newer.qct", &changed);
    let other = TWIN.replace("lines = 50", "lines = 40");
    write("other.toml", other.as_bytes());
    done(at, "simulate other.toml -o other.csv");
    done(at, "calibrate other.csv -o other.qct");
    let reference = fs::read_to_string(at.join("ref.csv")).unwrap();
    let mut rows: Vec<&str> = reference.lines().collect();
    rows[9] = "0.01,NaN";
    write("nan.csv", rows.join("\n").as_bytes());
    write("late.csv", b"time,angle_rad\n1000,0\n1001,1\n");
    for (arguments, expected) in [
        ("--table rig.csv", "rig.csv: not an error table"),
        ("--table none.qct", "none.qct: the table is empty"),
        (
            "--table cut.qct",
            "cut.qct: the table is cut off: 100 of 564 bytes",
        ),
        (
            "--table changed.qct",
            "changed.qct: the table is damaged: its check sum",
        ),
        (
            "--table newer.qct",
            "newer.qct: the table has format version 9",
        ),
        ("--table gone.qct", "gone.qct: cannot be read"),
        (
            "--table other.qct",
            "other.qct: the table is for 160 edges a turn in 4 classes, the recording shows 200 in 4",
        ),
        (
            "--table rig.qct --reference nan.csv",
            "nan.csv:10: 'NaN' in column 'angle_rad'",
        ),
        (
            "--table rig.qct --reference late.csv",
            "late.csv: no edge of the recording",
        ),
        ("--table rig.qct --reference rig.csv", "rig.csv"),
    ] {
        let arguments = format!("verify rig.csv {arguments} --report t.html --json t.json");
        let message = refused(&folder, &arguments, 2);
        assert!(message.contains(expected), "{arguments}: {message}");
    }
}

#[test]
fn a_table_without_index_holds_for_its_own_recording_only() {
    let folder = workshop();
    let at = folder.path();
    let no_index = TWIN.replace("index = true", "index = false");
    fs::write(at.join("free.toml"), no_index).unwrap();
    done(at, "simulate free.toml -o free.csv");
    done(at, "simulate free.toml --seed 5 -o free2.csv");
    let text = done(
        at,
        "calibrate free.csv --twin free.toml --fraction 0.6 -o free.qct",
    );
    assert!(
        text.contains("the first edge (holds for this recording only)"),
        "{text}"
    );
    done(at, "verify free.csv --table free.qct");
    for recording in ["free2.csv", "rig.csv"] {
        let message = refused(&folder, &format!("verify {recording} --table free.qct"), 2);
        assert!(
            message.contains("holds only for the recording it was learned from"),
            "{message}"
        );
    }
    done(at, "calibrate free.csv --twin free.toml -o all.qct");
    let message = refused(&folder, "verify free.csv --table all.qct", 2);
    assert!(message.contains("no whole turn is left"), "{message}");
}

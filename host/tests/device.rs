//! `quadcal device` from one end to the other, on the core's own device behind a socket, a TCP port and a serial line.
#![cfg(unix)]

mod pretended;

use std::collections::BTreeSet;
use std::fs;
use std::io::{Read, Write};
use std::process::Stdio;
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::Duration;

use pretended::{Bench, QUICK, number, small};
use quadcal::slot::Slot;
use quadcal_host::device::{Address, Port};
use quadcal_host::pretend::{Listener, serve, serve_port};
use serde_json::Value;

#[test]
fn a_device_says_who_it_is_and_how_it_stands() {
    let bench = Bench::start(&small());
    let identity = bench.json("identify");
    assert_eq!(identity["edges_per_turn"], 256);
    assert_eq!(identity["edge_classes"], 4);
    assert_eq!(identity["clock_hz"], 84_000_000);
    assert_eq!(identity["serial"], 7);
    let text = bench.done("identify");
    assert!(text.contains("256 edges a turn in 4 classes"), "{text}");
    let status = bench.json("status");
    assert_eq!(status["stage"], "idle");
    assert_eq!(status["table"], Value::Null);
    assert_eq!(status["failure"], Value::Null);
    assert!(bench.done("status").contains("UNCORRECTED"));
    assert_eq!(bench.json("preview")["proof"], Value::Null);
    assert!(bench.done("preview").contains("nothing yet; "));
}

#[test]
fn a_calibration_goes_from_start_to_flash_and_is_there_after_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let mut pretend = small();
    pretend.flash = Some(folder.path().join("flash"));
    let mut bench = Bench::start(&pretend);
    let result = bench.json(&format!("{QUICK} --commit"));
    assert_eq!(result["outcome"], "committed");
    assert_eq!(result["failure"], Value::Null);
    assert_eq!(result["table"]["sequence"], 0);
    let (learned, proof) = (&result["learned"], &result["proof"]);
    assert_eq!(learned["turns"], 12);
    assert_eq!(learned["classes"].as_array().unwrap().len(), 4);
    let found = number(&learned["table_rms_rad"]);
    assert!(
        found > 10.0 * number(&learned["standard_error_rad"]),
        "{learned}"
    );
    assert_eq!(proof["better"], true);
    let [old, new] = ["old", "new"].map(|table| number(&proof[table]["interval_rms_rad"]));
    assert!(old > 10.0 * new, "{old} {new}");
    assert_eq!(bench.json("status")["stage"], "done");
    bench.kill();
    let bench = Bench::start(&pretend);
    let status = bench.json("status");
    assert_eq!(status["stage"], "idle");
    assert_eq!(status["table"]["turns"], 12);
    assert_eq!(status["table"]["serial"], 7);
    assert!(number(&status["table"]["learned_at_unix_s"]) > 1.7e9);
    assert_eq!(status["erasures"], serde_json::json!([1, 0]));
}

#[test]
fn a_table_waits_until_it_is_committed_or_given_up() {
    let bench = Bench::start(&small());
    // Nobody is there to be asked.
    assert_eq!(bench.json(QUICK)["outcome"], "waiting");
    assert_eq!(bench.json("status")["stage"], "ready_to_commit");
    assert_eq!(bench.json("preview")["proof"]["turns"], 6);
    let text = bench.done("preview");
    assert!(
        text.contains("Edge to edge, RMS") && text.contains("certainly better"),
        "{text}"
    );
    let busy = bench.refused(QUICK, 1);
    assert!(busy.contains("a table waits to be committed; "), "{busy}");
    assert_eq!(bench.json("abort")["stage"], "idle");
    let none = bench.refused("commit", 1);
    assert!(none.contains("no table waits to be committed; "), "{none}");
    assert_eq!(
        bench.json(&format!("{QUICK} --no-commit"))["outcome"],
        "waiting"
    );
    let committed = bench.json("commit");
    assert_eq!(
        (&committed["done"], &committed["stage"]),
        (&"commit".into(), &"done".into())
    );
    assert_eq!(committed["table"]["turns"], 12);
}

#[test]
fn on_a_terminal_it_asks_before_it_commits() {
    // The last answer is Ctrl-C.
    for (answer, outcome, stage, code) in [
        ("y\n", "in flash and in use", "done", 0),
        ("n\n", "given up; ", "idle", 0),
        ("", "given up; ", "idle", 1),
    ] {
        let bench = Bench::start(&small());
        let (mut master, slave) = serialport::TTYPort::pair().unwrap();
        let name = serialport::SerialPort::name(&slave).unwrap();
        let open = || {
            let file = fs::File::options().read(true).write(true).open(&name);
            Stdio::from(file.unwrap())
        };
        let mut command = bench.command(QUICK);
        command.stdin(open()).stderr(open()).stdout(Stdio::piped());
        let child = command.spawn().unwrap();
        drop((command, slave));
        master.set_wait(Duration::from_secs(60)).unwrap();
        let mut asked = Vec::new();
        while !String::from_utf8_lossy(&asked).contains("[y/N]") {
            let mut byte = [0];
            master.read_exact(&mut byte).unwrap();
            asked.extend(byte);
        }
        // What there is to decide by stands before the question.
        let text = String::from_utf8_lossy(&asked);
        assert!(
            text.contains("Edge to edge, RMS") && text.contains("certainly better"),
            "{text}"
        );
        master.write_all(answer.as_bytes()).unwrap();
        if answer.is_empty() {
            pretended::interrupt(&child);
        }
        let output = child.wait_with_output().unwrap();
        let text = String::from_utf8(output.stdout).unwrap();
        assert_eq!(output.status.code(), Some(code), "{text}");
        assert!(text.contains(outcome), "{text}");
        assert_eq!(bench.json("status")["stage"], stage);
    }
}

#[test]
fn the_table_before_comes_back_and_all_can_be_erased() {
    let bench = Bench::start(&small());
    bench.done(&format!("{QUICK} --commit"));
    assert!(bench.refused("rollback", 1).contains("no older table"));
    bench.done("dump -o first.qct");
    bench.done("load first.qct --commit");
    assert_eq!(bench.json("status")["table"]["sequence"], 1);
    assert_eq!(bench.json("rollback")["table"]["sequence"], 0);
    let sure = bench.refused("erase", 2);
    assert!(sure.contains("--yes"), "{sure}");
    assert_eq!(bench.json("status")["table"]["sequence"], 0);
    let erased = bench.json("erase --yes");
    assert_eq!(erased["table"], Value::Null);
    assert!(
        bench
            .refused("dump -o none.qct", 1)
            .contains("has no table; ")
    );
    assert_eq!(bench.files(), ["first.qct"]);
    assert_eq!(bench.json("log-level debug")["log_level"], "debug");
    assert_eq!(bench.json("status")["log_level"], "debug");
}

#[test]
fn a_dumped_table_is_one_that_the_other_commands_read() {
    let bench = Bench::start(&small());
    bench.done(&format!("{QUICK} --commit"));
    let dumped = bench.json("dump -o drive.qct");
    let bytes = fs::read(bench.path().join("drive.qct")).unwrap();
    assert_eq!(dumped["bytes"], bytes.len());
    let slot = Slot::parse(&bytes).unwrap();
    assert_eq!((slot.header.turns, slot.header.stamp.serial), (12, 7));
    // Through a pipe they are the same.
    let output = bench.run("dump -o -");
    assert!(output.stdout == bytes);
    // Another recording of the same disc.
    let twin = "seed = 1\nduration = { turns = 20 }\n[encoder.quadrature]\nlines = 64\nindex = true\n\
        [errors]\nposition = { uniform = { amplitude_rad = 2.4544e-3 } }\nwidth_a_rad = 4.9086e-3\n\
        width_b_rad = 4.4180e-3\nquadrature_rad = 4.9086e-3\n[shaft]\ninertia_kg_m2 = 1e-4\n\
        viscous_n_m_s = 1e-4\n[drive.constant]\nr_min = 900\n[timer]\nclock_hz = 84_000_000\n";
    fs::write(bench.path().join("rig.toml"), twin).unwrap();
    let quadcal = |arguments: &str| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_quadcal"));
        let output = command
            .current_dir(bench.path())
            .args(arguments.split(' '))
            .output();
        let output = output.unwrap();
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{arguments}: {errors}");
        output.stdout
    };
    quadcal("simulate rig.toml -o rig.csv");
    let verified: Value =
        serde_json::from_slice(&quadcal("verify rig.csv --table drive.qct --json -")).unwrap();
    assert_eq!(verified["verdict"], "better");
    let [before, after] = ["scatter_before", "scatter_after"].map(|name| number(&verified[name]));
    assert!(before > 10.0 * after, "{before} {after}");
    // And the other way round.
    quadcal("calibrate rig.csv --turns 11 -o bench.qct");
    let loaded = bench.json("load bench.qct");
    assert_eq!(loaded["committed"], false);
    assert_eq!(bench.json("status")["stage"], "ready_to_commit");
    bench.done("commit");
    assert_eq!(bench.json("status")["table"]["turns"], 11);
}

#[test]
fn the_commands_work_over_tcp_and_a_serial_line() {
    let probe = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let place = format!("tcp:{}", probe.local_addr().unwrap());
    drop(probe);
    let address: Address = place.parse().unwrap();
    let listener = Listener::bind(&address).unwrap();
    let (mut master, slave) = serialport::TTYPort::pair().unwrap();
    let serial = serialport::SerialPort::name(&slave).unwrap();
    drop(slave);
    // Both end with the test.
    thread::spawn(move || {
        let mut device = small().start().unwrap();
        serve(&mut device, &listener, &AtomicBool::new(false)).unwrap();
    });
    thread::spawn(move || {
        let mut device = small().start().unwrap();
        loop {
            // A line without a host at its other end fails to be read.
            serve_port(&mut device, &mut master, &AtomicBool::new(false)).unwrap();
            thread::sleep(Duration::from_millis(1));
        }
    });
    let bench = Bench::answering(|_| Vec::new());
    for port in [place, serial] {
        let status = bench.json(&format!("status --port {port}"));
        assert_eq!(status["stage"], "idle");
        assert_eq!(status["port"], port.as_str());
        let result = bench.json(&format!("--port {port} {QUICK} --commit"));
        assert_eq!(result["outcome"], "committed", "{port}");
        bench.done(&format!("dump --port {port} -o table.qct"));
    }
}

/// Names of all fields, nested ones too.
fn fields(value: &Value, names: &mut BTreeSet<String>) {
    match value {
        Value::Object(object) => {
            for (name, value) in object {
                names.insert(name.clone());
                fields(value, names);
            }
        }
        Value::Array(items) => items.iter().for_each(|item| fields(item, names)),
        _ => {}
    }
}

#[test]
fn every_field_of_the_json_is_described() {
    let bench = Bench::start(&small());
    let mut names = BTreeSet::new();
    let mut take = |arguments: &str| fields(&bench.json(arguments), &mut names);
    take("identify");
    take(&format!("{QUICK} --commit"));
    take("status");
    take("preview");
    take("dump -o t.qct");
    take("load t.qct --commit");
    take("log-level info");
    for line in bench.done("watch --seconds 0.2 --json -").lines() {
        fields(&serde_json::from_str(line).unwrap(), &mut names);
    }
    assert!(names.len() > 50, "{names:?}");
    let described = include_str!("../../docs/device-json.md");
    for name in names {
        assert!(
            described.contains(&format!("`{name}`")),
            "{name} is not described"
        );
    }
}

#[test]
fn shells_complete_the_commands() {
    for shell in ["bash", "fish", "zsh"] {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_quadcal"));
        let output = command.args(["completions", shell]).output().unwrap();
        let script = String::from_utf8(output.stdout).unwrap();
        for word in ["recalibrate", "log-level", "key-file"] {
            assert!(script.contains(word), "{shell}: {word}");
        }
    }
}

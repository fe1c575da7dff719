//! `quadcal device` when something is wrong: the key, the line, the device, the table, or the drive says no.
#![cfg(unix)]

mod pretended;

use std::fs;
use std::process::Stdio;
use std::thread;
use std::time::{Duration, Instant};

use pretended::{Bench, QUICK, key, message, small};
use quadcal::wire::{Parser, Refusal, Reply, reply_frame};

#[test]
fn without_the_right_key_all_can_be_read_and_nothing_changed() {
    let bench = Bench::start(&small());
    let keyless = |arguments: &str| {
        let output = bench.command(arguments).env_remove("QUADCAL_KEY").output();
        output.unwrap()
    };
    assert_eq!(keyless("status").status.code(), Some(0));
    for change in [
        "commit",
        "abort",
        "rollback",
        "erase --yes",
        "log-level off",
        QUICK,
    ] {
        let missing = message(&keyless(change), 2);
        assert!(missing.contains("--key-file"), "{missing}");
        let odd = bench.command(change).env("QUADCAL_KEY", "secret").output();
        let odd = message(&odd.unwrap(), 2);
        assert!(
            odd.contains("64 hexadecimal digits") && !odd.contains("secret"),
            "{odd}"
        );
    }
    let wrong = || {
        bench
            .command("abort")
            .env("QUADCAL_KEY", "00".repeat(32))
            .output()
            .unwrap()
    };
    for _ in 0..4 {
        let refused = message(&wrong(), 2);
        assert!(
            refused.contains("the key is not this device's; "),
            "{refused}"
        );
    }
    // From now on guessing costs time, for whoever asks, and more each time.
    let refused = (0..4)
        .map(|_| wrong())
        .find(|output| output.status.code() == Some(1));
    let refused = message(&refused.unwrap(), 1);
    assert!(
        refused.contains("too many wrong keys were tried; wait "),
        "{refused}"
    );
    // A key from a file goes before that of the environment.
    fs::write(bench.path().join("key"), key()).unwrap();
    let right = || {
        let mut command = bench.command("log-level off --key-file key");
        command
            .env("QUADCAL_KEY", "00".repeat(32))
            .output()
            .unwrap()
    };
    let deadline = Instant::now() + Duration::from_secs(60);
    let mut given = right();
    while given.status.code() != Some(0) {
        assert!(message(&given, 1).contains("wait ") && Instant::now() < deadline);
        thread::sleep(Duration::from_millis(200));
        given = right();
    }
    assert!(
        bench
            .refused("abort --key-file device", 2)
            .contains("cannot be read")
    );
    assert_eq!(bench.json("status")["log_level"], "off");
}

#[test]
fn noise_and_lost_replies_cost_time_and_nothing_else() {
    let mut pretend = small();
    pretend.noisy_line = true;
    let bench = Bench::start(&pretend);
    for _ in 0..8 {
        assert_eq!(bench.json("identify --timeout 0.2")["serial"], 7);
    }
    // Every fourth reply is lost: of one that changed something, it is not known whether it was done.
    let (mut done, mut unknown) = (0, 0);
    for round in 0..12 {
        // So that it is not always the same one.
        for _ in 0..round % 4 {
            bench.run("identify --timeout 0.1");
        }
        let output = bench.run("log-level debug --timeout 0.1");
        match output.status.code() {
            Some(0) => done += 1,
            _ => {
                let text = message(&output, 3);
                assert!(text.contains("it may have been done or not; "), "{text}");
                unknown += 1;
            }
        }
    }
    assert!(done > 0 && unknown > 0, "{done} {unknown}");
    // Dumping and loading ask again for what is lost.
    let quiet = Bench::start(&small());
    quiet.done(&format!("{QUICK} --commit"));
    quiet.done("dump -o table.qct");
    let table = quiet.path().join("table.qct");
    let load = format!("load {} --timeout 0.1", table.display());
    let mut loaded = bench.run(&load);
    for _ in 0..5 {
        // A lost reply to the session's first request counts like any other.
        if loaded.status.success() {
            break;
        }
        bench.run("abort --timeout 0.1");
        loaded = bench.run(&load);
    }
    assert!(
        loaded.status.success(),
        "{}",
        String::from_utf8_lossy(&loaded.stderr)
    );
    assert_eq!(
        bench.json("status --timeout 0.1")["stage"],
        "ready_to_commit"
    );
}

#[test]
fn a_device_that_says_nothing_or_nonsense_is_told_apart() {
    let silent = Bench::answering(|_| Vec::new());
    let begun = Instant::now();
    let text = silent.refused("status --timeout 0.1", 3);
    assert!(
        text.contains("no reply, asked 3 times with 100.0ms each; check port"),
        "{text}"
    );
    assert!(begun.elapsed() < Duration::from_secs(5));
    assert!(
        silent
            .refused("abort --timeout 0.05", 3)
            .contains("no reply")
    );
    let nonsense = Bench::answering(|_| b"login: \r\n".to_vec());
    let text = nonsense.refused("watch --timeout 0.1", 3);
    assert!(
        text.contains("bytes of something else; check --baud"),
        "{text}"
    );
    // A stream of bytes without end does not hold it up.
    let endless = Bench::answering(|_| vec![0x55; 1 << 16]);
    assert!(
        endless
            .refused("status --timeout 0.1", 3)
            .contains("something else")
    );
}

/// Answers every frame that is whole.
fn replying(reply: impl Fn(u16) -> Vec<u8> + Send + 'static) -> Bench {
    let mut parser = Parser::new();
    Bench::answering(move |bytes| {
        let mut sent = Vec::new();
        for byte in bytes {
            if let Some(Ok(frame)) = parser.push(*byte) {
                sent.extend(reply(frame.number));
            }
        }
        sent
    })
}

#[test]
fn another_protocol_version_is_named_with_what_to_update() {
    let older =
        replying(|number| reply_frame(number, &Reply::Refused(Refusal::Version(0))).to_vec());
    let text = older.refused("status", 3);
    assert!(
        text.contains("protocol version 0, this quadcal speaks 1; update the device's firmware"),
        "{text}"
    );
    // A frame of version 9 with a right check sum.
    let newer = replying(|number| {
        let [low, high] = number.to_le_bytes();
        let mut body = vec![9, 2, low, high, 77, 77];
        let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&body);
        body.extend(crc.to_le_bytes());
        let mut frame = vec![0; 64];
        let length = cobs_encode(&body, &mut frame);
        frame.truncate(length);
        frame
    });
    let text = newer.refused("status", 3);
    assert!(
        text.contains("protocol version 9, this quadcal speaks 1; update quadcal"),
        "{text}"
    );
    let strange = replying(|number| reply_frame(number, &Reply::Done).to_vec());
    let text = strange.refused("identify", 3);
    assert!(
        text.contains("the reply to 'identify' is not known"),
        "{text}"
    );
    // Someone else's reply is none.
    let other = replying(|number| reply_frame(number.wrapping_add(9), &Reply::Done).to_vec());
    assert!(
        other
            .refused("identify --timeout 0.1", 3)
            .contains("no reply")
    );
}

/// A frame of less than 254 bytes between zeros, stuffed.
fn cobs_encode(body: &[u8], frame: &mut [u8]) -> usize {
    let (mut code, mut at) = (1, 2);
    for byte in body {
        if *byte == 0 {
            frame[code] = (at - code) as u8;
            code = at;
        } else {
            frame[at] = *byte;
        }
        at += 1;
    }
    frame[code] = (at - code) as u8;
    at + 1
}

#[test]
fn a_port_that_is_not_there_or_goes_away_is_named() {
    let mut bench = Bench::start(&small());
    for (port, advice) in [
        ("unix:nowhere", "check the name"),
        ("/dev/nowhere", "check the name"),
        ("tcp:127.0.0.1:1", "nothing listens there"),
    ] {
        let text = bench.refused(&format!("status --port {port}"), 3);
        assert!(
            text.starts_with(&format!("quadcal: {port}: ")) && text.contains(advice),
            "{text}"
        );
    }
    let nameless = bench
        .command("status")
        .env_remove("QUADCAL_PORT")
        .output()
        .unwrap();
    assert!(message(&nameless, 2).contains("--port"));
    let misnamed = bench
        .command("status")
        .env("QUADCAL_PORT", "tcp:here")
        .output()
        .unwrap();
    assert!(message(&misnamed, 2).contains("QUADCAL_PORT"));
    for port in ["tcp:here", "foo:bar"] {
        let output = bench.run(&format!("status --port {port}"));
        assert_eq!(output.status.code(), Some(2), "{port}");
    }
    let mut watching = bench
        .command("watch")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    pretended::line(watching.stdout.as_mut());
    bench.kill();
    let text = message(&watching.wait_with_output().unwrap(), 3);
    assert!(text.contains("the connection failed"), "{text}");
}

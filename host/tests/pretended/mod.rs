//! A pretend device at a socket, and the command at its other end.
// Each test program uses its part.
#![allow(dead_code)]

use std::fs;
use std::io::{Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::process::{Child, Command, Output};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use quadcal_host::device::Address;
use quadcal_host::pretend::{Listener, Pretend, serve};
use serde_json::Value;
use tempfile::TempDir;

/// A small encoder that turns fast, so that a calibration takes no time.
pub fn small() -> Pretend {
    Pretend {
        lines: 64,
        r_min: 1500.0,
        serial: 7,
        key: [0x5A; 32],
        ..Pretend::default()
    }
}

/// The right key in digits.
pub fn key() -> String {
    "5a".repeat(32)
}

/// The options of a calibration that is soon over.
pub const QUICK: &str = "recalibrate --turns 12 --proof-turns 6";

/// A device in a thread, and a folder for its socket and the command's files.
pub struct Bench {
    pub folder: TempDir,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Bench {
    pub fn start(pretend: &Pretend) -> Self {
        let pretend = pretend.clone();
        Self::with(move |listener, stop| {
            let mut device = pretend.start().unwrap();
            serve(&mut device, &listener, stop).unwrap();
        })
    }

    /// Something else at the socket: `answer` is given the bytes that came, and gives those to send.
    pub fn answering(mut answer: impl FnMut(&[u8]) -> Vec<u8> + Send + 'static) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let listener = UnixListener::bind(folder.path().join("device")).unwrap();
        // It ends with the test.
        thread::spawn(move || {
            for stream in listener.incoming() {
                let mut stream: UnixStream = stream.unwrap();
                let mut bytes = [0; 512];
                while let Ok(count @ 1..) = stream.read(&mut bytes) {
                    let sent = answer(&bytes[..count]);
                    if stream.write_all(&sent).is_err() {
                        break;
                    }
                }
            }
        });
        Self {
            folder,
            stop: Arc::default(),
            thread: None,
        }
    }

    fn with(run: impl FnOnce(Listener, &AtomicBool) + Send + 'static) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let address = Address::Unix(folder.path().join("device"));
        let listener = Listener::bind(&address).unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let seen = Arc::clone(&stop);
        let thread = Some(thread::spawn(move || run(listener, &seen)));
        Self {
            folder,
            stop,
            thread,
        }
    }

    /// Switches the device off.
    pub fn kill(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }

    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// The command, ready to start.
    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_quadcal"));
        command
            .current_dir(self.path())
            .arg("device")
            .args(arguments.split_whitespace())
            .env("QUADCAL_PORT", "unix:device")
            .env("QUADCAL_KEY", key());
        command
    }

    pub fn run(&self, arguments: &str) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Runs what must work and gives its stdout.
    pub fn done(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{arguments}: {errors}");
        String::from_utf8(output.stdout).unwrap()
    }

    /// Runs what must work and gives its JSON.
    pub fn json(&self, arguments: &str) -> Value {
        let text = self.done(&format!("{arguments} --json -"));
        serde_json::from_str(&text).unwrap_or_else(|error| panic!("{arguments}: {error}: {text}"))
    }

    /// Runs what must fail: its last line on stderr, which says what to do.
    pub fn refused(&self, arguments: &str, code: i32) -> String {
        message(&self.run(arguments), code)
    }

    pub fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.path()).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<_> = names.filter(|name| name != "device").collect();
        names.sort();
        names
    }
}

/// The one message of a failed command.
pub fn message(output: &Output, code: i32) -> String {
    let text = String::from_utf8(output.stderr.clone()).unwrap();
    assert_eq!(output.status.code(), Some(code), "{text}");
    let own: Vec<&str> = text
        .lines()
        .filter(|line| line.starts_with("quadcal: "))
        .collect();
    assert_eq!(own.len(), 1, "{text}");
    assert_eq!(text.lines().last(), Some(own[0]), "{text}");
    assert!(own[0].contains("; "), "no advice: {text}");
    own[0].to_owned()
}

impl Drop for Bench {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

/// The next line of a program that runs, and nothing after it.
pub fn line(from: Option<&mut impl Read>) -> String {
    let (from, mut line, mut byte) = (from.unwrap(), Vec::new(), [0]);
    while from.read(&mut byte).unwrap() == 1 && byte != *b"\n" {
        line.extend(byte);
    }
    String::from_utf8(line).unwrap()
}

/// Presses Ctrl-C.
pub fn interrupt(child: &Child) {
    let id = child.id().to_string();
    let killed = Command::new("kill").args(["-INT", &id]).status();
    assert!(killed.unwrap().success());
}

//! The pretend device as a program: it says how to reach it, and keeps its flash.
#![cfg(unix)]

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use quadcal::recalibrate::Options;
use quadcal_host::device::{Address, Calibrated, Client, Port, SerialLine, Timing, Watching};

/// A program that ends with the test.
struct Program(Child);

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Starts it in a folder, and a host at the port that it names.
fn start(folder: &Path) -> (Program, Client<Box<dyn Port>>) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pretend-device"));
    command
        .current_dir(folder)
        .args(["--listen", "unix:device", "--flash", "flash"])
        .args(["--lines", "64", "--speed", "1500"])
        .stdout(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let program = Program(child);
    assert!(lines.next().unwrap().unwrap().contains("unix:device"));
    let address: Address = format!("unix:{}", folder.join("device").display())
        .parse()
        .unwrap();
    let port = address.open(SerialLine::default()).unwrap();
    (
        program,
        Client::new(port, "device", Timing::default(), Some([0; 32])),
    )
}

#[test]
fn it_is_calibrated_and_keeps_its_table_when_it_is_killed() {
    let folder = tempfile::tempdir().unwrap();
    let (program, mut host) = start(folder.path());
    assert_eq!(host.identify().unwrap().edges, 256);
    let options = Options {
        turns: 12,
        ..Options::default()
    };
    let calibration = host.calibrate(&options, |_| Watching::GoOn).unwrap();
    assert_eq!(calibration.end, Calibrated::Waiting);
    let table = host.commit().unwrap();
    drop((program, host));
    let (_program, mut host) = start(folder.path());
    assert!(table.is_some());
    assert_eq!(host.status().unwrap().table, table);
}

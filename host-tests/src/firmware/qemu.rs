//! Running one image.

use std::ffi::OsString;
use std::fs::File;
use std::io::{ErrorKind, Read, Seek};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use process_control::{ChildExt, Control};

use super::{CORTEX_M4, FirmwareError, Target};

/// What a run in QEMU left behind.
#[derive(Debug)]
pub struct Output {
    /// Whether QEMU ended with code 0, which is what the image asked for.
    pub success: bool,
    /// What the image printed.
    pub stdout: String,
    /// What the image printed as errors, and QEMU's own complaints.
    pub stderr: String,
}

impl Output {
    /// The number after `key=` in what the image printed.
    #[must_use]
    pub fn value(&self, key: &str) -> Option<u64> {
        self.stdout
            .split_ascii_whitespace()
            .filter_map(|word| word.split_once('='))
            .find(|(name, _)| *name == key)
            .and_then(|(_, value)| value.parse().ok())
    }
}

/// Runs `elf` on an emulated STM32F405 with `args` as its command line (words without blanks) and `dir` as the directory its
/// file names start from. Virtual time is instructions times 8 ns, so a run is deterministic.
///
/// # Errors
/// No QEMU, or no end within `limit`. An image that fails is not an error here: see [`Output::success`].
pub fn run_qemu(
    elf: &Path,
    args: &[&str],
    dir: &Path,
    limit: Duration,
) -> Result<Output, FirmwareError> {
    run_qemu_on(&CORTEX_M4, elf, args, dir, limit)
}

/// Runs `elf` as [`run_qemu`] does, on a target's machine.
///
/// # Errors
/// No QEMU, or no end within `limit`.
pub fn run_qemu_on(
    target: &Target,
    elf: &Path,
    args: &[&str],
    dir: &Path,
    limit: Duration,
) -> Result<Output, FirmwareError> {
    // Files, not pipes: they can't fill up, and what was printed before a hang is still there.
    let (out, out_end) = stream()?;
    let (err, err_end) = stream()?;
    let mut machine = machine(target, elf, args, dir, "null");
    let mut child = spawn(counting(&mut machine).stdout(out_end).stderr(err_end))?;
    let status = child
        .controlled()
        .time_limit(limit)
        .terminate_for_timeout()
        .wait()
        .map_err(FirmwareError::io("waiting for qemu-system-arm"))?;
    let (stdout, stderr) = (contents(out)?, contents(err)?);
    match status {
        None => Err(FirmwareError::Hang {
            seconds: limit.as_secs(),
            printed: stdout + &stderr,
        }),
        Some(status) => Ok(Output {
            success: status.success(),
            stdout,
            stderr,
        }),
    }
}

/// Starts `elf` as [`run_qemu`] does, with its output in a pipe that takes what the image prints at once. Whoever starts it ends it.
///
/// # Errors
/// No QEMU.
pub fn start_qemu(elf: &Path, args: &[&str], dir: &Path) -> Result<Child, FirmwareError> {
    let mut machine = machine(&CORTEX_M4, elf, args, dir, "null");
    spawn(
        counting(&mut machine)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped()),
    )
}

/// Starts `elf` with its first serial port at a socket named `socket` in `dir`, and with its clock going as the host's. Whoever starts
/// it ends it.
///
/// # Errors
/// No QEMU.
pub fn start_qemu_at_port(
    elf: &Path,
    args: &[&str],
    dir: &Path,
    socket: &str,
) -> Result<Child, FirmwareError> {
    let serial = format!("unix:{},server=on,wait=off", socket.replace(',', ",,"));
    spawn(
        machine(&CORTEX_M4, elf, args, dir, &serial)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped()),
    )
}

/// Makes virtual time the number of instructions times 8 ns.
fn counting(machine: &mut Command) -> &mut Command {
    machine.args(["-icount", "shift=3"])
}

/// The command that runs `elf`, its first serial port being `serial`.
fn machine(target: &Target, elf: &Path, args: &[&str], dir: &Path, serial: &str) -> Command {
    let name = elf.file_stem().unwrap_or_default().to_string_lossy();
    let mut config = OsString::from("enable=on,target=native");
    for word in std::iter::once(name.as_ref()).chain(args.iter().copied()) {
        // QEMU's own way to write a comma inside a value.
        config.push(format!(",arg={}", word.replace(',', ",,")));
    }
    let mut command = Command::new("qemu-system-arm");
    command
        .current_dir(dir)
        .args([
            "-M",
            target.machine.unwrap_or("none"),
            "-display",
            "none",
            "-serial",
            serial,
            "-monitor",
            "none",
            "-semihosting-config",
        ])
        .arg(config)
        .arg("-kernel")
        .arg(elf)
        .stdin(Stdio::null());
    command
}

fn spawn(command: &mut Command) -> Result<Child, FirmwareError> {
    command.spawn().map_err(|source| match source.kind() {
        ErrorKind::NotFound => FirmwareError::NoQemu,
        _ => FirmwareError::io("starting qemu-system-arm")(source),
    })
}

fn stream() -> Result<(File, File), FirmwareError> {
    tempfile::tempfile()
        .and_then(|file| Ok((file.try_clone()?, file)))
        .map_err(FirmwareError::io("making a file for QEMU's output"))
}

fn contents(mut file: File) -> Result<String, FirmwareError> {
    let mut bytes = Vec::new();
    file.rewind()
        .and_then(|()| file.read_to_end(&mut bytes))
        .map_err(FirmwareError::io("reading QEMU's output"))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

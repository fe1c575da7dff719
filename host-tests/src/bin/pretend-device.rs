//! A device without hardware, to try `quadcal device` on: the core's own service with simulated edges in real time, at a socket.

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

use anyhow::anyhow;
use clap::{Parser, ValueEnum, value_parser};
use quadcal::recalibrate::Obstacle;
use quadcal::shape::EDGES_MAX;
use quadcal_host::device::{Address, key_from_file};
use quadcal_host::pretend::{Listener, Pretend, serve};

/// Lines of the largest encoder that the core takes.
const LINES_MAX: i64 = EDGES_MAX as i64 / 4;

/// Pretends to be a drive with a badly made encoder.
#[derive(Debug, Parser)]
struct Options {
    /// Where hosts connect: unix:PATH or tcp:HOST:PORT
    #[arg(long, value_name = "PORT", default_value = "unix:/tmp/quadcal-device", value_parser = socket)]
    listen: Address,
    /// File with the key: 32 bytes, or 64 hexadecimal digits; all zeros if not given
    #[arg(long, value_name = "PATH")]
    key_file: Option<PathBuf>,
    /// File that keeps the flash from one start to the next
    #[arg(long, value_name = "PATH")]
    flash: Option<PathBuf>,
    /// Lines of the encoder, from 1 to 16384
    #[arg(long, value_name = "M", default_value_t = Pretend::default().lines, value_parser = value_parser!(u32).range(1..=LINES_MAX))]
    lines: u32,
    /// Speed of the shaft, r/min, from 5 to 20000; 0 keeps it at rest
    #[arg(long, value_name = "R_MIN", default_value_t = Pretend::default().r_min, value_parser = speed, allow_negative_numbers = true)]
    speed: f64,
    /// Seed of the encoder's errors
    #[arg(long, value_name = "N", default_value_t = Pretend::default().seed, value_parser = value_parser!(u64).range(..1 << 63))]
    seed: u64,
    /// Refuse to calibrate, for this reason
    #[arg(long, value_name = "REASON")]
    no_calibration: Option<Reason>,
    /// Refuse to commit, for this reason
    #[arg(long, value_name = "REASON")]
    no_commit: Option<Reason>,
    /// Put garbage on the line and lose every fourth reply
    #[arg(long)]
    noise: bool,
}

/// Why something is not allowed.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Reason {
    Moving,
    Disabled,
    Fault,
    Supply,
    Temperature,
    Working,
}

impl From<Reason> for Obstacle {
    fn from(reason: Reason) -> Self {
        match reason {
            Reason::Moving => Self::Moving,
            Reason::Disabled => Self::Disabled,
            Reason::Fault => Self::Fault,
            Reason::Supply => Self::Supply,
            Reason::Temperature => Self::Temperature,
            Reason::Working => Self::Working,
        }
    }
}

fn socket(text: &str) -> Result<Address, String> {
    match text.parse::<Address>() {
        Ok(Address::Serial(_)) => Err("give unix:PATH or tcp:HOST:PORT".to_owned()),
        Ok(address) => Ok(address),
        Err(error) => Err(error.to_string()),
    }
}

/// At less than 5 r/min friction would stop the rig between two kicks of its wander.
fn speed(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value == 0.0 || (5.0..=20_000.0).contains(&value) => Ok(value),
        _ => Err("give r/min from 5 to 20000, or 0".to_owned()),
    }
}

fn main() -> ExitCode {
    match run(Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: Options) -> anyhow::Result<()> {
    let mut pretend = Pretend {
        lines: options.lines,
        r_min: options.speed,
        seed: options.seed,
        calibrate_obstacle: options.no_calibration.map(Obstacle::from),
        commit_obstacle: options.no_commit.map(Obstacle::from),
        noisy_line: options.noise,
        flash: options.flash,
        ..Pretend::default()
    };
    let port = options.listen.to_string();
    if let Some(path) = options.key_file {
        pretend.key = key_from_file(&path)?;
    }
    let mut device = pretend.start()?;
    let listener = Listener::bind(&options.listen)
        .map_err(|error| anyhow!("can't listen at {port}: {error}"))?;
    let _ = introduce(&port, &pretend.key);
    Ok(serve(&mut device, &listener, &AtomicBool::new(false))?)
}

/// Says how it is reached. Nobody has to listen.
fn introduce(port: &str, key: &[u8]) -> io::Result<()> {
    let mut out = io::stdout().lock();
    writeln!(
        out,
        "A device listens at {port}; Ctrl-C ends it. In another shell:"
    )?;
    writeln!(
        out,
        "  export QUADCAL_PORT={port} QUADCAL_KEY={}",
        digits(key)
    )?;
    writeln!(out, "  quadcal device status")?;
    writeln!(out, "  quadcal device recalibrate --commit")?;
    writeln!(out, "  quadcal device watch")
}

fn digits(key: &[u8]) -> String {
    key.iter().map(|byte| format!("{byte:02x}")).collect()
}

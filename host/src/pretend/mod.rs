//! A device that is not there: the core's own [`Device`] and edge path, with simulated edges in real time, behind a socket. With it the
//! `quadcal device` commands can be tried and tested without hardware.

mod flash;
mod parts;
mod rig;
mod serve;

use std::io;
use std::iter::Peekable;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use quadcal::access::{AccessConfig, Key};
use quadcal::decoder::{DecoderConfig, QuadratureDecoder};
use quadcal::device::{Device, DeviceConfig, EstimatorLearner, Workbench, WorkbenchConfig};
use quadcal::estimate::Solver;
use quadcal::recalibrate::{Limits, Obstacle, Stage, WearConfig};
use quadcal::shape::{EncoderShape, ShapeError};
use quadcal::step::Faults;
use quadcal::step::SensorError;
use quadcal::store::{LayoutError, Store};
use quadcal::wire::{Refusal, WireBytes};
use thiserror::Error;

use crate::buffers::HeapMemory;
use crate::sim::Simulation;
use crate::twin::{Twin, TwinError};

use flash::Flash;
use parts::{Drawn, Switches};

pub use serve::{Listener, serve, serve_port};

/// Timer clock, hertz.
pub const CLOCK_HZ: u64 = 84_000_000;

/// Changes of level that are made up in one go at the most, so that the port is served in between.
const BURST: u32 = 20_000;

/// Longest time that slices of solving follow each other, so that edges and the port are served in between.
const SOLVING: Duration = Duration::from_millis(10);

/// What a pretend device is.
#[derive(Clone, Debug, PartialEq)]
pub struct Pretend {
    /// Lines of the encoder.
    pub lines: u32,
    /// Speed of the shaft, r/min; 0: it stands still.
    pub r_min: f64,
    /// Seed of the encoder's errors and the shaft's wander.
    pub seed: u64,
    /// Serial number of the encoder.
    pub serial: u64,
    /// The key.
    pub key: Key,
    /// What keeps it from calibrating.
    pub calibrate_obstacle: Option<Obstacle>,
    /// What keeps it from committing.
    pub commit_obstacle: Option<Obstacle>,
    /// Garbage on the line, and every fourth reply lost.
    pub noisy_line: bool,
    /// File that keeps the flash; none: it is gone with the device.
    pub flash: Option<PathBuf>,
}

impl Default for Pretend {
    fn default() -> Self {
        Self {
            lines: 250,
            r_min: 600.0,
            seed: 1,
            serial: 1,
            key: [0; 32],
            calibrate_obstacle: None,
            commit_obstacle: None,
            noisy_line: false,
            flash: None,
        }
    }
}

/// Why there is no such device.
#[derive(Debug, Error)]
pub enum PretendError {
    /// Its encoder or drive.
    #[error("{0}")]
    Twin(#[from] TwinError),
    /// Its encoder's lines.
    #[error("the core takes no encoder of so many lines ({0:?}); give fewer")]
    Shape(ShapeError),
    /// The same.
    #[error("the core takes no encoder of so many lines ({0:?}); give fewer")]
    Sensor(SensorError),
    /// Its flash's places.
    #[error("the flash can't be laid out ({0:?})")]
    Layout(LayoutError),
    /// Its flash can't be read.
    #[error("the flash can't be read ({0:?})")]
    Begin(Refusal),
    /// The file with its flash.
    #[error("{path}: cannot be read or written ({source}); check the path and its permissions", path = path.display())]
    Flash {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
}

/// A pretend device that runs.
pub struct Running {
    device: Device<Flash, Drawn, Switches>,
    bench: Workbench<'static, EstimatorLearner<HeapMemory, Box<Solver>>, Flash>,
    decoder: QuadratureDecoder,
    edges: Option<Peekable<Simulation>>,
    flash: Flash,
    file: Option<PathBuf>,
    started: Instant,
    noisy_line: bool,
    replies: u32,
}

impl Pretend {
    /// Switches it on.
    ///
    /// # Errors
    /// [`PretendError`].
    pub fn start(&self) -> Result<Running, PretendError> {
        let shape =
            EncoderShape::new(self.lines.saturating_mul(4), 4).map_err(PretendError::Shape)?;
        let decoder = QuadratureDecoder::new(DecoderConfig::new(self.lines));
        let decoder = decoder.map_err(PretendError::Sensor)?;
        let edges = match self.r_min {
            0.0 => None,
            _ => Some(Simulation::new(&self.twin())?.peekable()),
        };
        let flash = Flash::load(shape, self.file())?;
        let config = DeviceConfig {
            firmware: [0, 1, 0],
            shape,
            clock_hz: CLOCK_HZ,
            serial: self.serial,
            limits: Limits::default(),
            access: AccessConfig::default(),
            // Nothing wears out here.
            wear: WearConfig {
                burst: 8,
                refill_ms: 1,
            },
        };
        let switches = Switches {
            calibrate: self.calibrate_obstacle,
            commit: self.commit_obstacle,
        };
        let layout = flash.layout().map_err(PretendError::Layout)?;
        let store = Store::new(flash.clone(), layout);
        let mut device = Device::new(config, self.key, store, Drawn, switches, 0);
        let workbench = WorkbenchConfig {
            shape,
            clock_hz: CLOCK_HZ,
            still: CLOCK_HZ,
        };
        let learner = EstimatorLearner::new(shape, CLOCK_HZ, HeapMemory(shape), Box::default());
        let mut bench = Workbench::new(workbench, learner, flash.clone());
        device.begin(&mut bench).map_err(PretendError::Begin)?;
        Ok(Running {
            device,
            bench,
            decoder,
            edges,
            flash,
            file: self.flash.clone(),
            started: Instant::now(),
            noisy_line: self.noisy_line,
            replies: 0,
        })
    }

    /// The rig whose edges it sees: the paper's, with errors in proportion to a line.
    #[must_use]
    pub fn twin(&self) -> Twin {
        rig::twin(self)
    }

    fn file(&self) -> Option<&std::path::Path> {
        self.flash.as_deref()
    }
}

impl Running {
    /// Lets the shaft turn as far as time has gone on, and does one piece of work; while a table is solved for, slices for 10 ms, as
    /// the wait at the port in between would be most of the time.
    ///
    /// # Errors
    /// [`PretendError::Flash`] when the flash's file can't be written.
    pub fn step(&mut self) -> Result<(), PretendError> {
        let mut now = self.ticks();
        for _ in 0..BURST {
            let due = self
                .edges
                .as_mut()
                .and_then(|edges| edges.next_if(|event| event.row.ticks <= now));
            let Some(event) = due else {
                break;
            };
            self.bench.push(&self.decoder.push(event.row));
        }
        // Where the computer is too slow, time goes on as far as there are edges.
        if let Some(next) = self.edges.as_mut().and_then(Peekable::peek) {
            now = now.min(next.row.ticks);
        }
        let faults: Faults = *self.decoder.faults();
        self.bench.note(now, &faults);
        let begun = Instant::now();
        self.device.poll(self.now_ms(), &mut self.bench);
        while self.device.stage() == Stage::Solving && begun.elapsed() < SOLVING {
            self.device.poll(self.now_ms(), &mut self.bench);
        }
        self.flash.save(self.file.as_deref())
    }

    /// What keeps it from committing from now on.
    pub const fn hold_commits_back(&mut self, obstacle: Option<Obstacle>) {
        self.device.interlock().commit = obstacle;
    }

    /// Takes bytes from the port and gives what is to be sent.
    pub fn receive(&mut self, bytes: &[u8]) -> Vec<u8> {
        let now_ms = self.now_ms();
        let mut sent = Vec::new();
        for byte in bytes {
            if let Some(reply) = self.device.receive(*byte, now_ms, &mut self.bench) {
                self.send(&reply, &mut sent);
            }
        }
        sent
    }

    /// A reply as the line passes it on.
    fn send(&mut self, reply: &WireBytes, sent: &mut Vec<u8>) {
        self.replies = self.replies.wrapping_add(1);
        if self.noisy_line {
            // A frame cut off, then bytes of no frame at all.
            sent.extend_from_slice(&reply[..reply.len() / 2]);
            sent.extend_from_slice(&[0, 0x55, 0xFF, 3, 0x80]);
            if self.replies.is_multiple_of(4) {
                return;
            }
        }
        sent.extend_from_slice(reply);
    }

    /// Ticks since the start.
    #[allow(clippy::cast_possible_truncation)]
    fn ticks(&self) -> u64 {
        (self.started.elapsed().as_nanos() * u128::from(CLOCK_HZ) / 1_000_000_000) as u64
    }

    #[allow(clippy::cast_possible_truncation)]
    fn now_ms(&self) -> u64 {
        self.started.elapsed().as_millis() as u64
    }
}

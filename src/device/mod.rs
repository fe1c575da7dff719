//! A drive's calibration service: frames come in and go out, the encoder is learned again by command, and tables are kept in flash.
//!
//! ```text
//!   port --byte--> Device::receive --reply--> port         edges --> Workbench::push --> corrected edges
//!                     |  wire: is it a frame?                             ^      |
//!                     |  access: may it change anything?                  |      +--> Learner, Proof
//!                     |  recalibrate: does it fit the stage?              |
//!   main loop -> Device::poll --one piece of work-------------------------+ Bench
//!                     |
//!                     +--> store: two places in flash
//! ```
//!
//! Both calls belong to the main loop, and each is bounded: a poll looks at the shaft, does a slice of solving, or writes the table.
//! Those that write flash take long: the poll after a command to commit, and the call of receive or serve that takes a command to roll
//! back (one mark) or to erase (both places), which reply afterwards so that the reply says how it went. On chips that execute from the
//! flash they write, that halts everything, an STM32F405 for up to 1.1 s a sector; the [`Interlock`] is asked right before whether it
//! may be. Edges are the workbench's and go on all the while: the table in use
//! corrects them until [`Bench::adopt`] exchanges it.
//!
//! # Who calls what
//!
//! The capture interrupt reads the timer and the levels and puts the sample into a queue, nothing else; it may break into everything.
//! All the rest is the main loop's, so nothing is shared but the queue. Between two looks into it lies one call of
//! [`Device::serve`] and one of [`Device::poll`]: a slice of solving takes fewer than 20,000 instructions of a Cortex-M4, 120 us at 168
//! MHz. To prepare for learning takes about twice as long, once (`docs/cost.md`). The queue holds the edges of that time at the highest
//! speed to learn at. A control loop in an interrupt of its own gets what [`Workbench::push`] hands out by way of a cell. Solving takes some 2,500 slices; a main loop that comes round once a
//! millisecond is done in 3 s, with numbers of edges that have no small divisors in up to a minute.
//!
//! ```no_run
//! use core::convert::Infallible;
//!
//! use embedded_storage::nor_flash::NorFlash;
//! use heapless::spsc::Consumer;
//! use quadcal::access::Nonces;
//! use quadcal::corrector::CorrectedEdge;
//! use quadcal::decoder::QuadratureDecoder;
//! use quadcal::device::{Device, Learner, MappedFlash, Workbench};
//! use quadcal::edge::Sample;
//! use quadcal::recalibrate::Interlock;
//!
//! /// The interrupt has the queue's other end: `producer.enqueue(Sample { ticks, levels })`.
//! fn main_loop<'f, F, N, I, L, M, P>(
//!     device: &mut Device<F, N, I>,
//!     bench: &mut Workbench<'f, L, M>,
//!     decoder: &mut QuadratureDecoder,
//!     edges: &mut Consumer<'_, Sample>,
//!     port: &mut P,
//!     now_ms: impl Fn() -> u64,
//!     hand_on: impl Fn(CorrectedEdge),
//! ) -> Result<Infallible, P::Error>
//! where
//!     F: NorFlash,
//!     N: Nonces,
//!     I: Interlock,
//!     L: Learner,
//!     M: MappedFlash<'f>,
//!     P: embedded_io::Read + embedded_io::ReadReady + embedded_io::Write,
//! {
//!     loop {
//!         while let Some(sample) = edges.dequeue() {
//!             if let Some(edge) = bench.push(&decoder.push(sample)) {
//!                 hand_on(edge);
//!             }
//!             bench.note(sample.ticks, decoder.faults());
//!         }
//!         device.serve(port, now_ms(), bench)?;
//!         device.poll(now_ms(), bench);
//!     }
//! }
//! ```
//!
//! Beside the buffers of [`StaticBuffers`](crate::estimate::StaticBuffers) it takes a [`Solver`](crate::estimate::Solver), 11 KiB, best
//! as a `static`, and what `Device` and `Workbench` are. What may wait long: a commit, a roll back and an erasure, for as long as the
//! flash does (a place of the STM32F405: 1.1 s), in which a chip that runs from that flash serves no interrupt either. So the
//! [`Interlock`] allows them at standstill only.

mod bench;
mod learner;
mod memory;
mod pace;
mod proof;
mod service;
mod tables;
mod trial;
mod upload;
mod work;
mod workbench;

#[cfg(test)]
mod tests;

pub use bench::{Bench, Learner, Learning};
pub use learner::EstimatorLearner;
pub use memory::{LearnerMemory, Lent, Shelf};
pub use proof::{Corrected, GAIN_LEAST, Proof};
pub use workbench::{MappedFlash, Workbench, WorkbenchConfig};

use embedded_io::{Read, ReadReady, Write};
use embedded_storage::nor_flash::NorFlash;

use crate::access::{Access, AccessConfig, Key, Nonces};
use crate::recalibrate::{Interlock, Limits, Machine, Stage, WearBudget, WearConfig};
use crate::shape::EncoderShape;
use crate::store::{Found, Store};
use crate::wire::{
    FrameError, Kind, LogLevel, Parser, Refusal, Reply, VERSION, WireBytes, reply_frame,
};
use service::Service;

/// Bytes that [`Device::serve`] takes in one call.
pub const SERVED_BYTES: usize = 64;

/// What a device is told once.
#[derive(Clone, Copy, Debug)]
pub struct DeviceConfig {
    /// Version of the firmware: major, minor, patch.
    pub firmware: [u8; 3],
    /// The encoder's shape.
    pub shape: EncoderShape,
    /// Ticks a second.
    pub clock_hz: u64,
    /// Serial number of the encoder, 0: not given. A table of another one is refused.
    pub serial: u64,
    /// How long a calibration waits, and at which speeds it learns.
    pub limits: Limits,
    /// How sessions end.
    pub access: AccessConfig,
    /// How often flash is erased.
    pub wear: WearConfig,
}

/// The service; see the module's head. Times are milliseconds of a clock that does not go back.
pub struct Device<F, N, I> {
    parser: Parser,
    service: Service<F, N, I>,
}

impl<F: NorFlash, N: Nonces, I: Interlock> Device<F, N, I> {
    /// A device that has just started; what it corrects with comes with [`Self::begin`].
    pub fn new(
        config: DeviceConfig,
        key: Key,
        store: Store<F>,
        nonces: N,
        interlock: I,
        now_ms: u64,
    ) -> Self {
        let wear = WearBudget::new(config.wear, store.erasures_max(), now_ms);
        Self {
            parser: Parser::new(),
            service: Service {
                config,
                store,
                nonces,
                interlock,
                access: Access::new(config.access, key),
                machine: Machine::new(config.limits),
                wear,
                upload: None,
                loaded: None,
                due: None,
                in_use: None,
                learned: None,
                preview: None,
                turns: 0,
                rejected: 0,
                solved_percent: 0,
                log_level: LogLevel::default(),
                bad_frames: 0,
                started_ms: now_ms,
            },
        }
    }

    /// Corrects with the newest table in flash from now on; none where there is none, and then the encoder runs uncorrected.
    ///
    /// # Errors
    /// [`Refusal::Flash`] when it can't be read.
    pub fn begin(&mut self, bench: &mut impl Bench) -> Result<Option<Found>, Refusal> {
        self.service.adopt_newest(bench)?;
        Ok(self.service.in_use)
    }

    /// Takes a byte from the port; `Some` when there is something to send.
    pub fn receive(&mut self, byte: u8, now_ms: u64, bench: &mut impl Bench) -> Option<WireBytes> {
        let service = &mut self.service;
        let (number, reply) = match self.parser.push(byte)? {
            Ok(frame) if frame.kind == Kind::Reply => return None,
            Ok(frame) => (frame.number, service.answer(&frame, now_ms, bench)),
            Err(error) => {
                service.bad_frames = service.bad_frames.saturating_add(1);
                let FrameError::Version { number, .. } = error else {
                    return None;
                };
                (number, Reply::Refused(Refusal::Version(VERSION)))
            }
        };
        Some(reply_frame(number, &reply))
    }

    /// Takes what has come in at a port, at most [`SERVED_BYTES`] bytes, and sends what there is to send. Reading never waits; writing
    /// may, until the port has taken a frame.
    ///
    /// # Errors
    /// The port's.
    pub fn serve<P: Read + ReadReady + Write>(
        &mut self,
        port: &mut P,
        now_ms: u64,
        bench: &mut impl Bench,
    ) -> Result<(), P::Error> {
        for _ in 0..SERVED_BYTES {
            let mut byte = [0];
            if !port.read_ready()? || port.read(&mut byte)? == 0 {
                break;
            }
            if let Some(reply) = self.receive(byte[0], now_ms, bench) {
                port.write_all(&reply)?;
                port.flush()?;
            }
        }
        Ok(())
    }

    /// Does one piece of work; to be called over and over from the main loop.
    pub fn poll(&mut self, now_ms: u64, bench: &mut impl Bench) {
        self.service.poll(now_ms, bench);
    }

    /// Where the calibration stands.
    pub const fn stage(&self) -> Stage {
        self.service.machine.stage()
    }

    /// The table that is corrected with.
    pub const fn in_use(&self) -> Option<&Found> {
        self.service.in_use.as_ref()
    }

    /// How much is to be logged.
    pub const fn log_level(&self) -> LogLevel {
        self.service.log_level
    }

    /// What the firmware allows, to be told of changes.
    pub const fn interlock(&mut self) -> &mut I {
        &mut self.service.interlock
    }

    /// Gives the flash back.
    pub fn into_flash(self) -> F {
        self.service.store.into_flash()
    }
}

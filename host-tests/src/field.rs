//! A drive in the field: the simulated rig's edges go through the device's own edge path, and a host at its port gives commands.

use std::cell::{Cell, RefCell};
use std::f64::consts::TAU;
use std::rc::Rc;

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use quadcal::access::{AccessConfig, Key, KeyHolder, Nonces};
use quadcal::decoder::{DecoderConfig, QuadratureDecoder};
use quadcal::device::{
    Device, DeviceConfig, EstimatorLearner, MappedFlash, Workbench, WorkbenchConfig,
};
use quadcal::edge::Sample;
use quadcal::estimate::Solver;
use quadcal::recalibrate::{Interlock, Limits, Obstacle, WearConfig};
use quadcal::shape::EncoderShape;
use quadcal::step::Flags;
use quadcal::store::{Layout, Store};
use quadcal::wire::{Draft, Kind, Nonce, Parser, Reply, Request, WireBytes, request_frame};
use quadcal_host::buffers::HeapMemory;
use quadcal_host::sim::Event;

use crate::fuzz_device::flash::Fault;

/// The key of every drive here.
pub const KEY: Key = [42; 32];

/// Timer clock of the rig, hertz.
pub const CLOCK_HZ: u64 = 84_000_000;

/// Bytes of either place: two sectors of a STM32F405.
const PLACE: u32 = 32_768;

/// Flash that outlives the drive.
#[derive(Clone, Debug)]
pub struct Flash(Rc<RefCell<Vec<u8>>>);

impl Default for Flash {
    fn default() -> Self {
        Self(Rc::new(RefCell::new(vec![0xFF; 2 * PLACE as usize])))
    }
}

impl Flash {
    fn change(&self, from: usize, to: usize, change: impl FnOnce(&mut [u8])) -> Result<(), Fault> {
        let mut bytes = self.0.borrow_mut();
        change(bytes.get_mut(from..to).ok_or(Fault::Misplaced)?);
        Ok(())
    }
}

impl ErrorType for Flash {
    type Error = Fault;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Fault> {
        let from = offset as usize;
        self.change(from, from + bytes.len(), |cells| {
            bytes.copy_from_slice(cells)
        })
    }

    fn capacity(&self) -> usize {
        self.0.borrow().len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 16_384;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Fault> {
        self.change(from as usize, to as usize, |cells| cells.fill(0xFF))
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Fault> {
        let from = offset as usize;
        self.change(from, from + bytes.len(), |cells| {
            cells
                .iter_mut()
                .zip(bytes)
                .for_each(|(cell, byte)| *cell &= byte);
        })
    }
}

impl MappedFlash<'static> for Flash {
    /// A copy for good: a few a test.
    fn bytes(&self, offset: u32) -> Option<&'static [u8]> {
        let copy = self.0.borrow().get(offset as usize..)?.to_vec();
        Some(Box::leak(copy.into_boxed_slice()))
    }
}

/// Allows everything.
#[derive(Debug)]
pub struct Allowed;

impl Interlock for Allowed {
    fn may_calibrate(&self) -> Result<(), Obstacle> {
        Ok(())
    }

    fn may_commit(&self) -> Result<(), Obstacle> {
        Ok(())
    }
}

/// Nonces that count up: this is a test.
#[derive(Debug, Default)]
pub struct Counting(Cell<u8>);

impl Nonces for Counting {
    fn nonce(&mut self) -> Option<Nonce> {
        self.0.set(self.0.get().wrapping_add(1));
        Some([self.0.get(); 16])
    }
}

/// A drive and the host at its port.
pub struct Field {
    /// The drive's service.
    pub device: Device<Flash, Counting, Allowed>,
    bench: Workbench<'static, EstimatorLearner<HeapMemory, Box<Solver>>, Flash>,
    decoder: QuadratureDecoder,
    now_ms: u64,
    number: u16,
    holder: Option<KeyHolder>,
}

impl Field {
    /// A drive that has just started with an encoder of so many lines.
    ///
    /// # Panics
    /// Where these can't be.
    #[must_use]
    pub fn new(flash: &Flash, lines: u32) -> Self {
        let shape = EncoderShape::new(4 * lines, 4).expect("a shape");
        let layout = Layout::new(flash, [0..PLACE, PLACE..2 * PLACE], 10_000).expect("two places");
        let config = DeviceConfig {
            firmware: [0, 1, 0],
            shape,
            clock_hz: CLOCK_HZ,
            serial: 1,
            limits: Limits::default(),
            access: AccessConfig::default(),
            wear: WearConfig::default(),
        };
        let store = Store::new(flash.clone(), layout);
        let mut device = Device::new(config, KEY, store, Counting::default(), Allowed, 0);
        let workbench = WorkbenchConfig {
            shape,
            clock_hz: CLOCK_HZ,
            still: CLOCK_HZ,
        };
        let learner = EstimatorLearner::new(shape, CLOCK_HZ, HeapMemory(shape), Box::default());
        let mut bench = Workbench::new(workbench, learner, flash.clone());
        device.begin(&mut bench).expect("flash can be read");
        Self {
            device,
            bench,
            decoder: QuadratureDecoder::new(DecoderConfig::new(lines)).expect("lines"),
            now_ms: 0,
            number: 0,
            holder: None,
        }
    }

    /// Passes one change of level, with the main loop running. How far the corrected angle is off, rad, once it counts from the index.
    pub fn pass(&mut self, event: &Event) -> Option<f64> {
        let sample: Sample = event.row;
        self.now_ms = sample.ticks / (CLOCK_HZ / 1000);
        let outcome = self.decoder.push(sample);
        self.bench.note(sample.ticks, self.decoder.faults());
        let edge = self.bench.push(&outcome);
        self.device.poll(self.now_ms, &mut self.bench);
        let edge = edge.filter(|edge| edge.flags.contains(Flags::REFERENCED))?;
        let angle = f64::from(edge.angle.0) / 4_294_967_296.0 * TAU;
        let off = (angle - event.truth.angle_rad).rem_euclid(TAU);
        Some(if off > TAU / 2.0 { off - TAU } else { off })
    }

    fn send(&mut self, bytes: &WireBytes) -> Reply {
        let mut parser = Parser::new();
        let mut reply = None;
        for byte in bytes {
            let answer = self.device.receive(*byte, self.now_ms, &mut self.bench);
            for byte in answer.into_iter().flatten() {
                if let Some(Ok(frame)) = parser.push(byte) {
                    reply = frame.read();
                }
            }
        }
        reply.expect("a reply")
    }

    /// A request that is open to all.
    ///
    /// # Panics
    /// Where no reply comes.
    pub fn ask(&mut self, request: &Request) -> Reply {
        self.number += 1;
        self.send(&request_frame(self.number, request))
    }

    /// A sealed request, in a session that is opened for the first.
    ///
    /// # Panics
    /// Where no session opens or no reply comes.
    pub fn demand(&mut self, request: &Request) -> Reply {
        if self.holder.is_none() {
            let Reply::Challenge { nonce } = self.ask(&Request::Challenge) else {
                panic!("no challenge")
            };
            let holder = KeyHolder::new(KEY, nonce);
            let proof = holder.proof();
            let opened = self.ask(&Request::Open { proof });
            assert!(matches!(opened, Reply::Opened { .. }), "{opened:?}");
            self.holder = Some(holder);
        }
        self.number += 1;
        let draft = Draft::new(Kind::Sealed, self.number, request).expect("it fits");
        let holder = self.holder.as_mut().expect("a session");
        let seal = holder.seal(draft.signed());
        self.send(&draft.finish(Some(seal)))
    }
}

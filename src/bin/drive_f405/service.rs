//! The main loop's part: calibration by command over USART1. Events come from the control loop by a queue; a table that is adopted goes to its
//! encoder as well.
//!
//! What is not for products: the key is known to everyone.

use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::interrupt;
use quadcal::access::{AccessConfig, Key};
use quadcal::capture::{Event, Loss};
use quadcal::decoder::{DecoderConfig, QuadratureDecoder};
use quadcal::device::{
    Bench, Device, DeviceConfig, EstimatorLearner, Learner, Learning, MappedFlash, Shelf,
    Workbench, WorkbenchConfig,
};
use quadcal::estimate::{Advice, Solver, StaticBuffers};
use quadcal::recalibrate::{
    Action, Figures, Interlock, Limits, Obstacle, SolveInSlices, Solving, WearConfig,
};
use quadcal::shape::EncoderShape;
use quadcal::slot::{Slot, SlotHeader};
use quadcal::stm32f405::Flash;
use quadcal::store::{Found, Layout, Store};
use quadcal::table::ErrorTable;
use quadcal::units::Ticks;
use quadcal::wire::Live;

use crate::board::Noise;
use crate::interface::{FlashInterface, MappedSlots};
use crate::port::Port;
use crate::{CLOCK_HZ, DRIVE, LINES};

/// The key of every such drive.
const KEY: Key = [0; 32];

/// Serial number of the encoder.
const SERIAL: u64 = 405;

/// Memory to learn in.
pub type Buffers = StaticBuffers<{ LINES as usize }, 4, 1000>;

/// Whether the shaft turns.
pub static TURNS: AtomicBool = AtomicBool::new(false);

/// Flash halts the processor for a second: at a standstill alone.
struct AtRest;

impl Interlock for AtRest {
    fn may_calibrate(&self) -> Result<(), Obstacle> {
        Ok(())
    }

    fn may_commit(&self) -> Result<(), Obstacle> {
        if TURNS.load(Ordering::Relaxed) {
            Err(Obstacle::Moving)
        } else {
            Ok(())
        }
    }
}

/// A workbench whose table the control loop's encoder uses too.
struct Shared<B> {
    bench: B,
    slots: MappedSlots,
}

impl<B> Shared<B> {
    fn table(&self, found: &Found) -> Option<ErrorTable<'static, [u8; 2]>> {
        let slot = Slot::parse(self.slots.bytes(found.offset)?).ok()?;
        slot.table_at(CLOCK_HZ.into()).ok()
    }
}

impl<B: SolveInSlices> SolveInSlices for Shared<B> {
    fn slice(&mut self) -> Solving {
        self.bench.slice()
    }
}

impl<B: Bench> Bench for Shared<B> {
    fn perform(&mut self, action: &Action) {
        self.bench.perform(action);
    }

    fn live(&mut self) -> Live {
        self.bench.live()
    }

    fn speed(&mut self) -> u32 {
        self.bench.speed()
    }

    fn learning(&mut self) -> Learning {
        self.bench.learning()
    }

    fn advice(&mut self) -> Option<Advice> {
        self.bench.advice()
    }

    fn figures(&mut self) -> Figures {
        self.bench.figures()
    }

    fn candidate(&self) -> Option<(SlotHeader, &[i16])> {
        self.bench.candidate()
    }

    fn room(&mut self) -> Option<&mut [i16]> {
        self.bench.room()
    }

    fn compare(&mut self, header: &SlotHeader) {
        self.bench.compare(header);
    }

    /// The encoder gives the old table up together with the workbench, before its place may be written.
    fn adopt(&mut self, found: Option<&Found>) -> bool {
        let adopted = self.bench.adopt(found);
        let table = found
            .filter(|_| adopted)
            .and_then(|found| self.table(found));
        interrupt::free(|cs| {
            if let Some(drive) = DRIVE.borrow(cs).borrow_mut().as_mut() {
                // The old table is given up in any case. None is never refused.
                if drive.encoder.set_table(table).is_err() {
                    let _ = drive.encoder.set_table(None);
                }
            }
        });
        adopted
    }
}

/// Serves the port and learns, for good. `round` is called between two pieces of work.
pub fn serve(
    (flash, layout): (Flash<FlashInterface>, Layout),
    port: &mut Port,
    buffers: &mut Buffers,
    solver: &mut Solver,
    mut round: impl FnMut(),
) -> Result<(), &'static str> {
    let shape = EncoderShape::new(4 * LINES, 4).map_err(|_| "the encoder is out of range")?;
    let mut decoder = QuadratureDecoder::new(DecoderConfig::new(LINES))
        .map_err(|_| "the encoder is out of range")?;
    let config = DeviceConfig {
        firmware: [0, 1, 0],
        shape,
        clock_hz: CLOCK_HZ.into(),
        serial: SERIAL,
        limits: Limits::default(),
        access: AccessConfig::default(),
        wear: WearConfig::default(),
    };
    let store = Store::new(flash, layout);
    let mut device = Device::new(config, KEY, store, Noise, AtRest, 0);
    let shelf = Shelf::new(buffers);
    let workbench = WorkbenchConfig {
        shape,
        clock_hz: CLOCK_HZ.into(),
        still: CLOCK_HZ.into(),
    };
    let learner = EstimatorLearner::new(shape, CLOCK_HZ.into(), &shelf, solver);
    // SAFETY: of the device's own layout. Workbench and encoder use what was handed out until the device has them adopt another, which it
    // does before it writes there.
    let slots = || unsafe { MappedSlots::new(layout) };
    let mut bench = Shared {
        bench: Workbench::new(workbench, learner, slots()),
        slots: slots(),
    };
    device
        .begin(&mut bench)
        .map_err(|_| "the flash can't be used")?;
    loop {
        let now_ms = take_events(&mut decoder, &mut bench.bench) / u64::from(CLOCK_HZ / 1000);
        let Ok(()) = device.serve(port, now_ms, &mut bench);
        device.poll(now_ms, &mut bench);
        round();
    }
}

/// Hands on what the control loop has queued, and the time, which it returns.
fn take_events(
    decoder: &mut QuadratureDecoder,
    bench: &mut Workbench<'static, impl Learner, MappedSlots>,
) -> Ticks {
    let next = || {
        interrupt::free(|cs| {
            let mut drive = DRIVE.borrow(cs).borrow_mut();
            drive.as_mut()?.events.pop_front()
        })
    };
    while let Some(event) = next() {
        match event {
            Event::Change(sample) => {
                bench.push(&decoder.push(sample));
            }
            Event::Missed(_) => decoder.missed(),
        }
    }
    let now = interrupt::free(|cs| {
        let mut drive = DRIVE.borrow(cs).borrow_mut();
        drive.as_mut().map(|drive| drive.captures.now())
    });
    let now = now.unwrap_or_default();
    bench.note(now, decoder.faults());
    now
}

/// What the queue says where it was full.
pub const FULL: Event = Event::Missed(Loss::Overrun);

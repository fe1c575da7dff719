//! A drive with a badly made encoder, its flash, and a learner that knows the truth.

use super::*;
use crate::access::KeyHolder;
use crate::estimate::{Advice, DriveKnowledge, Goal};
use crate::recalibrate::{SolveInSlices, Solving};
use crate::shape::CLASSES_MAX;
use crate::slot::{Delays, SlotHeader, Stamp};
use crate::step::{Faults, Flags, Outcome, Step};
use crate::store::tests::flash::{Fault, Flash};
use crate::units::TurnDelta32;
use embedded_storage::nor_flash::{ErrorType, ReadNorFlash};
use std::boxed::Box;
use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::vec::Vec;

pub const EDGES: u32 = 240;
pub const KEY: Key = [3; 32];
pub const CLOCK_HZ: u64 = 1_000_000;

/// Flash that outlives the device.
#[derive(Clone)]
pub struct Shared(pub Rc<RefCell<Flash<4, 1024>>>);

impl ErrorType for Shared {
    type Error = Fault;
}

impl ReadNorFlash for Shared {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Fault> {
        self.0.borrow_mut().read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.0.borrow().capacity()
    }
}

impl NorFlash for Shared {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 1024;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Fault> {
        self.0.borrow_mut().erase(from, to)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Fault> {
        self.0.borrow_mut().write(offset, bytes)
    }
}

impl MappedFlash<'static> for Shared {
    fn bytes(&self, offset: u32) -> Option<&'static [u8]> {
        let copy = self.0.borrow().bytes.get(offset as usize..)?.to_vec();
        Some(Box::leak(copy.into_boxed_slice()))
    }
}

/// Counts turns, takes a few slices, and then has the table that it was made with.
pub struct Knows {
    pub table: Vec<i16>,
    room: Vec<i16>,
    turns: u32,
    slices: u8,
    solved: bool,
}

impl Knows {
    pub fn new(table: Vec<i16>) -> Self {
        Self {
            room: std::vec![0; table.len()],
            table,
            turns: 0,
            slices: 0,
            solved: false,
        }
    }
}

impl SolveInSlices for Knows {
    fn slice(&mut self) -> Solving {
        if self.turns < 2 {
            return Solving::TooFewTurns(self.turns);
        }
        self.slices = (self.slices + 1).min(5);
        if self.slices < 5 {
            return Solving::Working(20 * self.slices);
        }
        self.room.copy_from_slice(&self.table);
        self.solved = true;
        Solving::Solved
    }
}

impl Learner for Knows {
    fn prepare(&mut self, _: DriveKnowledge, _: Goal) {
        self.release();
    }

    fn push(&mut self, outcome: &Outcome) {
        if let Outcome::Step(step) = outcome {
            self.turns += u32::from(step.edge == 0);
        }
    }

    fn interrupt(&mut self) {}

    fn learning(&mut self) -> Learning {
        Learning {
            turns: self.turns,
            rejected: 1,
        }
    }

    fn advice(&mut self) -> Option<Advice> {
        None
    }

    fn header(&self) -> Option<SlotHeader> {
        self.solved.then(|| SlotHeader {
            shape: shape(),
            shift: 8,
            turns: self.turns,
            indexed: true,
            standard_error: 3,
            class_standard_error: 1,
            source: 0,
            learned_until: 0,
            class_offsets: [TurnDelta32(0); CLASSES_MAX],
            delays: Delays::NONE,
            stamp: Stamp::default(),
        })
    }

    fn entries(&self) -> &[i16] {
        &self.room
    }

    fn room(&mut self) -> Option<&mut [i16]> {
        self.solved = false;
        Some(&mut self.room)
    }

    fn release(&mut self) {
        (self.turns, self.slices, self.solved) = (0, 0, false);
    }
}

/// What the machine around the drive allows.
#[derive(Clone, Default)]
pub struct Switches {
    pub calibrate: Rc<Cell<Option<Obstacle>>>,
    pub commit: Rc<Cell<Option<Obstacle>>>,
}

impl Interlock for Switches {
    fn may_calibrate(&self) -> Result<(), Obstacle> {
        self.calibrate.get().map_or(Ok(()), Err)
    }

    fn may_commit(&self) -> Result<(), Obstacle> {
        self.commit.get().map_or(Ok(()), Err)
    }
}

/// Nonces that count up.
pub struct Counting(u8);

impl Nonces for Counting {
    fn nonce(&mut self) -> Option<[u8; 16]> {
        self.0 = self.0.wrapping_add(1);
        Some([self.0; 16])
    }
}

pub fn shape() -> EncoderShape {
    EncoderShape::new(EDGES, 4).unwrap()
}

/// A disc's errors in 2^-24 turn, up to a third of a step.
pub fn disc(seed: u32) -> Vec<i16> {
    let error = |k: u32| ((k.wrapping_add(seed).wrapping_mul(2_654_435_769)) >> 16) as i16 / 2;
    (0..EDGES).map(error).collect()
}

/// A drive from its start to its end, and the host at its port.
pub struct Drive {
    pub device: Device<Shared, Counting, Switches>,
    pub bench: Workbench<'static, Knows, Shared>,
    pub flash: Shared,
    pub switches: Switches,
    pub now_ms: u64,
    disc: Vec<i16>,
    edge: u64,
    ticks: u64,
    /// Ticks that the shaft has stood still.
    rested: u64,
    number: u16,
    holder: Option<KeyHolder>,
}

impl Drive {
    pub fn new(flash: &Shared, disc: &[i16], learns: Vec<i16>) -> Self {
        let layout = crate::store::Layout::new(flash, [1024..3072, 3072..5120], 10_000).unwrap();
        let config = DeviceConfig {
            firmware: [1, 2, 3],
            shape: shape(),
            clock_hz: CLOCK_HZ,
            serial: 77,
            limits: Limits::default(),
            access: AccessConfig::default(),
            wear: WearConfig::default(),
        };
        let switches = Switches::default();
        let store = Store::new(flash.clone(), layout);
        let mut device = Device::new(config, KEY, store, Counting(0), switches.clone(), 0);
        let workbench = WorkbenchConfig {
            shape: shape(),
            clock_hz: CLOCK_HZ,
            still: CLOCK_HZ / 2,
        };
        let mut bench = Workbench::new(workbench, Knows::new(learns), flash.clone());
        device.begin(&mut bench).unwrap();
        Self {
            device,
            bench,
            flash: flash.clone(),
            switches,
            now_ms: 0,
            disc: disc.to_vec(),
            edge: 0,
            ticks: 0,
            rested: 0,
            number: 0,
            holder: None,
        }
    }

    /// Flash that nothing was written to.
    pub fn flash() -> Shared {
        Shared(Rc::new(RefCell::new(Flash::new(5))))
    }

    /// Passes an edge: a turn takes 0.1 s. How far its corrected angle is off, 2^-32 turn.
    pub fn edge(&mut self) -> i32 {
        let edge = (self.edge % u64::from(EDGES)) as u32;
        let error = f64::from(self.disc[edge as usize]) / f64::from(1 << 24);
        let angle = self.edge as f64 / f64::from(EDGES) - error;
        let ticks = (angle * 1e5).round() as u64 + 10_000 + self.rested;
        let step = Step {
            ticks,
            edge,
            position: edge,
            interval: u32::try_from(ticks - self.ticks).unwrap_or(u32::MAX),
            resync: 0,
            advance: 1,
            flags: Flags::REFERENCED,
            direction: Default::default(),
        };
        self.ticks = ticks;
        self.edge += 1;
        self.now_ms = ticks / 1000;
        self.bench.note(ticks, &Faults::new());
        let corrected = self.bench.push(&Outcome::Step(step)).unwrap();
        let truth = (angle.rem_euclid(1.0) * 4_294_967_296.0).round() as u64 as u32;
        corrected.angle.0.wrapping_sub(truth).cast_signed()
    }

    /// Turns the shaft with the main loop running; the largest error of a corrected angle, 2^-32 turn.
    pub fn turn(&mut self, turns: u32) -> u32 {
        let mut largest = 0;
        for _ in 0..turns * EDGES {
            largest = largest.max(self.edge().unsigned_abs());
            self.device.poll(self.now_ms, &mut self.bench);
        }
        largest
    }

    /// The shaft stands still for a while, with the main loop running.
    pub fn rest(&mut self, ms: u64) {
        self.now_ms += ms;
        self.rested += 1000 * ms;
        self.bench.note(self.ticks + 1000 * ms, &Faults::new());
        self.device.poll(self.now_ms, &mut self.bench);
    }

    /// The host opens a session of its own when it next needs one.
    pub fn leave(&mut self) {
        self.holder = None;
    }

    pub fn bytes(&mut self, bytes: &[u8]) -> Option<Reply> {
        let mut parser = Parser::new();
        let mut reply = None;
        for byte in bytes {
            let answer = self.device.receive(*byte, self.now_ms, &mut self.bench);
            for byte in answer.into_iter().flatten() {
                if let Some(frame) = parser.push(byte) {
                    reply = frame.unwrap().read();
                }
            }
        }
        reply
    }

    pub fn ask(&mut self, request: &Request) -> Reply {
        self.number += 1;
        self.bytes(&crate::wire::request_frame(self.number, request))
            .unwrap()
    }

    /// A sealed request, in the session that is opened if there is none.
    pub fn demand(&mut self, request: &Request) -> Reply {
        if self.holder.is_none() {
            let Reply::Challenge { nonce } = self.ask(&Request::Challenge) else {
                panic!("no challenge")
            };
            let holder = KeyHolder::new(KEY, nonce);
            let proof = holder.proof();
            let opened = self.ask(&Request::Open { proof });
            assert!(matches!(opened, Reply::Opened { .. }));
            self.holder = Some(holder);
        }
        let draft = crate::wire::Draft::new(Kind::Sealed, 9, request).unwrap();
        let seal = self.holder.as_mut().unwrap().seal(draft.signed());
        self.bytes(&draft.finish(Some(seal))).unwrap()
    }

    pub fn status(&mut self) -> Status {
        match self.ask(&Request::Status) {
            Reply::Status(status) => status,
            other => panic!("{other:?}"),
        }
    }

    /// Starts a calibration and turns until it waits to be committed or has failed.
    pub fn calibrate(&mut self) -> Stage {
        let options = Options {
            turns: 8,
            date: 1_800_000_000,
            ..Options::default()
        };
        assert_eq!(self.demand(&Request::Start(options)), Reply::Done);
        self.turn(60);
        self.device.stage()
    }
}

//! A drive's calibration service in QEMU: the core's device at the first serial port, edges from a file that grows, tables in a flash
//! that is a file as well. `cargo run --release -p quadcal-host-tests --bin field-trial` starts it with a simulated encoder.
//!
//! Command line: `qemu_device FLASH [EDGES]`. FLASH is made if it is not there; without EDGES the shaft stands still. Runs until QEMU
//! ends. Time is the host's, so QEMU has to run without `-icount`.
//!
//! What is not for products: the key is known to everyone, nonces come from the host's `/dev/urandom`, the interlock allows
//! everything, and flash may be written as often as anyone likes. Writing it holds the edges up; they wait in their file,
//! where a drive would lose them, so a drive commits at standstill.
#![no_std]
#![no_main]

mod edges;
#[path = "../qemu/flash.rs"]
mod file_flash;
mod flash;
#[path = "../qemu/memory.rs"]
mod memory;
#[path = "../qemu/mod.rs"]
mod qemu;
mod supplies;
#[path = "../stm32f405/usart.rs"]
mod usart;

use core::fmt;

use cortex_m::Peripherals;
use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::hprintln;
use quadcal::access::AccessConfig;
use quadcal::decoder::{DecoderConfig, QuadratureDecoder};
use quadcal::device::{
    Device, DeviceConfig, EstimatorLearner, Learner, Shelf, Workbench, WorkbenchConfig,
};
use quadcal::estimate::{Solver, StaticBuffers};
use quadcal::recalibrate::{Limits, Stage, WearConfig};
use quadcal::shape::{EncoderShape, ShapeError};
use quadcal::step::SensorError;
use quadcal::stm32f405::layout;
use quadcal::store::{LayoutError, Store};
use quadcal::wire::{LogLevel, Refusal};

use edges::{Edges, EdgesError};
use flash::{ChipFlash, Mapped};
use qemu::semihost::{self, IoError};
use supplies::{Allowed, HostNonces, KEY, Wake};
use usart::Usart;

/// Lines of the encoder.
const LINES: u32 = 2500;

/// The capture timer's clock, hertz.
const CLOCK_HZ: u32 = 84_000_000;

/// Serial number of the encoder.
const SERIAL: u64 = 405;

/// Why the image ended.
enum Failure {
    Usage,
    Peripherals,
    Io(IoError),
    Edges(EdgesError),
    Shape(ShapeError),
    Sensor(SensorError),
    Layout(LayoutError),
    Flash(Refusal),
}

impl From<IoError> for Failure {
    fn from(error: IoError) -> Self {
        Self::Io(error)
    }
}

impl From<EdgesError> for Failure {
    fn from(error: EdgesError) -> Self {
        Self::Edges(error)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage => f.write_str("usage: qemu_device FLASH [EDGES]"),
            Self::Peripherals => f.write_str("the peripherals are taken"),
            Self::Io(error) => error.fmt(f),
            Self::Edges(error) => write!(f, "edges: {error}"),
            Self::Shape(error) => write!(f, "encoder out of range: {error:?}"),
            Self::Sensor(error) => write!(f, "decoder refused: {error:?}"),
            Self::Layout(error) => write!(f, "no layout: {error:?}"),
            Self::Flash(error) => write!(f, "the flash can't be used: {error:?}"),
        }
    }
}

/// Memory to learn in.
type Buffers = StaticBuffers<{ LINES as usize }, 4, 1000>;

#[entry]
fn main() -> ! {
    // The entry attribute hands these out as unique references: safe, and off the stack.
    static mut BUFFERS: Buffers = StaticBuffers::new();
    static mut SOLVER: Solver = Solver::new();
    static mut LINE: [u8; 256] = [0; 256];
    qemu::finish(run(LINE, BUFFERS, SOLVER))
}

#[exception]
fn SysTick() {
    Wake::tick();
}

/// Says on QEMU's output where the calibration stands, and what memory it took so far.
fn log(level: LogLevel, stage: Stage) {
    if matches!(level, LogLevel::Info | LogLevel::Debug) {
        hprintln!(
            "{:?} stack_bytes={} static_bytes={}",
            stage,
            memory::stack_high_water(),
            memory::static_bytes()
        );
    }
}

/// Passes on what edges have come in; whether there may be more.
fn take_edges(
    edges: Option<&mut Edges>,
    bench: &mut Workbench<'static, impl Learner, Mapped>,
) -> Result<bool, EdgesError> {
    let Some(edges) = edges else {
        return Ok(false);
    };
    let more = edges.take(|outcome| {
        bench.push(outcome);
    })?;
    bench.note(edges.now, edges.decoder.faults());
    Ok(more)
}

/// Never returns but with a failure.
fn run(line: &mut [u8], buffers: &mut Buffers, solver: &mut Solver) -> Result<(), Failure> {
    let mut words = semihost::command_line(line)?
        .split_ascii_whitespace()
        .skip(1);
    let flash_path = words.next().ok_or(Failure::Usage)?;
    let edges_path = words.next();
    if words.next().is_some() {
        return Err(Failure::Usage);
    }
    let peripherals = Peripherals::take().ok_or(Failure::Peripherals)?;

    let shape = EncoderShape::new(4 * LINES, 4).map_err(Failure::Shape)?;
    let decoder = QuadratureDecoder::new(DecoderConfig::new(LINES)).map_err(Failure::Sensor)?;
    let mut edges = match edges_path {
        Some(path) => Some(Edges::open(path, LINES, CLOCK_HZ, decoder)?),
        None => None,
    };
    let (flash, mapped) = ChipFlash::open(flash_path)?;
    let layout = layout(&flash).map_err(Failure::Layout)?;
    let config = DeviceConfig {
        firmware: [0, 1, 0],
        shape,
        clock_hz: CLOCK_HZ.into(),
        serial: SERIAL,
        limits: Limits::default(),
        access: AccessConfig::default(),
        // Nothing wears out here.
        wear: WearConfig {
            burst: 8,
            refill_ms: 1,
        },
    };
    let store = Store::new(flash, layout);
    let mut device = Device::new(config, KEY, store, HostNonces, Allowed, 0);
    let shelf = Shelf::new(buffers);
    let workbench = WorkbenchConfig {
        shape,
        clock_hz: CLOCK_HZ.into(),
        still: CLOCK_HZ.into(),
    };
    let learner = EstimatorLearner::new(shape, CLOCK_HZ.into(), &shelf, solver);
    let mut bench = Workbench::new(workbench, learner, mapped);
    device.begin(&mut bench).map_err(Failure::Flash)?;

    let mut port = Usart::start(peripherals.NVIC);
    let mut wake = Wake::start(peripherals.SYST);
    let mut now_ms = 0;
    let mut more = false;
    let mut stage = device.stage();
    loop {
        if more || wake.ticked() {
            now_ms = semihost::elapsed_ns() / 1_000_000;
            more = take_edges(edges.as_mut(), &mut bench)?;
        }
        let Ok(()) = device.serve(&mut port, now_ms, &mut bench);
        device.poll(now_ms, &mut bench);
        if device.stage() != stage {
            stage = device.stage();
            log(device.log_level(), stage);
        }
        let working = matches!(stage, Stage::Solving | Stage::Committing);
        if !more && !working {
            wake.wait(&mut port);
        }
    }
}

//! An encoder on an RP2040, with Embassy. A, B and Z are GPIO2, 3 and 4. PIO0 captures their edges; an executor in an interrupt runs the
//! control loop; the thread's executor has the rest of the drive, here a lamp that burns while the shaft
//! turns and its angle can be trusted.
#![no_std]
#![no_main]

mod board;

use embassy_executor::{InterruptExecutor, Spawner};
use embassy_rp::gpio::{Level, Output};
use embassy_rp::interrupt;
use embassy_rp::interrupt::{InterruptExt, Priority};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Ticker};
use panic_halt as _;
use quadcal::capture::Captures;
use quadcal::encoder::{Encoder, EncoderConfig};
use quadcal::interval::Speed;
use quadcal::pio_capture::{BITS, CYCLES, PioCapture, Rp2040};
use quadcal::units::Turn32;

use board::PioRegisters;

/// Lines of the encoder, and ticks of the captures in a second.
const LINES: u32 = 2500;
const TICKS_HZ: u64 = 125_000_000 / CYCLES as u64;

/// Rounds of the control loop in a second: so often that no more than 128 changes come in between.
const LOOPS_HZ: u64 = 10_000;

type Source = Captures<PioCapture<PioRegisters, Rp2040>, BITS>;

/// What the rest of the drive learns of the shaft.
struct Seen {
    angle: Option<Turn32>,
    speed: Speed,
    /// Whether the index was seen and no edge was lost since.
    sure: bool,
}

static SEEN: Signal<CriticalSectionRawMutex, Seen> = Signal::new();
static CONTROL: InterruptExecutor = InterruptExecutor::new();

#[interrupt]
unsafe fn SWI_IRQ_1() {
    // SAFETY: called by this interrupt alone, which the executor was started for.
    unsafe { CONTROL.on_interrupt() }
}

/// One round of the control loop.
#[inline(never)]
fn round(captures: &mut Source, encoder: &mut Encoder<'static>) -> Seen {
    captures.drain(|event| {
        encoder.take(event);
    });
    let now = captures.now();
    // A current loop takes these two.
    let (angle, speed) = (encoder.now(now), encoder.speed_at(now));
    let decoder = encoder.decoder();
    let sure = decoder.is_referenced() && !decoder.is_uncertain();
    Seen { angle, speed, sure }
}

/// The control loop. In a drive the interrupt of the motor's PWM would wake it.
#[embassy_executor::task]
async fn control(mut captures: Source, mut encoder: Encoder<'static>) {
    let mut period = Ticker::every(Duration::from_hz(LOOPS_HZ));
    loop {
        period.next().await;
        SEEN.signal(round(&mut captures, &mut encoder));
    }
}

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let p = embassy_rp::init(Default::default());
    let mut lamp = Output::new(p.PIN_25, Level::Low);
    let registers = PioRegisters::new(p.PIO0, p.DMA_CH0, p.DMA_CH1, (p.PIN_2, p.PIN_3, p.PIN_4));
    let Ok(source) = PioCapture::start(registers, 2) else {
        panic!("PIO or DMA do not start");
    };
    // At a standstill after 0.1 s without an edge. A table of another encoder is not used.
    let config = EncoderConfig::new(LINES, TICKS_HZ / 10);
    let Ok(encoder) =
        Encoder::new(config, board::table(TICKS_HZ)).or_else(|_| Encoder::new(config, None))
    else {
        panic!("the encoder is out of range");
    };
    interrupt::SWI_IRQ_1.set_priority(Priority::P1);
    let spawner = CONTROL.start(interrupt::SWI_IRQ_1);
    if let Ok(task) = control(Captures::new(source), encoder) {
        spawner.spawn(task);
    }
    loop {
        let seen = SEEN.wait().await;
        let turns = seen.angle.is_some() && seen.speed.0 != 0;
        lamp.set_level(Level::from(turns && seen.sure));
    }
}

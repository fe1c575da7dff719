//! A drive's encoder on a real STM32F405: `cargo board --bin drive_f405`. Captures A, B and Z on PA0, PA1 and PA2 by TIM2 and DMA, corrects
//! with the table in flash if one of this encoder's shape is there, and logs angle, speed and faults twice a second through RTT. On command
//! over USART1 (PA9 and PA10, 115,200 baud) it learns a new one: `quadcal device recalibrate`.
//!
//! SysTick stands for the control loop: it drains what was captured, asks for angle and speed, and queues the captures for the main loop,
//! which learns from them. No edge interrupts anything. The chip stays on its internal oscillator, 16 MHz; a drive sets its clocks up first
//! and says so in `CLOCK_HZ`.
#![no_std]
#![no_main]

mod board;
#[path = "../stm32f405/capture.rs"]
mod capture;
#[path = "../stm32f405/interface.rs"]
mod interface;
mod port;
mod service;
#[path = "../stm32f405/usart.rs"]
mod usart;

use core::cell::RefCell;
use core::panic::PanicInfo;
use core::sync::atomic::Ordering;

use cortex_m::Peripherals;
use cortex_m::interrupt::{self, Mutex};
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::{entry, exception};
use defmt_rtt as _;
use heapless::Deque;
use quadcal::capture::{Captures, Event};
use quadcal::encoder::{Encoder, EncoderConfig};
use quadcal::estimate::{Solver, StaticBuffers};
use quadcal::interval::Speed;
use quadcal::stm32_capture::{DmaCapture, F405, Filter};
use quadcal::stm32f405::{self, Flash, Supply};

use capture::CaptureRegisters;
use interface::FlashInterface;
use port::Port;
use service::Buffers;
use usart::Usart;

/// Lines of the encoder.
const LINES: u32 = 2500;

/// Clock of core and timer, hertz.
const CLOCK_HZ: u32 = 16_000_000;

/// Drains a second, and those from one log to the next.
const LOOPS_HZ: u32 = 10_000;
const LOOPS_A_LOG: u32 = LOOPS_HZ / 2;

/// Pulses shorter than this are no edges, ticks of `CLOCK_HZ`: 0.5 us.
const FILTER: u32 = 8;

/// Of the port.
const BAUD: u32 = 115_200;

/// Events that may wait while the main loop does a piece of its work, some 3 ms beside the control loop at this clock: reckoned for learning
/// at 150 r/min. A drive at 168 MHz has ten times the speed.
const EVENTS: usize = 96;

/// Bytes of replies that may wait: a frame and more. One is sent each round.
const REPLIES: usize = 224;

/// What is logged.
#[derive(Clone, Copy, Default)]
struct Seen {
    loops: u32,
    /// 2^-32 turn.
    angle: u32,
    speed: Speed,
    referenced: bool,
    uncertain: bool,
    faults: u32,
    missed: u32,
}

struct Drive {
    captures: Captures<DmaCapture<CaptureRegisters, F405>>,
    encoder: Encoder<'static>,
    /// For the main loop, which learns from them.
    events: Deque<Event, EVENTS>,
    /// From the main loop, which has no time to wait for the port.
    replies: Deque<u8, REPLIES>,
    seen: Seen,
}

static DRIVE: Mutex<RefCell<Option<Drive>>> = Mutex::new(RefCell::new(None));

impl Drive {
    /// One round of the control loop.
    fn round(&mut self) {
        let Self {
            captures,
            encoder,
            events,
            replies,
            ..
        } = self;
        usart::send_one(|| replies.pop_front());
        captures.drain(|event| {
            encoder.take(event);
            if events.push_back(event).is_err() {
                // The main loop is told, and goes on from the next one.
                events.clear();
                let _ = events.push_back(service::FULL);
            }
        });
        let now = captures.now();
        // A current loop would use these two.
        let (angle, speed) = (encoder.now(now), encoder.speed_at(now));
        service::TURNS.store(speed != Speed::ZERO, Ordering::Relaxed);
        self.seen = Seen {
            loops: self.seen.loops.wrapping_add(1),
            angle: angle.map_or(0, |angle| angle.0),
            speed,
            referenced: encoder.decoder().is_referenced(),
            uncertain: encoder.decoder().is_uncertain(),
            faults: encoder.faults().total(),
            missed: encoder.faults().missed,
        };
    }
}

#[exception]
fn SysTick() {
    interrupt::free(|cs| {
        if let Ok(mut drive) = DRIVE.borrow(cs).try_borrow_mut()
            && let Some(drive) = drive.as_mut()
        {
            drive.round();
        }
    });
}

#[entry]
fn main() -> ! {
    // The entry attribute hands these out as unique references: safe, and off the stack.
    static mut BUFFERS: Buffers = StaticBuffers::new();
    static mut SOLVER: Solver = Solver::new();
    if let Err(why) = run(BUFFERS, SOLVER) {
        defmt::error!("{=str}", why);
    }
    halt()
}

/// Starts captures and control loop, then serves the port.
fn run(buffers: &mut Buffers, solver: &mut Solver) -> Result<(), &'static str> {
    let peripherals = Peripherals::take().ok_or("the peripherals are taken")?;
    let mut system = peripherals.SYST;
    // At a standstill after 0.1 s without an edge.
    let config = EncoderConfig::new(LINES, u64::from(CLOCK_HZ) / 10);
    let encoder = Encoder::new(config, None).map_err(|_| "the encoder is out of range")?;
    let registers = CaptureRegisters::take().ok_or("the registers are taken")?;
    let source = DmaCapture::start(registers, Filter::of_ticks(FILTER))
        .map_err(|_| "timer or DMA do not start")?;
    let drive = Drive {
        captures: Captures::new(source),
        encoder,
        events: Deque::new(),
        replies: Deque::new(),
        seen: Seen::default(),
    };
    interrupt::free(|cs| DRIVE.borrow(cs).replace(Some(drive)));
    let interface = FlashInterface::take().ok_or("the flash interface is taken")?;
    let flash = Flash::new(interface, interface::room(), Supply::From2V7, CLOCK_HZ);
    let layout = stm32f405::layout(&flash).map_err(|_| "no layout")?;
    board::connect_port(CLOCK_HZ, BAUD);
    board::start_noise();
    let mut port = Port(Usart::start(peripherals.NVIC));
    system.set_clock_source(SystClkSource::Core);
    system.set_reload(CLOCK_HZ / LOOPS_HZ - 1);
    system.clear_current();
    system.enable_interrupt();
    system.enable_counter();
    let mut logged = 0;
    service::serve((flash, layout), &mut port, buffers, solver, || {
        log(&mut logged);
    })
}

/// Says where the shaft is, twice a second.
fn log(logged: &mut u32) {
    let seen = interrupt::free(|cs| {
        let drive = DRIVE.borrow(cs).try_borrow().ok();
        drive.and_then(|drive| drive.as_ref().map(|drive| drive.seen))
    });
    let seen = seen.unwrap_or_default();
    if seen.loops.wrapping_sub(*logged) < LOOPS_A_LOG {
        return;
    }
    *logged = seen.loops;
    let degrees_1000 = (u64::from(seen.angle) * 360_000) >> 32;
    let rpm_1000 = (i128::from(seen.speed.0) * i128::from(CLOCK_HZ) * 60_000) >> 60;
    defmt::info!(
        "angle {=u64} mdeg, speed {=i64} mr/min, index seen {=bool}, in doubt {=bool}, faults {=u32}, of them missed {=u32}",
        degrees_1000,
        rpm_1000 as i64,
        seen.referenced,
        seen.uncertain,
        seen.faults,
        seen.missed
    );
}

fn halt() -> ! {
    loop {
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    interrupt::disable();
    defmt::error!("{}", defmt::Display2Format(info));
    halt()
}

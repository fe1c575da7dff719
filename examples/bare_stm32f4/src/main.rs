//! An encoder on an STM32F405, with bare interrupts. A, B and Z are PA0, PA1 and PA2. TIM2 captures their edges and interrupts at each;
//! levels are told from the captures and held against the pins, which are embedded-hal's. TIM7's interrupt is the control loop.
#![no_std]
#![no_main]

mod board;

use core::cell::RefCell;

use cortex_m_rt::entry;
use critical_section::Mutex;
use embedded_hal::digital::InputPin;
use panic_halt as _;
use quadcal::capture::Channel;
use quadcal::edge::{Levels, Sample};
use quadcal::encoder::{Encoder, EncoderConfig};
use quadcal::pins::EncoderPins;
use quadcal::timebase::Timebase32;
use stm32f4xx_hal::gpio::{Alternate, AnyPin};
use stm32f4xx_hal::pac::{Peripherals, TIM7, interrupt};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;
use stm32f4xx_hal::timer::{CounterHz, Event};

use board::Timer;

/// Lines of the encoder, the timer's clock, and rounds of the control loop in a second.
const LINES: u32 = 2500;
const TICKS_HZ: u64 = 84_000_000;
const LOOPS_HZ: u32 = 10_000;

/// What the two interrupts share. `P` is any chip's pin.
struct Drive<P> {
    timer: Timer,
    period: CounterHz<TIM7>,
    pins: EncoderPins<P, P, P>,
    levels: Levels,
    /// Channels whose pin differed at the last look.
    odd: u8,
    timebase: Timebase32,
    encoder: Encoder<'static>,
}

static DRIVE: Mutex<RefCell<Option<Drive<AnyPin<Alternate<1>>>>>> = Mutex::new(RefCell::new(None));

impl<P: InputPin> Drive<P> {
    /// Serves what was captured, oldest first, then a wrap of the timer.
    fn edges(&mut self) {
        let mut latched =
            [Channel::A, Channel::B, Channel::Z].map(|channel| self.timer.latch(channel));
        // Younger than every latch, and read before the flag that tells of a wrap.
        let counter = self.timer.counter();
        let (wrapped, missed) = self.timer.flags();
        if missed {
            self.encoder.missed();
        }
        let age = |latch: &Option<(Channel, u32)>| latch.map(|(_, raw)| counter.wrapping_sub(raw));
        let mut oldest = || latched.iter_mut().max_by_key(|latch| age(latch))?.take();
        while let Some((channel, raw)) = oldest() {
            self.levels.0 ^= channel.bit();
            let (ticks, levels) = (self.timebase.capture(raw, counter, wrapped), self.levels);
            self.encoder.edge_at(Sample { ticks, levels });
        }
        if wrapped {
            self.timebase.overflow();
        }
        self.check();
    }

    /// Holds the levels against the pins. One difference may be an edge that has not passed the timer's filter yet; two are an edge that
    /// was missed.
    fn check(&mut self) {
        let Ok(pins) = self.pins.levels() else {
            return;
        };
        let differ = pins.0 ^ self.levels.0;
        let wrong = differ & self.odd;
        self.odd = differ & !wrong;
        if wrong != 0 {
            self.levels.0 ^= wrong;
            self.encoder.missed();
        }
    }
}

/// At each edge, and when the timer wraps.
#[interrupt]
fn TIM2() {
    critical_section::with(|section| {
        if let Ok(mut drive) = DRIVE.borrow(section).try_borrow_mut()
            && let Some(drive) = drive.as_mut()
        {
            drive.edges();
        }
    });
}

/// The control loop.
#[interrupt]
fn TIM7() {
    let _seen = critical_section::with(|section| {
        let mut drive = DRIVE.borrow(section).try_borrow_mut().ok()?;
        let drive = drive.as_mut()?;
        drive.period.clear_all_flags();
        // What waits is served first: now is not before an edge then, nor a wrap behind.
        drive.edges();
        let now = drive
            .timebase
            .now(drive.timer.counter(), drive.timer.wrapped());
        // A current loop takes these two.
        Some((drive.encoder.now(now)?, drive.encoder.speed_at(now)))
    });
}

#[entry]
fn main() -> ! {
    if let Some(drive) = start() {
        critical_section::with(|section| DRIVE.borrow(section).replace(Some(drive)));
        board::unmask();
    }
    loop {
        cortex_m::asm::wfi();
    }
}

/// Clocks, pins, timers and the encoder.
fn start() -> Option<Drive<AnyPin<Alternate<1>>>> {
    let device = Peripherals::take()?;
    let mut clocks = device.RCC.freeze(Config::hsi().sysclk(168.MHz()));
    let port = device.GPIOA.split(&mut clocks);
    let a = port.pa0.into_alternate().internal_pull_up(true).erase();
    let b = port.pa1.into_alternate().internal_pull_up(true).erase();
    let z = port.pa2.into_alternate().internal_pull_up(true).erase();
    let mut pins = EncoderPins::new(a, b, z);
    let levels = pins.levels().ok()?;
    let timer = Timer::start(device.TIM2, &mut clocks);
    let mut period = device.TIM7.counter_hz(&mut clocks);
    period.start(LOOPS_HZ.Hz()).ok()?;
    period.listen(Event::Update);
    // At a standstill after 0.1 s without an edge. A table of another encoder is not used.
    let config = EncoderConfig::new(LINES, TICKS_HZ / 10);
    let encoder = Encoder::new(config, board::table(TICKS_HZ));
    let mut encoder = encoder.or_else(|_| Encoder::new(config, None)).ok()?;
    encoder.edge_at(Sample { ticks: 0, levels });
    let timebase = Timebase32::new();
    Some(Drive {
        timer,
        period,
        pins,
        levels,
        odd: 0,
        timebase,
        encoder,
    })
}

//! A drive's encoder on a real STM32F405: `cargo board --bin drive_f405`. Captures A, B and Z on PA0, PA1 and PA2 by TIM2 and DMA, corrects
//! with the table in flash if one of this encoder's shape is there, and logs angle, speed and faults twice a second through RTT.
//!
//! SysTick stands for the control loop: it drains what was captured and asks for angle and speed. No edge interrupts anything. The chip
//! stays on its internal oscillator, 16 MHz; a drive sets its clocks up first and says so in `CLOCK_HZ`.
#![no_std]
#![no_main]

#[path = "../stm32f405/capture.rs"]
mod capture;
#[path = "../stm32f405/interface.rs"]
mod interface;

use core::cell::RefCell;
use core::panic::PanicInfo;

use cortex_m::Peripherals;
use cortex_m::interrupt::{self, Mutex};
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::{entry, exception};
use defmt_rtt as _;
use quadcal::capture::Captures;
use quadcal::device::MappedFlash;
use quadcal::encoder::{Encoder, EncoderConfig};
use quadcal::interval::Speed;
use quadcal::slot::Slot;
use quadcal::stm32_capture::{DmaCapture, F405, Filter};
use quadcal::stm32f405::{self, Flash, Supply};
use quadcal::store::Store;
use quadcal::table::ErrorTable;

use capture::CaptureRegisters;
use interface::{FlashInterface, MappedSlots};

/// Lines of the encoder.
const LINES: u32 = 2500;

/// Clock of core and timer, hertz.
const CLOCK_HZ: u32 = 16_000_000;

/// Drains a second, and those from one log to the next.
const LOOPS_HZ: u32 = 10_000;
const LOOPS_A_LOG: u32 = LOOPS_HZ / 2;

/// Pulses shorter than this are no edges, ticks of `CLOCK_HZ`: 0.5 us.
const FILTER: u32 = 8;

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
    seen: Seen,
}

static DRIVE: Mutex<RefCell<Option<Drive>>> = Mutex::new(RefCell::new(None));

impl Drive {
    /// One round of the control loop.
    fn round(&mut self) {
        let Self {
            captures, encoder, ..
        } = self;
        captures.drain(|event| {
            encoder.take(event);
        });
        let now = captures.now();
        // A current loop would use these two.
        let (angle, speed) = (encoder.now(now), encoder.speed_at(now));
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
    match start() {
        Ok(()) => log(),
        Err(why) => {
            defmt::error!("{=str}", why);
            halt()
        }
    }
}

/// Starts captures and control loop.
fn start() -> Result<(), &'static str> {
    let mut system = Peripherals::take().ok_or("the peripherals are taken")?.SYST;
    let table = table();
    defmt::info!("table in flash: {=bool}", table.is_some());
    // At a standstill after 0.1 s without an edge.
    let config = EncoderConfig::new(LINES, u64::from(CLOCK_HZ) / 10);
    let encoder = match Encoder::new(config, table) {
        Ok(encoder) => encoder,
        Err(_) => Encoder::new(config, None).map_err(|_| "the encoder is out of range")?,
    };
    let registers = CaptureRegisters::take().ok_or("the registers are taken")?;
    let source = DmaCapture::start(registers, Filter::of_ticks(FILTER))
        .map_err(|_| "timer or DMA do not start")?;
    let drive = Drive {
        captures: Captures::new(source),
        encoder,
        seen: Seen::default(),
    };
    interrupt::free(|cs| DRIVE.borrow(cs).replace(Some(drive)));
    system.set_clock_source(SystClkSource::Core);
    system.set_reload(CLOCK_HZ / LOOPS_HZ - 1);
    system.clear_current();
    system.enable_interrupt();
    system.enable_counter();
    Ok(())
}

/// The newest table in flash, where it lies.
fn table() -> Option<ErrorTable<'static, [u8; 2]>> {
    let interface = FlashInterface::take()?;
    let flash = Flash::new(interface, interface::room(), Supply::From2V7, CLOCK_HZ);
    let layout = stm32f405::layout(&flash).ok()?;
    let found = Store::new(flash, layout).newest().ok()??;
    // SAFETY: this image writes and erases nothing.
    let slots = unsafe { MappedSlots::new(layout) };
    Slot::parse(slots.bytes(found.offset)?)
        .ok()?
        .table_at(CLOCK_HZ.into())
        .ok()
}

/// Says where the shaft is, twice a second.
fn log() -> ! {
    let mut logged = 0_u32;
    loop {
        cortex_m::asm::wfi();
        let seen = interrupt::free(|cs| {
            let drive = DRIVE.borrow(cs).try_borrow().ok();
            drive.and_then(|drive| drive.as_ref().map(|drive| drive.seen))
        });
        let seen = seen.unwrap_or_default();
        if seen.loops.wrapping_sub(logged) < LOOPS_A_LOG {
            continue;
        }
        logged = seen.loops;
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

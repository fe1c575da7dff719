//! An encoder on an STM32G431, with RTIC 2. A, B and Z are PA0, PA1 and PA2. TIM2 and DMA capture their edges; TIM7's interrupt is the
//! control loop; the rest of the drive is `idle`. The chip stays on its internal oscillator, 16 MHz.
#![no_std]
#![no_main]

mod board;

use panic_halt as _;

/// Lines of the encoder, and the clock of core and timers.
const LINES: u32 = 2500;
const CLOCK_HZ: u32 = 16_000_000;

/// Rounds of the control loop in a second: so often that no more than 64 edges of a channel come in between.
const LOOPS_HZ: u32 = 10_000;

/// Pulses shorter than this are no edges, ticks of `CLOCK_HZ`: 0.5 us.
const FILTER: u32 = 8;

#[rtic::app(device = stm32g4::stm32g431, peripherals = true)]
mod app {
    use quadcal::capture::Captures;
    use quadcal::encoder::{Encoder, EncoderConfig};
    use quadcal::interval::Speed;
    use quadcal::stm32_capture::{DmaCapture, Filter, G4};
    use quadcal::units::Turn32;
    use stm32g4::stm32g431::TIM7;

    use super::board::{self, CaptureRegisters};
    use super::{CLOCK_HZ, FILTER, LINES, LOOPS_HZ};

    /// Angle and speed of the newest round, for the rest of the drive.
    #[shared]
    struct Shared {
        seen: (Option<Turn32>, Speed),
    }

    #[local]
    struct Local {
        captures: Captures<DmaCapture<CaptureRegisters, G4>>,
        encoder: Encoder<'static>,
        period: TIM7,
    }

    #[init]
    fn init(cx: init::Context) -> (Shared, Local) {
        let device = cx.device;
        let registers =
            CaptureRegisters::new(device.TIM2, device.DMA1, device.DMAMUX, device.GPIOA);
        let Ok(source) = DmaCapture::start(registers, Filter::of_ticks(FILTER)) else {
            panic!("timer or DMA do not start");
        };
        // At a standstill after 0.1 s without an edge. A table of another encoder is not used.
        let config = EncoderConfig::new(LINES, u64::from(CLOCK_HZ) / 10);
        let Ok(encoder) = Encoder::new(config, board::table(CLOCK_HZ.into()))
            .or_else(|_| Encoder::new(config, None))
        else {
            panic!("the encoder is out of range");
        };
        // In a drive the update of the motor's PWM would be the period.
        device
            .RCC
            .apb1enr1()
            .modify(|_, enable| enable.tim7en().set_bit());
        let period = device.TIM7;
        period
            .arr()
            .write(|reload| unsafe { reload.bits(CLOCK_HZ / LOOPS_HZ - 1) });
        period.dier().write(|interrupts| interrupts.uie().set_bit());
        period.cr1().write(|control| control.cen().set_bit());
        let shared = Shared {
            seen: (None, Speed::default()),
        };
        (
            shared,
            Local {
                captures: Captures::new(source),
                encoder,
                period,
            },
        )
    }

    /// The control loop. It alone has captures and encoder: nothing needs a lock.
    #[task(binds = TIM7, priority = 2, local = [captures, encoder, period], shared = [seen])]
    fn control(mut cx: control::Context) {
        let control::LocalResources {
            captures,
            encoder,
            period,
            ..
        } = cx.local;
        period.sr().write(|status| status.uif().clear_bit());
        captures.drain(|event| {
            encoder.take(event);
        });
        let now = captures.now();
        // A current loop takes these two.
        let seen = (encoder.now(now), encoder.speed_at(now));
        cx.shared.seen.lock(|shared| *shared = seen);
    }

    #[idle(shared = [seen])]
    fn idle(mut cx: idle::Context) -> ! {
        loop {
            let (_angle, _speed) = cx.shared.seen.lock(|seen| *seen);
            cortex_m::asm::wfi();
        }
    }
}

//! Captures drained from DMA's memory: what an edge costs from there to the corrected angle, and what a drain of none takes. The driver is
//! the STM32F405's; its registers are words in RAM, read as fast as such.

use core::array;
use core::cell::Cell;
use core::hint::black_box;

use cortex_m_semihosting::hprintln;
use quadcal::capture::{Captures, Channel};
use quadcal::edge::Sample;
use quadcal::encoder::{Encoder, EncoderConfig};
use quadcal::stm32_capture::{Chip, DmaCapture, F405, Filter, Register, Registers};
use quadcal::table::ErrorTable;

use super::counter::InstructionCounter;
use super::rig::{BLOCK, LINES, Rig, SLOTS};
use super::stage::Stage;

const LATCHES: usize = 256;

/// Addresses of TIM2's counter and period.
const CNT: u32 = 0x4000_0024;
const ARR: u32 = 0x4000_002C;

/// Registers and memory as timer and DMA would leave them.
pub struct Hardware {
    counter: Cell<u32>,
    pins: Cell<u32>,
    remaining: [Cell<u32>; 3],
    memory: [[Cell<u32>; LATCHES]; 3],
}

impl Hardware {
    /// Nothing captured.
    pub const fn new() -> Self {
        Self {
            counter: Cell::new(0),
            pins: Cell::new(0),
            remaining: [const { Cell::new(LATCHES as u32) }; 3],
            memory: [const { [const { Cell::new(0) }; LATCHES] }; 3],
        }
    }

    fn capture(&self, channel: Channel, raw: u32) {
        let remaining = &self.remaining[channel as usize];
        let word = (LATCHES as u32 - remaining.get()) as usize;
        self.memory[channel as usize][word].set(raw);
        remaining.set(match remaining.get() {
            1 => LATCHES as u32,
            more => more - 1,
        });
    }

    /// Captures what changes in a block of samples.
    fn capture_all(&self, samples: &[Sample]) {
        for sample in samples {
            let changed = self.pins.get() as u8 ^ sample.levels.0;
            for channel in [Channel::A, Channel::B, Channel::Z] {
                if changed & channel.bit() != 0 {
                    self.capture(channel, sample.ticks as u32);
                }
            }
            self.stand(sample, 400);
        }
    }

    /// No edge for a while after a sample.
    fn stand(&self, sample: &Sample, ticks: u32) {
        self.pins.set(sample.levels.0.into());
        self.counter.set(sample.ticks as u32 + ticks);
    }
}

impl Registers for &Hardware {
    const LATCHES: usize = LATCHES;

    #[inline(always)]
    fn read(&mut self, register: Register) -> u32 {
        let [a, b, z] = F405::REMAINING;
        black_box(match register {
            _ if register.address() == CNT => self.counter.get(),
            _ if register.address() == ARR => u32::MAX,
            _ if register == F405::PINS => self.pins.get(),
            _ if register == a => self.remaining[0].get(),
            _ if register == b => self.remaining[1].get(),
            _ if register == z => self.remaining[2].get(),
            _ => 0,
        })
    }

    #[inline(always)]
    fn write(&mut self, register: Register, value: u32) {
        black_box((register, value));
    }

    #[inline(always)]
    fn latched(&mut self, channel: Channel, index: usize) -> u32 {
        let word = self.memory[channel as usize].get(index);
        word.map_or(0, |word| black_box(word.get()))
    }

    fn memory(&self, channel: Channel) -> u32 {
        self.memory[channel as usize].as_ptr() as usize as u32
    }
}

type Drained<'a> = Captures<DmaCapture<&'a Hardware, F405>>;

/// Prints everything; `None` if the rig does not fit the core.
pub fn measure(
    counter: &InstructionCounter,
    samples: &mut [Sample; BLOCK],
    table: ErrorTable<'_>,
    hardware: &Hardware,
) -> Option<()> {
    let config = EncoderConfig::new(LINES, 84_000_000);
    let mut encoder: Encoder<'_, i16> = Encoder::new(config, Some(table)).ok()?;
    let source = DmaCapture::start(hardware, Filter::of_ticks(32)).ok()?;
    let mut captures = Captures::new(source);
    let mut rig = Rig::new();
    rig.fill(samples);
    // Two looks at a standstill, so that the levels are known.
    for ticks in [0, 400] {
        hardware.stand(samples.last()?, ticks);
        drain_block(&mut captures, &mut encoder);
    }
    let [mut drained, mut none] = array::from_fn(|_| Stage::default());
    let (mut idle, mut drains) = (0, 0);
    // Two turns, so that the index is seen, and three to count.
    let turn = SLOTS as usize / BLOCK;
    for block in 0..5 * turn {
        if block == 2 * turn {
            [drained, none] = array::from_fn(|_| Stage::default());
        }
        rig.fill(samples);
        hardware.capture_all(samples);
        drained.count(counter, || drain_block(&mut captures, &mut encoder));
        hardware.stand(samples.last()?, 500);
        none.count(counter, || drain_block(&mut captures, &mut encoder));
        // What it takes to look at the counter is in the first difference, too.
        let times = [counter.now(), counter.now()];
        drain_block(&mut captures, &mut encoder);
        let [begin, looked] = times;
        idle += (counter.now() - looked) - (looked - begin);
        drains += 1;
    }
    drained.print("drained_edge", &none);
    hprintln!("drain_of_none={}", idle / drains);
    let right = encoder.faults().total() == 0 && encoder.decoder().is_referenced();
    (right && captures.missed() == 0).then_some(())
}

#[inline(never)]
fn drain_block(captures: &mut Drained<'_>, encoder: &mut Encoder<'_, i16>) {
    captures.drain(|event| {
        if let Some(seen) = encoder.take(event) {
            black_box((seen.edge.angle, seen.edge.interval));
        }
    });
}

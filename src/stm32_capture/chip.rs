//! What differs from chip to chip: clocks, pins, DMA.

use super::driver::StartError;
use super::registers::{Register, Registers, timer};
use crate::capture::Channel;

/// A chip family's way to bring TIM2's captures to memory.
pub trait Chip {
    /// Registers with the number of words that DMA has still to write before it begins again, for A, B and Z.
    const REMAINING: [Register; 3];

    /// `IDR` of the pins' port: PA0 to PA2 are A, B and Z.
    const PINS: Register;

    /// Switches clocks on and gives the pins to the timer.
    fn connect<R: Registers>(registers: &mut R);

    /// Starts DMA.
    ///
    /// # Errors
    /// [`StartError::Dma`] where it does not stop first.
    fn start<R: Registers>(registers: &mut R) -> Result<(), StartError>;
}

const CHANNELS: [Channel; 3] = [Channel::A, Channel::B, Channel::Z];

fn change<R: Registers>(registers: &mut R, register: Register, clear: u32, set: u32) {
    let value = registers.read(register);
    registers.write(register, (value & !clear) | set);
}

/// Port A ("GPIO registers" in both manuals): PA0 to PA2 to alternate function 1, TIM2_CH1 to TIM2_CH3, with pull-ups for open
/// collectors.
fn pins<R: Registers>(registers: &mut R, port: u32) {
    change(registers, Register::at(port + 0x20), 0xFFF, 0x111);
    change(registers, Register::at(port + 0x0C), 0x3F, 0x15);
    change(registers, Register::at(port), 0x3F, 0x2A);
}

/// STM32F405, 407, 415 and 417; TIM2 counts at twice the clock of APB1, 84 MHz at most.
#[derive(Clone, Copy, Debug)]
pub struct F405;

impl F405 {
    const RCC: u32 = 0x4002_3800;
    const PORT: u32 = 0x4002_0000;
    const DMA: u32 = 0x4002_6000;

    /// RM0090, "DMA1 request mapping": TIM2_CH1, TIM2_CH2 and TIM2_CH3 are on channel 3 of these streams.
    const STREAMS: [u32; 3] = [5, 6, 1];
    const REQUEST: u32 = 3;

    const fn stream(stream: u32, offset: u32) -> Register {
        Register::at(Self::DMA + 0x10 + 0x18 * stream + offset)
    }

    /// All flags of a stream, in `LIFCR` for streams 0 to 3 or `HIFCR` for 4 to 7.
    const fn flags(stream: u32) -> (Register, u32) {
        let half = Register::at(Self::DMA + if stream < 4 { 0x08 } else { 0x0C });
        let at = match stream & 3 {
            0 => 0,
            1 => 6,
            2 => 16,
            _ => 22,
        };
        (half, 0x3D << at)
    }
}

impl Chip for F405 {
    const REMAINING: [Register; 3] = [
        Self::stream(Self::STREAMS[0], 0x04),
        Self::stream(Self::STREAMS[1], 0x04),
        Self::stream(Self::STREAMS[2], 0x04),
    ];

    const PINS: Register = Register::at(Self::PORT + 0x10);

    fn connect<R: Registers>(registers: &mut R) {
        // AHB1ENR: port A and DMA1. APB1ENR: TIM2.
        let ahb1 = Register::at(Self::RCC + 0x30);
        change(registers, ahb1, 0, 1 | 1 << 21);
        change(registers, Register::at(Self::RCC + 0x40), 0, 1);
        // Clocks take two cycles to come (errata sheet ES0182); a read is as long.
        registers.read(ahb1);
        pins(registers, Self::PORT);
    }

    fn start<R: Registers>(registers: &mut R) -> Result<(), StartError> {
        for ((stream, latch), channel) in
            Self::STREAMS.into_iter().zip(timer::LATCHES).zip(CHANNELS)
        {
            let control = Self::stream(stream, 0);
            registers.write(control, 0);
            // A transfer under way is finished first.
            if (0..1000).all(|_| registers.read(control) & 1 != 0) {
                return Err(StartError::Dma);
            }
            let (clear, flags) = Self::flags(stream);
            registers.write(clear, flags);
            registers.write(Self::stream(stream, 0x04), R::LATCHES as u32);
            registers.write(Self::stream(stream, 0x08), latch.address());
            let memory = registers.memory(channel);
            registers.write(Self::stream(stream, 0x0C), memory);
            // Direct mode: no latch waits in a FIFO.
            registers.write(Self::stream(stream, 0x14), 0);
            // CHSEL, highest priority, words on both sides, MINC, CIRC, EN.
            let set_up = Self::REQUEST << 25 | 3 << 16 | 2 << 13 | 2 << 11 | 1 << 10 | 1 << 8;
            registers.write(control, set_up);
            registers.write(control, set_up | 1);
        }
        Ok(())
    }
}

/// STM32G4; TIM2 counts at up to 170 MHz.
#[derive(Clone, Copy, Debug)]
pub struct G4;

impl G4 {
    const RCC: u32 = 0x4002_1000;
    const PORT: u32 = 0x4800_0000;
    const DMA: u32 = 0x4002_0000;
    const MUX: u32 = 0x4002_0800;

    /// RM0440, "DMAMUX: assignment of multiplexer inputs to resources": TIM2_CH1 to TIM2_CH3.
    const REQUESTS: [u32; 3] = [56, 57, 58];

    /// DMA1's channels 1 to 3, counted from 0.
    const fn channel(channel: u32, offset: u32) -> Register {
        Register::at(Self::DMA + 0x08 + 0x14 * channel + offset)
    }
}

impl Chip for G4 {
    const REMAINING: [Register; 3] = [
        Self::channel(0, 0x04),
        Self::channel(1, 0x04),
        Self::channel(2, 0x04),
    ];

    const PINS: Register = Register::at(Self::PORT + 0x10);

    fn connect<R: Registers>(registers: &mut R) {
        // AHB1ENR: DMA1 and DMAMUX. AHB2ENR: port A. APB1ENR1: TIM2.
        let ahb1 = Register::at(Self::RCC + 0x48);
        change(registers, ahb1, 0, 1 | 1 << 2);
        change(registers, Register::at(Self::RCC + 0x4C), 0, 1);
        change(registers, Register::at(Self::RCC + 0x58), 0, 1);
        // Clocks take two cycles to come; a read is as long.
        registers.read(ahb1);
        pins(registers, Self::PORT);
    }

    fn start<R: Registers>(registers: &mut R) -> Result<(), StartError> {
        for (((index, request), latch), channel) in
            (0..).zip(Self::REQUESTS).zip(timer::LATCHES).zip(CHANNELS)
        {
            let control = Self::channel(index, 0);
            registers.write(control, 0);
            if registers.read(control) & 1 != 0 {
                return Err(StartError::Dma);
            }
            registers.write(Register::at(Self::DMA + 0x04), 0xF << (4 * index));
            registers.write(Register::at(Self::MUX + 4 * index), request);
            registers.write(Self::channel(index, 0x04), R::LATCHES as u32);
            registers.write(Self::channel(index, 0x08), latch.address());
            let memory = registers.memory(channel);
            registers.write(Self::channel(index, 0x0C), memory);
            // Highest priority, words on both sides, MINC, CIRC, EN.
            let set_up = 3 << 12 | 2 << 10 | 2 << 8 | 1 << 7 | 1 << 5;
            registers.write(control, set_up);
            registers.write(control, set_up | 1);
        }
        Ok(())
    }
}

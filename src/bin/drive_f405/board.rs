//! Clocks and pins of the port, and the chip's random numbers (RM0090: 7, 8, 24 and 30).

use core::ptr;

use quadcal::access::Nonces;
use quadcal::wire::{NONCE_BYTES, Nonce};

const RCC: usize = 0x4002_3800;
const PORT_A: usize = 0x4002_0000;
const USART1: usize = 0x4001_1000;
const RANDOM: usize = 0x5006_0800;

fn read(register: usize) -> u32 {
    let address: *const u32 = ptr::without_provenance(register);
    // SAFETY: a register of the blocks above, 4-byte aligned; only the random numbers' data are used up by a read.
    unsafe { address.read_volatile() }
}

fn change(register: usize, clear: u32, set: u32) {
    let address: *mut u32 = ptr::without_provenance_mut(register);
    // SAFETY: as above; these registers reach no memory, and the main loop alone writes them, before the control loop begins.
    unsafe { address.write_volatile(read(register) & !clear | set) };
}

/// PA9 and PA10 to USART1 at a rate; the processor stays on its internal oscillator.
pub fn connect_port(clock_hz: u32, baud: u32) {
    change(RCC + 0x30, 0, 1);
    change(RCC + 0x44, 0, 1 << 4);
    // Clocks take two cycles to come.
    read(RCC + 0x44);
    change(PORT_A + 0x24, 0xFF0, 0x770);
    change(PORT_A, 0xF << 18, 0xA << 18);
    change(PORT_A + 0x0C, 0xF << 18, 0x4 << 18);
    change(USART1 + 0x08, 0xFFFF, (clock_hz + baud / 2) / baud);
}

/// The PLL, for the random numbers alone: 16 MHz / 8 * 168 / 7 are 48 MHz.
pub fn start_noise() {
    change(RCC + 0x04, 0x0F43_7FFF, 7 << 24 | 168 << 6 | 8);
    change(RCC, 0, 1 << 24);
    let _locked = (0..100_000).any(|_| read(RCC) & 1 << 25 != 0);
    change(RCC + 0x34, 0, 1 << 6);
    read(RCC + 0x34);
    change(RANDOM, 0, 1 << 2);
}

/// Nonces from the chip's random numbers; none where these fail their own checks or do not come.
pub struct Noise;

impl Nonces for Noise {
    fn nonce(&mut self) -> Option<Nonce> {
        let mut nonce = [0; NONCE_BYTES];
        for piece in nonce.chunks_mut(4) {
            // Ready, and neither the clock's nor the seed's check failed.
            let ready = (0..10_000).any(|_| read(RANDOM + 0x04) & 0x67 == 1);
            if !ready {
                return None;
            }
            for (byte, random) in piece.iter_mut().zip(read(RANDOM + 0x08).to_le_bytes()) {
                *byte = random;
            }
        }
        Some(nonce)
    }
}

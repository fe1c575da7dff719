//! USART1 of an STM32F405; in QEMU the first `-serial`. What comes in is put aside by its interrupt, so that nothing is lost while the main
//! loop is at work.
//!
//! A board sets clock, pins and baud rate up before (RM0090, chapter 30); in QEMU there is no line to set up.

use core::cell::RefCell;
use core::convert::Infallible;
use core::ptr;

use cortex_m::interrupt::{self, InterruptNumber, Mutex};
use cortex_m::peripheral::NVIC;
use cortex_m_rt::exception;
use embedded_io::{ErrorType, Read, ReadReady, Write};
use heapless::Deque;

/// Base address of its registers (RM0090, memory map).
const REGISTERS: usize = 0x4001_1000;

/// Status, data and first control register: offsets, and the bits used.
const STATUS: usize = 0x00;
const DATA: usize = 0x04;
const CONTROL: usize = 0x0C;
const RECEIVED: u32 = 1 << 5;
const ROOM_TO_SEND: u32 = 1 << 7;
const ENABLED: u32 = 1 << 13;
const INTERRUPT_ON_RECEIVED: u32 = 1 << 5;
const SENDS: u32 = 1 << 3;
const RECEIVES: u32 = 1 << 2;

/// Its interrupt's number.
const INTERRUPT: u16 = 37;

/// Bytes that came in and were not read yet: two frames and more.
static INBOX: Mutex<RefCell<Deque<u8, 512>>> = Mutex::new(RefCell::new(Deque::new()));

#[derive(Clone, Copy)]
struct Usart1Interrupt;

// SAFETY: the number is that of USART1 in RM0090's vector table, and the type has this one value.
unsafe impl InterruptNumber for Usart1Interrupt {
    fn number(self) -> u16 {
        INTERRUPT
    }
}

fn read(register: usize) -> u32 {
    let address: *const u32 = ptr::without_provenance(REGISTERS + register);
    // SAFETY: a register of USART1, 4-byte aligned. Reading the data register takes a byte out, which only the interrupt does.
    unsafe { address.read_volatile() }
}

fn write(register: usize, value: u32) {
    let address: *mut u32 = ptr::without_provenance_mut(REGISTERS + register);
    // SAFETY: a register of USART1, 4-byte aligned; it reaches no memory. Only the port's owner writes, or whoever sends for it.
    unsafe { address.write_volatile(value) }
}

/// The port.
pub struct Usart {
    _one: (),
}

impl Usart {
    /// Switches the port on. Whoever has the interrupt controller has the port: there is one of each.
    pub fn start(_interrupts: NVIC) -> Self {
        let bits = ENABLED | INTERRUPT_ON_RECEIVED | SENDS | RECEIVES;
        write(CONTROL, bits);
        // SAFETY: no code here relies on interrupts being off, and the handler shares nothing but the inbox, which is locked.
        unsafe { NVIC::unmask(Usart1Interrupt) };
        Self { _one: () }
    }
}

// SAFETY: cortex-m-rt asks for `unsafe` because a default handler may run in any state; this one touches the port and the locked
// inbox alone.
#[exception]
unsafe fn DefaultHandler(interrupt: i16) {
    if interrupt != INTERRUPT.cast_signed() {
        return;
    }
    while read(STATUS) & RECEIVED != 0 {
        let [byte, ..] = read(DATA).to_le_bytes();
        // A byte too many is lost, and with it the frame that it was in: the check sum tells.
        let _ = interrupt::free(|cs| INBOX.borrow(cs).borrow_mut().push_back(byte));
    }
}

/// Sends what `next` gives if there is room for a byte, and does not wait.
#[allow(dead_code)] // One image of two.
pub fn send_one(next: impl FnOnce() -> Option<u8>) {
    if read(STATUS) & ROOM_TO_SEND != 0
        && let Some(byte) = next()
    {
        write(DATA, byte.into());
    }
}

impl ErrorType for Usart {
    type Error = Infallible;
}

impl ReadReady for Usart {
    fn read_ready(&mut self) -> Result<bool, Infallible> {
        Ok(interrupt::free(|cs| !INBOX.borrow(cs).borrow().is_empty()))
    }
}

impl Read for Usart {
    /// Takes what there is, none if nothing came.
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, Infallible> {
        let mut count = 0;
        for cell in buffer {
            match interrupt::free(|cs| INBOX.borrow(cs).borrow_mut().pop_front()) {
                Some(byte) => *cell = byte,
                None => break,
            }
            count += 1;
        }
        Ok(count)
    }
}

impl Write for Usart {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, Infallible> {
        for byte in bytes {
            while read(STATUS) & ROOM_TO_SEND == 0 {}
            write(DATA, (*byte).into());
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

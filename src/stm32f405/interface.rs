//! What the driver asks of a board, and the bits of the flash interface's registers (RM0090, chapter 3).

/// A register of the flash interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Register {
    /// `FLASH_ACR`: wait states and caches.
    Access,
    /// `FLASH_KEYR`: where the keys go.
    Key,
    /// `FLASH_SR`: busy and errors.
    Status,
    /// `FLASH_CR`: what to do.
    Control,
}

impl Register {
    /// Offset from the flash interface's base address, 0x4002_3C00.
    #[must_use]
    pub const fn offset(self) -> usize {
        match self {
            Self::Access => 0x00,
            Self::Key => 0x04,
            Self::Status => 0x0C,
            Self::Control => 0x10,
        }
    }
}

/// What is stored into flash by one access of the processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// One byte, for parallelism x8.
    Byte(u8),
    /// Two bytes, for x16.
    Half(u16),
    /// Four bytes, for x32.
    Word(u32),
}

/// Registers and memory of the flash. Offsets count from the flash's first byte, at address 0x0800_0000.
pub trait Interface {
    /// Reads a register.
    fn read(&mut self, register: Register) -> u32;

    /// Writes a register; done when this returns.
    fn write(&mut self, register: Register, value: u32);

    /// Stores to flash memory by one access of the unit's size, at a multiple of it; on the bus when this returns.
    fn program(&mut self, offset: u32, unit: Unit);

    /// Copies flash memory.
    fn load(&mut self, offset: u32, bytes: &mut [u8]);
}

pub(super) mod access {
    pub const ICEN: u32 = 1 << 9;
    pub const DCEN: u32 = 1 << 10;
    pub const ICRST: u32 = 1 << 11;
    pub const DCRST: u32 = 1 << 12;
}

pub(super) mod key {
    pub const FIRST: u32 = 0x4567_0123;
    pub const SECOND: u32 = 0xCDEF_89AB;
}

pub(super) mod status {
    pub const OPERR: u32 = 1 << 1;
    pub const WRPERR: u32 = 1 << 4;
    pub const PGAERR: u32 = 1 << 5;
    pub const PGPERR: u32 = 1 << 6;
    pub const PGSERR: u32 = 1 << 7;
    pub const BSY: u32 = 1 << 16;
    pub const ERRORS: u32 = OPERR | WRPERR | PGAERR | PGPERR | PGSERR;
}

pub(super) mod control {
    pub const PG: u32 = 1 << 0;
    pub const SER: u32 = 1 << 1;
    pub const SNB_AT: u32 = 3;
    pub const PSIZE_AT: u32 = 8;
    pub const STRT: u32 = 1 << 16;
    pub const LOCK: u32 = 1 << 31;
}

//! Flash in memory that counts what is done to it.

use std::cell::Cell;
use std::rc::Rc;

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

/// What the device must never do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Beyond the end, or not on a boundary.
    Misplaced,
}

impl NorFlashError for Fault {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

/// Four sectors of 512 bytes.
#[derive(Clone, Debug)]
pub struct CountingFlash {
    bytes: Vec<u8>,
    /// Writes and erasures so far.
    pub changes: Rc<Cell<u64>>,
}

impl Default for CountingFlash {
    fn default() -> Self {
        Self {
            bytes: vec![0xFF; 4 * Self::ERASE_SIZE],
            changes: Rc::default(),
        }
    }
}

impl CountingFlash {
    fn cells(&mut self, from: usize, to: usize, unit: usize) -> Result<&mut [u8], Fault> {
        let aligned = from.is_multiple_of(unit) && to.is_multiple_of(unit);
        let cells = self.bytes.get_mut(from..to).filter(|_| aligned);
        cells.ok_or(Fault::Misplaced)
    }

    fn count(&self) {
        self.changes.set(self.changes.get() + 1);
    }
}

impl ErrorType for CountingFlash {
    type Error = Fault;
}

impl ReadNorFlash for CountingFlash {
    const READ_SIZE: usize = 4;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Fault> {
        let from = offset as usize;
        let cells = self.cells(from, from + bytes.len(), Self::READ_SIZE)?;
        bytes.copy_from_slice(cells);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for CountingFlash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 512;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Fault> {
        self.count();
        self.cells(from as usize, to as usize, Self::ERASE_SIZE)?
            .fill(0xFF);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Fault> {
        self.count();
        let from = offset as usize;
        let cells = self.cells(from, from + bytes.len(), Self::WRITE_SIZE)?;
        for (cell, byte) in cells.iter_mut().zip(bytes) {
            *cell &= byte;
        }
        Ok(())
    }
}

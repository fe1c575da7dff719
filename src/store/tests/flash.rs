//! Flash as it is: erased in sectors, written in units, bits only fall, a unit is written once, and the power may fail.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use std::vec::Vec;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    Unaligned,
    Outside,
    /// A unit that was written since it was erased.
    Rewritten(usize),
    PowerFailed,
}

impl NorFlashError for Fault {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Unaligned => NorFlashErrorKind::NotAligned,
            Self::Outside => NorFlashErrorKind::OutOfBounds,
            _ => NorFlashErrorKind::Other,
        }
    }
}

/// Flash written in `W` bytes at once and erased in `E`.
#[derive(Clone)]
pub struct Flash<const W: usize, const E: usize> {
    pub bytes: Vec<u8>,
    written: Vec<bool>,
    /// Units written and sectors erased so far.
    pub operations: u32,
    /// The operation in whose midst the power fails, and what becomes of the bits then.
    cut: Option<(u32, u32)>,
    failed: bool,
}

impl<const W: usize, const E: usize> Flash<W, E> {
    pub fn new(sectors: usize) -> Self {
        Self {
            bytes: std::vec![0xFF; sectors * E],
            written: std::vec![false; sectors * E / W],
            operations: 0,
            cut: None,
            failed: false,
        }
    }

    /// The power will fail in the midst of an operation, counted from now.
    pub fn cut_at(&mut self, operation: u32, seed: u32) {
        self.cut = Some((self.operations + operation, seed));
    }

    /// The power is back.
    pub fn restore(&mut self) {
        self.cut = None;
        self.failed = false;
    }

    /// Counts an operation; how it is torn, if it is.
    fn begin(&mut self) -> Result<Option<u32>, Fault> {
        if self.failed {
            return Err(Fault::PowerFailed);
        }
        let torn = self.cut.filter(|cut| cut.0 == self.operations);
        self.operations += 1;
        self.failed = torn.is_some();
        Ok(torn.map(|cut| cut.1))
    }

    fn range(&self, from: usize, to: usize, unit: usize) -> Result<(), Fault> {
        if !from.is_multiple_of(unit) || !to.is_multiple_of(unit) {
            Err(Fault::Unaligned)
        } else if from > to || to > self.bytes.len() {
            Err(Fault::Outside)
        } else {
            Ok(())
        }
    }
}

/// Which bits of a byte have come to their new state when the power fails: none, all, the first bytes', or some.
fn changed(seed: u32, index: usize, length: usize) -> u8 {
    match seed % 4 {
        0 => 0,
        1 => 0xFF,
        2 if index < length / 2 => 0xFF,
        2 => 0,
        _ => {
            let mut x = (seed ^ (index as u32).wrapping_mul(0x9E37_79B9)) | 1;
            for _ in 0..3 {
                x ^= x << 13;
                x ^= x >> 17;
                x ^= x << 5;
            }
            (x >> 11) as u8
        }
    }
}

impl<const W: usize, const E: usize> ErrorType for Flash<W, E> {
    type Error = Fault;
}

impl<const W: usize, const E: usize> ReadNorFlash for Flash<W, E> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Fault> {
        let from = offset as usize;
        self.range(from, from + bytes.len(), 1)?;
        bytes.copy_from_slice(&self.bytes[from..from + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const W: usize, const E: usize> NorFlash for Flash<W, E> {
    const WRITE_SIZE: usize = W;
    const ERASE_SIZE: usize = E;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Fault> {
        self.range(from as usize, to as usize, E)?;
        for sector in (from as usize..to as usize).step_by(E) {
            let torn = self.begin()?;
            for (index, byte) in self.bytes[sector..sector + E].iter_mut().enumerate() {
                *byte |= torn.map_or(0xFF, |seed| changed(seed, index, E));
            }
            // What is half erased must not be written.
            self.written[sector / W..(sector + E) / W].fill(torn.is_some());
            if torn.is_some() {
                return Err(Fault::PowerFailed);
            }
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Fault> {
        let from = offset as usize;
        self.range(from, from + bytes.len(), W)?;
        for (unit, new) in bytes.chunks(W).enumerate() {
            let at = from + unit * W;
            let torn = self.begin()?;
            if std::mem::replace(&mut self.written[at / W], true) {
                return Err(Fault::Rewritten(at));
            }
            for (index, (byte, new)) in self.bytes[at..at + W].iter_mut().zip(new).enumerate() {
                *byte &= new | !torn.map_or(0xFF, |seed| changed(seed, index, W));
            }
            if torn.is_some() {
                return Err(Fault::PowerFailed);
            }
        }
        Ok(())
    }
}

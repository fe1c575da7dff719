//! Flash in memory, kept in a file where one is named.

use std::fs;
use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use quadcal::device::MappedFlash;
use quadcal::shape::EncoderShape;
use quadcal::store::{Layout, LayoutError, place_bytes};

use super::PretendError;

/// Bytes of a sector, the unit of erasing: as the STM32F405's first ones.
const SECTOR: u32 = 16_384;

/// Erasures that a place may see.
const ERASURES_MAX: u32 = 10_000;

struct Content {
    bytes: Vec<u8>,
    changed: bool,
}

/// Flash of two places.
#[derive(Clone)]
pub(super) struct Flash {
    content: Arc<Mutex<Content>>,
    place: u32,
}

/// Beyond the flash's end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outside;

impl NorFlashError for Outside {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::OutOfBounds
    }
}

impl Flash {
    /// Erased, or as the file has it.
    pub fn load(shape: EncoderShape, file: Option<&Path>) -> Result<Self, PretendError> {
        let place = place_bytes(shape).next_multiple_of(SECTOR);
        let erased = || vec![0xFF; 2 * place as usize];
        let bytes = match file.map(|path| (path, fs::read(path))) {
            None => erased(),
            Some((_, Ok(bytes))) if bytes.len() == 2 * place as usize => bytes,
            Some((path, Ok(_))) => {
                let other = "it holds the flash of another encoder";
                return Err(failed(path, io::Error::other(other)));
            }
            Some((_, Err(error))) if error.kind() == io::ErrorKind::NotFound => erased(),
            Some((path, Err(error))) => return Err(failed(path, error)),
        };
        let content = Content {
            bytes,
            changed: false,
        };
        Ok(Self {
            content: Arc::new(Mutex::new(content)),
            place,
        })
    }

    pub fn layout(&self) -> Result<Layout, LayoutError> {
        let place = self.place;
        Layout::new(self, [0..place, place..2 * place], ERASURES_MAX)
    }

    /// Brings changes to the file.
    pub fn save(&self, file: Option<&Path>) -> Result<(), PretendError> {
        let mut content = self.content();
        if let (true, Some(path)) = (content.changed, file) {
            fs::write(path, &content.bytes).map_err(|source| failed(path, source))?;
            content.changed = false;
        }
        Ok(())
    }

    fn content(&self) -> MutexGuard<'_, Content> {
        self.content.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(
        &self,
        from: usize,
        to: usize,
        change: impl FnOnce(&mut [u8]),
    ) -> Result<(), Outside> {
        let mut content = self.content();
        change(content.bytes.get_mut(from..to).ok_or(Outside)?);
        content.changed = true;
        Ok(())
    }
}

fn failed(path: &Path, source: io::Error) -> PretendError {
    PretendError::Flash {
        path: path.to_owned(),
        source,
    }
}

impl ErrorType for Flash {
    type Error = Outside;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Outside> {
        let content = self.content();
        let from = offset as usize;
        let there = content.bytes.get(from..from + bytes.len());
        bytes.copy_from_slice(there.ok_or(Outside)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.content().bytes.len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR as usize;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Outside> {
        self.change(from as usize, to as usize, |cells| cells.fill(0xFF))
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Outside> {
        let from = offset as usize;
        // Bits only fall.
        self.change(from, from + bytes.len(), |cells| {
            for (cell, byte) in cells.iter_mut().zip(bytes) {
                *cell &= byte;
            }
        })
    }
}

impl MappedFlash<'static> for Flash {
    /// A copy for good: one a commit, in a program that runs for a while.
    fn bytes(&self, offset: u32) -> Option<&'static [u8]> {
        let copy = self.content().bytes.get(offset as usize..)?.to_vec();
        Some(Box::leak(copy.into_boxed_slice()))
    }
}

//! The flash's file, also seen where the STM32F405 has its flash: tables are used in place.
//!
//! QEMU maps a flash at the chip's address that the guest can only read. Its semihosting reads a file straight into it, as its debugger
//! may write there. So after every change of the file the same bytes are brought to the mapped flash, and at a start all of them.

use quadcal::device::MappedFlash;
use quadcal::stm32f405::{PLACES, ROOM};

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

use crate::file_flash::{FileFlash, FileFlashError};
use crate::qemu::semihost::IoError;

/// Where the flash is mapped (RM0090, "Flash module organization").
const FLASH: usize = 0x0800_0000;

/// A flash in a file, with its mapped copy kept alike.
pub struct ChipFlash {
    file: FileFlash,
}

/// The mapped copy.
#[derive(Clone, Copy)]
pub struct Mapped {
    _brought: (),
}

impl ChipFlash {
    /// The flash in a file, and the memory where it is mapped.
    pub fn open(path: &str) -> Result<(Self, Mapped), IoError> {
        let mut flash = Self {
            file: FileFlash::open(path)?,
        };
        flash.bring(ROOM.start, ROOM.end)?;
        Ok((flash, Mapped { _brought: () }))
    }

    /// Brings bytes of the file to the mapped flash, as far as they lie in the tables' room.
    fn bring(&mut self, from: u32, to: u32) -> Result<(), IoError> {
        let (from, to) = (from.max(ROOM.start), to.min(ROOM.end));
        if from >= to {
            return Ok(());
        }
        // SAFETY: the bytes lie in the room that memory/stm32f405.x keeps free of program, so no Rust object is written to but the slices
        // that `Mapped` gives out; the store changes only the place that is not in use, after which nobody looks into such a slice
        // before it is given out anew.
        unsafe {
            self.file
                .copy_out(from as usize, FLASH + from as usize, (to - from) as usize)
        }
    }
}

impl MappedFlash<'static> for Mapped {
    /// The bytes up to the end of the place that `offset` is in.
    fn bytes(&self, offset: u32) -> Option<&'static [u8]> {
        let place = PLACES.iter().find(|place| place.contains(&offset))?;
        let from = core::ptr::without_provenance::<u8>(FLASH + offset as usize);
        // SAFETY: mapped flash inside one of the places, which hold no Rust object and are readable as long as the chip runs. They
        // change only while they hold no table in use.
        Some(unsafe { core::slice::from_raw_parts(from, (place.end - offset) as usize) })
    }
}

impl ErrorType for ChipFlash {
    type Error = FileFlashError;
}

impl ReadNorFlash for ChipFlash {
    const READ_SIZE: usize = FileFlash::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FileFlashError> {
        self.file.read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.file.capacity()
    }
}

impl NorFlash for ChipFlash {
    const WRITE_SIZE: usize = FileFlash::WRITE_SIZE;
    const ERASE_SIZE: usize = FileFlash::ERASE_SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FileFlashError> {
        let erased = self.file.erase(from, to);
        self.bring(from, to)?;
        erased
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FileFlashError> {
        let written = self.file.write(offset, bytes);
        let end = offset.saturating_add(bytes.len() as u32);
        self.bring(offset, end)?;
        written
    }
}

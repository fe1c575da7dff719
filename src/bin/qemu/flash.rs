//! Flash kept in a file of the host, with the STM32F405's sectors up to the end of the tables' room.
//!
//! A real flash torn by a power cut has words with some bits fallen and sectors with some bits risen. So a word is written in
//! steps, each a write of the host's system of its own: first with some of its bits fallen, then one half, then the other.
//! A sector is erased in pieces, first raising some bits everywhere. Nothing is held back: whoever kills QEMU leaves in the file
//! what was done up to then, and nothing else.

use core::fmt::Debug;

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_read, check_write,
};
use quadcal::stm32f405::{ROOM, is_border, sector_at, sector_start};

use crate::qemu::semihost::{File, IoError, Mode};

const WORD: usize = 4;

/// Bytes that are erased in one step.
const PIECE: usize = 64;

/// Why the file could not be used as flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileFlashError {
    /// The host refused.
    Io(IoError),
    /// Not whole words or sectors, or beyond the end.
    Range(NorFlashErrorKind),
}

impl From<IoError> for FileFlashError {
    fn from(error: IoError) -> Self {
        Self::Io(error)
    }
}

impl From<NorFlashErrorKind> for FileFlashError {
    fn from(kind: NorFlashErrorKind) -> Self {
        Self::Range(kind)
    }
}

impl NorFlashError for FileFlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Io(_) => NorFlashErrorKind::Other,
            Self::Range(kind) => *kind,
        }
    }
}

/// The flash.
pub struct FileFlash {
    file: File,
}

impl FileFlash {
    /// The flash in the file at `path`. What the file does not have, or not yet, is erased flash.
    pub fn open(path: &str) -> Result<Self, IoError> {
        if let Ok(there) = File::open(path, Mode::Read) {
            there.close()?;
        } else {
            File::open(path, Mode::Write)?.close()?;
        }
        let mut file = File::open(path, Mode::Update)?;
        let length = file.length()?;
        file.seek(length)?;
        for at in (length..ROOM.end as usize).step_by(PIECE) {
            let piece = [0xFF; PIECE];
            let missing = (ROOM.end as usize - at).min(PIECE);
            file.write(piece.get(..missing).unwrap_or(&piece))?;
        }
        Ok(Self { file })
    }

    /// Copies bytes of the file to where the processor sees them.
    ///
    /// # Safety
    /// As for [`File::read_to`].
    #[allow(dead_code, reason = "not every image maps its flash")]
    pub unsafe fn copy_out(
        &mut self,
        at: usize,
        address: usize,
        length: usize,
    ) -> Result<(), IoError> {
        self.file.seek(at)?;
        // SAFETY: the caller answers for the memory.
        unsafe { self.file.read_to(address, length) }
    }

    fn read_at(&mut self, at: usize, bytes: &mut [u8]) -> Result<(), IoError> {
        self.file.seek(at)?;
        let read = self.file.read(bytes)?;
        if read == bytes.len() {
            Ok(())
        } else {
            Err(IoError::Read)
        }
    }

    fn write_at(&mut self, at: usize, bytes: &[u8]) -> Result<(), IoError> {
        self.file.seek(at)?;
        self.file.write(bytes)
    }

    fn program_word(&mut self, at: usize, new: u32) -> Result<(), IoError> {
        let mut old = [0; WORD];
        self.read_at(at, &mut old)?;
        let old = u32::from_le_bytes(old);
        let torn = old & (new | some_bits(at));
        self.write_at(at, &torn.to_le_bytes())?;
        let [a, b, c, d] = (old & new).to_le_bytes();
        self.write_at(at, &[a, b])?;
        self.file.write(&[c, d])
    }

    fn erase_sector(&mut self, from: usize, to: usize) -> Result<(), IoError> {
        let mut piece = [0; PIECE];
        for at in (from..to).step_by(PIECE) {
            self.read_at(at, &mut piece)?;
            for (at, word) in (at..).step_by(WORD).zip(piece.as_chunks_mut::<WORD>().0) {
                *word = (u32::from_le_bytes(*word) | some_bits(at)).to_le_bytes();
            }
            self.write_at(at, &piece)?;
        }
        self.file.seek(from)?;
        for _ in (from..to).step_by(PIECE) {
            self.file.write(&[0xFF; PIECE])?;
        }
        Ok(())
    }
}

/// The bits of the word at an offset that change late.
const fn some_bits(at: usize) -> u32 {
    let x = (at as u32).wrapping_mul(0x9E37_79B9);
    (x ^ (x >> 15)).wrapping_mul(0x85EB_CA6B)
}

impl ErrorType for FileFlash {
    type Error = FileFlashError;
}

impl ReadNorFlash for FileFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FileFlashError> {
        check_read(self, offset, bytes.len())?;
        Ok(self.read_at(offset as usize, bytes)?)
    }

    fn capacity(&self) -> usize {
        ROOM.end as usize
    }
}

impl NorFlash for FileFlash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = 16 << 10;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FileFlashError> {
        if from > to || to > ROOM.end {
            return Err(NorFlashErrorKind::OutOfBounds.into());
        }
        if !is_border(from) || !is_border(to) {
            return Err(NorFlashErrorKind::NotAligned.into());
        }
        for sector in sector_at(from)..sector_at(to) {
            let (from, to) = (sector_start(sector), sector_start(sector + 1));
            self.erase_sector(from as usize, to as usize)?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FileFlashError> {
        check_write(self, offset, bytes.len())?;
        let words = bytes.as_chunks::<WORD>().0;
        for (at, word) in (offset as usize..).step_by(WORD).zip(words) {
            self.program_word(at, u32::from_le_bytes(*word))?;
        }
        Ok(())
    }
}

//! The driver: locked but while it works, every wait bounded, nothing outside its room touched.

use core::ops::Range;

use embedded_storage::nor_flash::{ErrorType, MultiwriteNorFlash, NorFlash, ReadNorFlash};

use super::error::{FlashError, Refusal};
use super::interface::{Interface, Register, Unit, access, control, key, status};
use super::sectors::{CAPACITY, is_border, sector_at, sector_start};
use super::supply::Supply;

/// Longest that a write of one unit may take, in whole milliseconds; the data sheet says 0.1.
const PROGRAM_MS: u32 = 1;

/// Cycles that a look at the status register takes at least.
const POLL_CYCLES: u32 = 4;

/// Bytes that are handed over at once.
const WORD: usize = 4;

/// The chip's flash. Reads all of it, writes and erases a room of it alone.
pub struct Flash<I> {
    interface: I,
    room: Range<u32>,
    supply: Supply,
    polls_per_ms: u32,
    /// The controller did not take its keys: once more would be a bus error.
    shut: bool,
    /// An operation may still be running, or the caches hold what it erased: to be settled before anything is read.
    unsettled: bool,
}

impl<I: Interface> Flash<I> {
    /// The flash behind `interface`, of which `room` (offsets) may be changed. Waits are bounded in looks at the status register
    /// of a core that runs at `core_hz` or less, so that a slower core only waits longer.
    pub const fn new(interface: I, room: Range<u32>, supply: Supply, core_hz: u32) -> Self {
        let polls_per_ms = core_hz.div_ceil(1000 * POLL_CYCLES);
        Self {
            interface,
            room,
            supply,
            polls_per_ms,
            shut: false,
            unsettled: false,
        }
    }

    /// The interface. Kept from all but tests: whoever has it can erase anything.
    #[cfg(test)]
    pub(super) fn interface(&mut self) -> &mut I {
        &mut self.interface
    }

    #[cfg(test)]
    pub(super) fn into_interface(self) -> I {
        self.interface
    }

    /// Waits until the controller is not busy, and returns its status.
    fn idle(&mut self, limit_ms: u32) -> Result<u32, FlashError> {
        for _ in 0..=limit_ms.saturating_mul(self.polls_per_ms) {
            let status = self.interface.read(Register::Status);
            if status & status::BSY == 0 {
                return Ok(status);
            }
        }
        self.unsettled = true;
        Err(FlashError::Timeout)
    }

    /// Waits for the end of the operation at an offset.
    fn done(&mut self, at: u32, limit_ms: u32) -> Result<(), FlashError> {
        let status = self.idle(limit_ms)?;
        let refused = [
            (status::WRPERR, Refusal::WriteProtected),
            (status::PGSERR, Refusal::Sequence),
            (status::PGPERR, Refusal::Parallelism),
            (status::PGAERR, Refusal::Alignment),
            (status::OPERR, Refusal::Operation),
        ];
        match refused.iter().find(|(flag, _)| status & flag != 0) {
            Some(&(_, why)) => Err(FlashError::Refused { at, why }),
            None => Ok(()),
        }
    }

    /// Waits for what a timeout left running, as long as the longest operation may take, and brings the caches up to date.
    fn settle(&mut self) -> Result<(), FlashError> {
        if self.unsettled {
            self.idle(self.supply.erase_ms(u32::MAX))?;
            self.flush_caches();
            self.unsettled = false;
        }
        Ok(())
    }

    /// Empties both caches, which has to be done while they are off.
    fn flush_caches(&mut self) {
        let before = self.interface.read(Register::Access);
        let off = before & !(access::DCEN | access::ICEN | access::DCRST | access::ICRST);
        self.interface.write(Register::Access, off);
        let reset = off | access::DCRST | access::ICRST;
        self.interface.write(Register::Access, reset);
        self.interface.write(Register::Access, off);
        let enabled = before & (access::DCEN | access::ICEN);
        self.interface.write(Register::Access, off | enabled);
    }

    fn unlock(&mut self) -> Result<(), FlashError> {
        if self.shut {
            return Err(FlashError::Locked);
        }
        // The keys must not be written to a controller that is open.
        if self.interface.read(Register::Control) & control::LOCK != 0 {
            self.interface.write(Register::Key, key::FIRST);
            self.interface.write(Register::Key, key::SECOND);
            self.shut = self.interface.read(Register::Control) & control::LOCK != 0;
        }
        if self.shut {
            Err(FlashError::Locked)
        } else {
            Ok(())
        }
    }

    /// Tells the controller what to do next, and makes sure that it listens.
    fn command(&mut self, command: u32) -> Result<(), FlashError> {
        let command = command | self.supply.parallelism();
        self.interface.write(Register::Control, command);
        if self.interface.read(Register::Control) == command {
            Ok(())
        } else {
            Err(FlashError::Deaf)
        }
    }

    /// Opens the controller for `work`, and locks it again.
    fn unlocked(
        &mut self,
        work: impl FnOnce(&mut Self) -> Result<(), FlashError>,
    ) -> Result<(), FlashError> {
        self.settle()?;
        self.idle(self.supply.erase_ms(u32::MAX))?;
        self.unlock()?;
        // Flags of earlier operations, a debugger's too, are cleared by writing them.
        self.interface.write(Register::Status, status::ERRORS);
        let result = work(self);
        // While the controller is busy, a write to this register would stall the bus without end.
        if result != Err(FlashError::Timeout) {
            self.interface.write(Register::Control, control::LOCK);
        }
        result
    }

    fn erase_sector(&mut self, sector: u32) -> Result<(), FlashError> {
        let command = control::SER | (sector << control::SNB_AT);
        self.command(command)?;
        self.unsettled = true;
        let start = command | self.supply.parallelism() | control::STRT;
        self.interface.write(Register::Control, start);
        self.done(sector_start(sector), self.supply.erase_ms(sector))
    }

    fn program_word(&mut self, at: u32, new: [u8; WORD]) -> Result<(), FlashError> {
        let mut old = [0; WORD];
        self.interface.load(at, &mut old);
        let [a, b, c, d] = new;
        match self.supply {
            Supply::From1V8 => {
                for (at, byte) in (at..).zip(new) {
                    self.program_unit(at, Unit::Byte(byte))?;
                }
            }
            Supply::From2V1 => {
                self.program_unit(at, Unit::Half(u16::from_le_bytes([a, b])))?;
                self.program_unit(at + 2, Unit::Half(u16::from_le_bytes([c, d])))?;
            }
            Supply::From2V7 => self.program_unit(at, Unit::Word(u32::from_le_bytes(new)))?,
        }
        let mut now = [0; WORD];
        self.interface.load(at, &mut now);
        let expected = u32::from_le_bytes(old) & u32::from_le_bytes(new);
        if u32::from_le_bytes(now) == expected {
            Ok(())
        } else {
            Err(FlashError::Mismatch(at))
        }
    }

    fn program_unit(&mut self, at: u32, unit: Unit) -> Result<(), FlashError> {
        self.interface.program(at, unit);
        self.done(at, PROGRAM_MS)
    }

    fn check(&self, from: u32, to: u32) -> Result<(), FlashError> {
        if from > to || to > CAPACITY {
            Err(FlashError::OutOfBounds)
        } else if from < self.room.start || to > self.room.end {
            Err(FlashError::NotOurs)
        } else {
            Ok(())
        }
    }
}

/// Offset of the first byte after `bytes`, whatever their number.
fn end(offset: u32, bytes: &[u8]) -> Result<u32, FlashError> {
    u32::try_from(bytes.len())
        .ok()
        .and_then(|length| offset.checked_add(length))
        .filter(|end| *end <= CAPACITY)
        .ok_or(FlashError::OutOfBounds)
}

impl<I: Interface> ErrorType for Flash<I> {
    type Error = FlashError;
}

impl<I: Interface> ReadNorFlash for Flash<I> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        end(offset, bytes)?;
        self.settle()?;
        self.interface.load(offset, bytes);
        Ok(())
    }

    fn capacity(&self) -> usize {
        CAPACITY as usize
    }
}

impl<I: Interface> NorFlash for Flash<I> {
    const WRITE_SIZE: usize = WORD;

    /// The smallest sector's; `from` and `to` of an erasure must be borders of whole sectors ([`is_border`]), whatever their size.
    const ERASE_SIZE: usize = 16 << 10;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        self.check(from, to)?;
        if !is_border(from) || !is_border(to) {
            return Err(FlashError::NotAligned);
        }
        self.unlocked(|flash| {
            (sector_at(from)..sector_at(to)).try_for_each(|sector| flash.erase_sector(sector))
        })
        .and_then(|()| self.settle())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        self.check(offset, end(offset, bytes)?)?;
        let (words, rest) = bytes.as_chunks::<WORD>();
        if !rest.is_empty() || !(offset as usize).is_multiple_of(WORD) {
            return Err(FlashError::NotAligned);
        }
        self.unlocked(|flash| {
            flash.command(control::PG)?;
            (offset..)
                .step_by(WORD)
                .zip(words)
                .try_for_each(|(at, word)| flash.program_word(at, *word))
        })
    }
}

/// RM0090, "Programming": a word may be written again without an erasure where bits only go from 1 to 0.
impl<I: Interface> MultiwriteNorFlash for Flash<I> {}

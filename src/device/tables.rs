//! Tables that are read and handed over in pieces.

use embedded_storage::nor_flash::NorFlash;

use super::bench::Bench;
use super::service::{Answer, Service, refused};
use super::upload::Upload;
use crate::access::Nonces;
use crate::recalibrate::{Event, Interlock, Stage};
use crate::slot::{SlotHeader, slot_bytes};
use crate::wire::{PIECE_BYTES, PIECE_STEP, Piece, Refusal, Reply, TableFault};

impl<F: NorFlash, N: Nonces, I: Interlock> Service<F, N, I> {
    /// A piece of the slot in use.
    pub fn piece(&mut self, offset: u32) -> Answer {
        let found = self.in_use.ok_or(Refusal::NoTable)?;
        #[allow(clippy::cast_possible_truncation)]
        let whole = slot_bytes(found.header.shape) as u32;
        if offset >= whole || !offset.is_multiple_of(PIECE_STEP) {
            return Err(Refusal::Offset(0));
        }
        let mut bytes = [0; PIECE_BYTES];
        let length = (whole - offset).min(PIECE_BYTES as u32);
        // In whole steps, as the flash may want it; a place has room for them.
        let steps = length.next_multiple_of(PIECE_STEP) as usize;
        let read = bytes.get_mut(..steps).ok_or(Refusal::Flash)?;
        self.store.read(&found, offset, read).map_err(refused)?;
        let given = bytes.get(..length as usize).unwrap_or_default();
        Ok(Reply::Table {
            offset,
            whole,
            piece: Piece::from_slice(given).map_err(|_| Refusal::Flash)?,
        })
    }

    /// The next piece of a table that is handed over.
    pub fn write(
        &mut self,
        offset: u32,
        piece: &[u8],
        now_ms: u64,
        bench: &mut impl Bench,
    ) -> Answer {
        let stage = self.machine.stage();
        if !matches!(stage, Stage::Idle | Stage::Done | Stage::Failed(_)) {
            return Err(Refusal::Stage(stage));
        }
        let room = bench.room().ok_or(Refusal::Stage(stage))?;
        let fresh = || Upload::new(self.config.shape);
        let upload = if offset == 0 {
            self.upload.insert(fresh())
        } else {
            self.upload.get_or_insert_with(fresh)
        };
        if offset != upload.next() {
            return Err(Refusal::Offset(upload.next()));
        }
        upload.take(piece, room);
        let (next, whole) = (upload.next(), upload.is_whole());
        if whole {
            let checked = upload.check(room);
            self.upload = None;
            let header = checked.map_err(Refusal::Table)?;
            self.fits(&header).map_err(Refusal::Table)?;
            self.loaded = Some(header);
            self.tell(Event::Loaded, now_ms, bench)?;
        }
        Ok(Reply::Written { next, whole })
    }

    /// Whether a table is this encoder's.
    fn fits(&self, header: &SlotHeader) -> Result<(), TableFault> {
        let (own, given) = (self.config.serial, header.stamp.serial);
        if own != 0 && given != 0 && own != given {
            return Err(TableFault::Encoder);
        }
        if !header.indexed {
            return Err(TableFault::Header);
        }
        let delays = header.delays.at_clock(self.config.clock_hz);
        delays.map(drop).ok_or(TableFault::Clock)
    }
}

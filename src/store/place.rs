//! One place: what it holds, and the steps by which it gets a table.

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

use super::StoreError;
use super::layout::{MARK, MARK_BYTES, PlaceRange, SLOT_AT, VALID_AT, WEAR_AT, WITHDRAWN_AT};
use crate::slot::{self, SlotError, SlotHeader};
use crate::table::Entry;

type Mark = [u8; MARK_BYTES];

const BLANK: Mark = [0xFF; MARK_BYTES];
const WITHDRAWN: Mark = [0; MARK_BYTES];
const VALID: Mark = mark(*b"QCOK");

const fn mark(word: [u8; 4]) -> Mark {
    let mut mark = BLANK;
    let mut i = 0;
    while i < word.len() {
        mark[i] = word[i];
        i += 1;
    }
    mark
}

/// What is at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Condition {
    /// Nothing was written since it was erased, or writing did not come to its end.
    Unfinished,
    /// A table that was taken out of use.
    Withdrawn,
    /// Marked valid, but the slot is damaged.
    Damaged(SlotError),
    /// A table.
    Valid(SlotHeader),
}

fn read_mark<F: ReadNorFlash>(
    flash: &mut F,
    place: &PlaceRange,
    at: u32,
) -> Result<Mark, F::Error> {
    let mut mark = BLANK;
    flash.read(place.start + at, &mut mark)?;
    Ok(mark)
}

pub(super) fn condition<F: ReadNorFlash>(
    flash: &mut F,
    place: &PlaceRange,
) -> Result<Condition, F::Error> {
    if read_mark(flash, place, VALID_AT)? != VALID {
        return Ok(Condition::Unfinished);
    }
    if read_mark(flash, place, WITHDRAWN_AT)? != BLANK {
        return Ok(Condition::Withdrawn);
    }
    let start = place.start + SLOT_AT;
    let room = place.length.saturating_sub(SLOT_AT) as usize;
    #[allow(clippy::cast_possible_truncation)]
    let checked = slot::check(room, |at, piece| flash.read(start + at as u32, piece))?;
    Ok(match checked {
        Ok((header, _)) => Condition::Valid(header),
        Err(error) => Condition::Damaged(error),
    })
}

/// Times that a place was erased, where its count is whole.
pub(super) fn wear<F: ReadNorFlash>(
    flash: &mut F,
    place: &PlaceRange,
) -> Result<Option<u32>, F::Error> {
    let mark = read_mark(flash, place, WEAR_AT)?;
    let [a, b, c, d, e, f, g, h, ..] = mark;
    let (count, complement) = (
        u32::from_le_bytes([a, b, c, d]),
        u32::from_le_bytes([e, f, g, h]),
    );
    Ok((count == !complement).then_some(count))
}

/// Takes a place out of use, if it is not out of use already: a mark is written once.
pub(super) fn withdraw<F: NorFlash>(
    flash: &mut F,
    place: &PlaceRange,
) -> Result<(), StoreError<F::Error>> {
    if read_mark(flash, place, WITHDRAWN_AT).map_err(StoreError::Flash)? != BLANK {
        return Ok(());
    }
    let at = place.start + WITHDRAWN_AT;
    flash.write(at, &WITHDRAWN).map_err(StoreError::Flash)
}

/// A place that is being written.
pub(super) struct Writer<'a, F> {
    flash: &'a mut F,
    place: PlaceRange,
}

impl<'a, F: NorFlash> Writer<'a, F> {
    /// Erases the place.
    pub fn erase(flash: &'a mut F, place: PlaceRange) -> Result<Self, StoreError<F::Error>> {
        flash
            .erase(place.start, place.start + place.length)
            .map_err(StoreError::Flash)?;
        Ok(Self { flash, place })
    }

    fn write(&mut self, at: u32, mark: &Mark) -> Result<(), StoreError<F::Error>> {
        let at = self.place.start + at;
        self.flash.write(at, mark).map_err(StoreError::Flash)
    }

    /// Notes how often the place was erased.
    pub fn wear(&mut self, count: u32) -> Result<(), StoreError<F::Error>> {
        let mut mark = BLANK;
        let (number, rest) = mark.split_at_mut(4);
        number.copy_from_slice(&count.to_le_bytes());
        rest[..4].copy_from_slice(&(!count).to_le_bytes());
        self.write(WEAR_AT, &mark)
    }

    /// Writes the slot and reads it back.
    pub fn slot<E: Entry>(
        &mut self,
        header: &SlotHeader,
        entries: &[E],
    ) -> Result<(), StoreError<F::Error>> {
        in_marks(header, entries, |at, piece| self.write(SLOT_AT + at, piece))?;
        in_marks(header, entries, |at, piece| {
            let read =
                read_mark(self.flash, &self.place, SLOT_AT + at).map_err(StoreError::Flash)?;
            if read == *piece {
                Ok(())
            } else {
                Err(StoreError::Verify(SLOT_AT + at))
            }
        })
    }

    /// Makes the slot count.
    pub fn validate(&mut self) -> Result<(), StoreError<F::Error>> {
        self.write(VALID_AT, &VALID)
    }
}

/// The bytes of a slot in pieces of a mark, filled up with 0xFF, and where each is.
fn in_marks<E: Entry, X>(
    header: &SlotHeader,
    entries: &[E],
    mut visit: impl FnMut(u32, &Mark) -> Result<(), X>,
) -> Result<(), X> {
    let (mut mark, mut filled, mut at) = (BLANK, 0, 0);
    slot::write(header, entries, |bytes| {
        for byte in bytes {
            if let Some(cell) = mark.get_mut(filled) {
                *cell = *byte;
            }
            filled += 1;
            if filled == MARK_BYTES {
                visit(at, &mark)?;
                (mark, filled) = (BLANK, 0);
                at += MARK;
            }
        }
        Ok(())
    })?;
    if filled == 0 {
        Ok(())
    } else {
        visit(at, &mark)
    }
}

//! Two slots in flash, of which the newest valid one counts, whenever the power fails.
//!
//! A slot's place begins with three marks of [`MARK_BYTES`] each, then come the bytes of [`crate::slot`]:
//!
//! ```text
//! offset  size  field
//!      0    32  valid: "QCOK" and 0xFF, written last, when all else was read back and found right
//!     32    32  withdrawn: 0xFF; anything else takes the slot out of use
//!     64    32  wear: times that this place was erased, its complement, and 0xFF
//!     96     -  the slot
//! ```
//!
//! A mark is written once between two erasures, so flash with a check sum a word takes it as well as flash whose bits only
//! fall. A slot counts if its mark says valid, it is not withdrawn, and its CRC agrees. Committing writes the place that does
//! not count, so the table in use is there until the new one's mark is; rolling back withdraws the newer one. A mark that the
//! power left half written reads as one or the other, and either way one whole table counts.

mod layout;
mod place;

#[cfg(test)]
pub(crate) mod tests;

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

use crate::slot::{SlotHeader, Stamp};
use crate::table::Entry;

pub use layout::{Layout, LayoutError, MARK_BYTES, place_bytes};
pub use place::Condition;

/// One of the two places.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Place {
    /// The first.
    A,
    /// The second.
    B,
}

impl Place {
    /// The other one.
    #[must_use]
    pub const fn other(self) -> Self {
        match self {
            Self::A => Self::B,
            Self::B => Self::A,
        }
    }
}

/// Why the store did not do what it was asked to. `F` is the flash's own error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StoreError<F> {
    /// The flash failed.
    Flash(F),
    /// A slot of this size does not fit its place.
    TooLong {
        /// Bytes that it takes, marks included.
        needed: u32,
        /// Bytes that there are.
        room: u32,
    },
    /// The place was erased as often as the layout allows.
    WornOut {
        /// Times it was erased.
        erased: u32,
    },
    /// What was written does not read back, from this byte of the place on.
    Verify(u32),
    /// There is no older valid table to go back to.
    NothingOlder,
}

/// A table that counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Found {
    /// Where it is.
    pub place: Place,
    /// What it says of itself.
    pub header: SlotHeader,
    /// Offset of the slot's first byte in the flash, for use in place: [`crate::slot::Slot::parse`] takes the mapped bytes.
    pub offset: u32,
}

/// The valid tables.
struct Tables {
    newest: Option<Found>,
    older: Option<Found>,
}

/// Tables in flash.
pub struct Store<F> {
    flash: F,
    layout: Layout,
}

impl<F: ReadNorFlash> Store<F> {
    /// The tables in `flash`, at the places that `layout` gives them. Nothing is read or written yet.
    pub const fn new(flash: F, layout: Layout) -> Self {
        Self { flash, layout }
    }

    /// Gives the flash back.
    pub fn into_flash(self) -> F {
        self.flash
    }

    /// The table that counts: the valid one of the later sequence; none where both places are blank, withdrawn or damaged.
    ///
    /// # Errors
    /// [`StoreError::Flash`] when reading fails.
    pub fn newest(&mut self) -> Result<Option<Found>, StoreError<F::Error>> {
        Ok(self.both()?.newest)
    }

    /// What is at a place.
    ///
    /// # Errors
    /// [`StoreError::Flash`] when reading fails.
    pub fn condition(&mut self, place: Place) -> Result<Condition, StoreError<F::Error>> {
        place::condition(&mut self.flash, &self.layout.of(place)).map_err(StoreError::Flash)
    }

    /// Times that a place was erased; zero where that is not known.
    ///
    /// # Errors
    /// [`StoreError::Flash`] when reading fails.
    pub fn wear(&mut self, place: Place) -> Result<u32, StoreError<F::Error>> {
        let wear = place::wear(&mut self.flash, &self.layout.of(place));
        Ok(wear.map_err(StoreError::Flash)?.unwrap_or(0))
    }

    /// Reads bytes of a table's slot, from byte `offset` of the slot on. Both `offset` and the length are multiples of what the flash is
    /// read in; [`MARK_BYTES`] is one.
    ///
    /// # Errors
    /// [`StoreError::Flash`] when reading fails.
    pub fn read(
        &mut self,
        found: &Found,
        offset: u32,
        bytes: &mut [u8],
    ) -> Result<(), StoreError<F::Error>> {
        let at = found.offset.saturating_add(offset);
        self.flash.read(at, bytes).map_err(StoreError::Flash)
    }

    /// Times that a place may be erased.
    pub const fn erasures_max(&self) -> u32 {
        self.layout.erasures_max
    }

    /// Wear of a place; one whose count was lost to a power cut has been erased about as often as the other.
    fn wear_to_count_from(&mut self, place: Place) -> Result<u32, StoreError<F::Error>> {
        let wear = place::wear(&mut self.flash, &self.layout.of(place));
        match wear.map_err(StoreError::Flash)? {
            Some(wear) => Ok(wear),
            None => self.wear(place.other()),
        }
    }

    /// The newest valid table and the older one.
    fn both(&mut self) -> Result<Tables, StoreError<F::Error>> {
        let (a, b) = (self.found(Place::A)?, self.found(Place::B)?);
        let sequence = |found: &Found| found.header.stamp.sequence;
        let b_counts = b.is_some_and(|b| a.is_none_or(|a| later(sequence(&b), sequence(&a))));
        let (newest, older) = if b_counts { (b, a) } else { (a, b) };
        Ok(Tables { newest, older })
    }

    fn found(&mut self, place: Place) -> Result<Option<Found>, StoreError<F::Error>> {
        Ok(match self.condition(place)? {
            Condition::Valid(header) => Some(Found {
                place,
                header,
                offset: self.layout.of(place).start + layout::SLOT_AT,
            }),
            _ => None,
        })
    }
}

impl<F: NorFlash> Store<F> {
    /// Writes a table to the place that does not count, reads it back, and only then makes it count. `header.stamp.sequence` is
    /// set here.
    ///
    /// # Errors
    /// [`StoreError`]; the table that counted before still does.
    pub fn commit<E: Entry>(
        &mut self,
        header: &SlotHeader,
        entries: &[E],
    ) -> Result<Found, StoreError<F::Error>> {
        let newest = self.newest()?;
        let place = newest.map_or(Place::A, |found| found.place.other());
        let range = self.layout.of(place);
        let needed = place_bytes(header.shape);
        if needed > range.length {
            return Err(StoreError::TooLong {
                needed,
                room: range.length,
            });
        }
        let wear = self.wear_to_count_from(place)?;
        if wear >= self.layout.erasures_max {
            return Err(StoreError::WornOut { erased: wear });
        }
        let sequence = newest.map_or(0, |found| found.header.stamp.sequence.wrapping_add(1));
        let header = SlotHeader {
            stamp: Stamp {
                sequence,
                ..header.stamp
            },
            ..*header
        };
        let mut writer = place::Writer::erase(&mut self.flash, range)?;
        writer.wear(wear + 1)?;
        writer.slot(&header, entries)?;
        writer.validate()?;
        match self.found(place)? {
            Some(found) if found.header == header => Ok(found),
            _ => Err(StoreError::Verify(0)),
        }
    }

    /// Withdraws the newest table, so that the older one counts again.
    ///
    /// # Errors
    /// [`StoreError::NothingOlder`] where there is none: a table is not taken away without another. [`StoreError::Flash`].
    pub fn roll_back(&mut self) -> Result<Found, StoreError<F::Error>> {
        let Tables {
            newest: Some(newest),
            older: Some(older),
        } = self.both()?
        else {
            return Err(StoreError::NothingOlder);
        };
        place::withdraw(&mut self.flash, &self.layout.of(newest.place))?;
        Ok(older)
    }

    /// Withdraws and erases all tables, the older one first: until the last is withdrawn, it counts.
    ///
    /// # Errors
    /// [`StoreError::Flash`].
    pub fn erase(&mut self) -> Result<(), StoreError<F::Error>> {
        let newest = self.newest()?.map_or(Place::A, |found| found.place);
        for place in [newest.other(), newest] {
            let range = self.layout.of(place);
            let wear = self.wear_to_count_from(place)?;
            place::withdraw(&mut self.flash, &range)?;
            place::Writer::erase(&mut self.flash, range)?.wear(wear + 1)?;
        }
        Ok(())
    }
}

/// Whether sequence `a` comes after `b`; numbers wrap around.
const fn later(a: u32, b: u32) -> bool {
    a.wrapping_sub(b).cast_signed() > 0
}

//! Where the two places are.

use core::ops::Range;

use embedded_storage::nor_flash::NorFlash;

use crate::shape::EncoderShape;
use crate::slot::slot_bytes;

/// Bytes of a mark: the most that flash is written in at once.
pub const MARK_BYTES: usize = 32;

/// [`MARK_BYTES`], as an offset.
pub(super) const MARK: u32 = MARK_BYTES as u32;

/// Where the marks and the slot are in a place.
pub(super) const VALID_AT: u32 = 0;
pub(super) const WITHDRAWN_AT: u32 = MARK;
pub(super) const WEAR_AT: u32 = 2 * MARK;
pub(super) const SLOT_AT: u32 = 3 * MARK;

/// Why places can't be used; places count from zero, offsets are bytes from the flash's start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LayoutError {
    /// A place does not begin and end where the flash can be erased, or is empty.
    Unaligned {
        /// Which place.
        place: usize,
        /// Bytes that the flash is erased in, the smallest sector's where they differ.
        erase: usize,
    },
    /// A place goes beyond the flash.
    Outside {
        /// Which place.
        place: usize,
        /// Bytes of the flash.
        capacity: usize,
    },
    /// The places overlap.
    Overlap,
    /// The flash is read or written in pieces that don't divide [`MARK_BYTES`].
    Pieces {
        /// Bytes that it is read in.
        read: usize,
        /// Bytes that it is written in.
        write: usize,
    },
}

/// One place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PlaceRange {
    pub start: u32,
    pub length: u32,
}

/// Where the two places are, and how often each may be erased.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    places: [PlaceRange; 2],
    /// Erasures that a place may have seen, after which nothing is committed there any more.
    pub(super) erasures_max: u32,
}

impl Layout {
    /// Two places of a flash, in bytes from its start. `erasures_max` is what the flash's data sheet promises, or less.
    ///
    /// # Errors
    /// [`LayoutError`] says which place is wrong and why.
    pub fn new<F: NorFlash>(
        flash: &F,
        places: [Range<u32>; 2],
        erasures_max: u32,
    ) -> Result<Self, LayoutError> {
        let border = |at: u32| (at as usize).is_multiple_of(F::ERASE_SIZE);
        Self::on_sectors(flash, places, erasures_max, border)
    }

    /// The same for a flash whose sectors differ in size, `ERASE_SIZE` being the smallest: `border` says whether a sector begins
    /// or ends at an offset.
    ///
    /// # Errors
    /// [`LayoutError`] says which place is wrong and why.
    pub fn on_sectors<F: NorFlash>(
        flash: &F,
        places: [Range<u32>; 2],
        erasures_max: u32,
        border: impl Fn(u32) -> bool,
    ) -> Result<Self, LayoutError> {
        let divides = |size: usize| size != 0 && MARK_BYTES.is_multiple_of(size);
        if !divides(F::READ_SIZE) || !divides(F::WRITE_SIZE) {
            return Err(LayoutError::Pieces {
                read: F::READ_SIZE,
                write: F::WRITE_SIZE,
            });
        }
        for (place, range) in places.iter().enumerate() {
            if range.is_empty() || !border(range.start) || !border(range.end) {
                return Err(LayoutError::Unaligned {
                    place,
                    erase: F::ERASE_SIZE,
                });
            }
            if range.end as usize > flash.capacity() {
                return Err(LayoutError::Outside {
                    place,
                    capacity: flash.capacity(),
                });
            }
        }
        let [a, b] = &places;
        if a.start < b.end && b.start < a.end {
            return Err(LayoutError::Overlap);
        }
        Ok(Self {
            places: places.map(|range| PlaceRange {
                start: range.start,
                length: range.end - range.start,
            }),
            erasures_max,
        })
    }

    /// Offsets that a slot may take which begins at `offset`: to the end of its place. None where none begins.
    #[must_use]
    pub fn slot_room(&self, offset: u32) -> Option<Range<u32>> {
        let holds = |place: &&PlaceRange| place.start + SLOT_AT == offset;
        let place = self.places.iter().find(holds)?;
        Some(offset..place.start + place.length)
    }

    pub(super) const fn of(&self, place: super::Place) -> PlaceRange {
        self.places[place as usize]
    }
}

/// Bytes of a place that a slot takes, marks included.
#[must_use]
#[allow(clippy::cast_possible_truncation)]
pub const fn place_bytes(shape: EncoderShape) -> u32 {
    SLOT_AT + (slot_bytes(shape) as u32).next_multiple_of(MARK)
}

//! The error table: what is subtracted from the grid angle of an edge to get the shaft's.

use crate::shape::{CLASSES_MAX, EncoderShape, Grid};
use crate::units::{Turn32, TurnDelta32};

/// A table's entries do not match the encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TableError {
    /// Number of entries that is not the edges of a turn.
    Length(usize),
    /// A scale that shifts entries out of 32 bits.
    Shift(u32),
}

/// One stored entry of a table: a word in RAM, or two bytes of a slot, least significant first.
pub trait Entry: Copy {
    /// The entry's value.
    fn value(self) -> i16;
}

impl Entry for i16 {
    #[inline]
    fn value(self) -> i16 {
        self
    }
}

impl Entry for [u8; 2] {
    #[inline]
    fn value(self) -> i16 {
        i16::from_le_bytes(self)
    }
}

/// A view of an error table, wherever its entries are (RAM or memory-mapped flash):
/// error of edge k = class offset + (entry k << shift), in 2^-32 turn.
#[derive(Clone, Copy, Debug)]
pub struct ErrorTable<'a, E: Entry = i16> {
    grid: Grid,
    class_offsets: [TurnDelta32; CLASSES_MAX],
    entries: &'a [E],
    /// `1 << shift`.
    scale: i32,
}

impl<'a, E: Entry> ErrorTable<'a, E> {
    /// A table of `entries`, one an edge, scaled by `1 << shift`.
    ///
    /// # Errors
    /// [`TableError`] when the number of entries or the scale does not fit.
    pub const fn new(
        shape: EncoderShape,
        class_offsets: [TurnDelta32; CLASSES_MAX],
        entries: &'a [E],
        shift: u32,
    ) -> Result<Self, TableError> {
        if entries.len() != shape.edges() as usize {
            return Err(TableError::Length(entries.len()));
        }
        if shift > 16 {
            return Err(TableError::Shift(shift));
        }
        Ok(Self {
            grid: Grid::new(shape),
            class_offsets,
            entries,
            scale: 1 << shift,
        })
    }

    /// A table that corrects nothing.
    pub(crate) const fn of_grid(grid: Grid) -> Self {
        Self {
            grid,
            class_offsets: [TurnDelta32(0); CLASSES_MAX],
            entries: &[],
            scale: 1,
        }
    }

    pub(crate) const fn grid(&self) -> Grid {
        self.grid
    }

    /// The encoder's shape.
    #[must_use]
    pub const fn shape(&self) -> EncoderShape {
        self.grid.shape()
    }

    /// Mean error of every class; those beyond C are zero.
    #[must_use]
    pub const fn class_offsets(&self) -> &[TurnDelta32; CLASSES_MAX] {
        &self.class_offsets
    }

    /// Line position errors in `1 << shift` of 2^-32 turn.
    #[must_use]
    pub const fn entries(&self) -> &'a [E] {
        self.entries
    }

    /// Scale of the entries.
    #[must_use]
    pub const fn shift(&self) -> u32 {
        self.scale.trailing_zeros()
    }

    /// Error e(k) of an edge. Before the index is seen (`referenced` false) only the class is known, and only its mean
    /// is given.
    #[inline]
    #[must_use]
    pub fn error(&self, edge: u32, referenced: bool) -> TurnDelta32 {
        let class = self.grid.class(edge) as usize;
        let offset = self.class_offsets.get(class).map_or(0, |offset| offset.0);
        if !referenced {
            return TurnDelta32(offset);
        }
        self.error_of(self.entries, edge, offset)
    }

    /// Error of an edge of a class with mean `offset`, by `entries`; none of them: its class's mean.
    #[inline]
    fn error_of(&self, entries: &[E], edge: u32, offset: i32) -> TurnDelta32 {
        let entry = entries
            .get(edge as usize)
            .map_or(0, |&entry| i32::from(entry.value()));
        TurnDelta32(offset.wrapping_add(entry.wrapping_mul(self.scale)))
    }

    /// Class means by the last two bits of an edge's number, where classes are a power of two.
    pub(crate) fn offsets_by_bits(&self) -> Option<[TurnDelta32; 4]> {
        let classes = self.shape().classes() as usize;
        let of_bits = |bits: usize| self.class_offsets[bits % classes];
        classes
            .is_power_of_two()
            .then(|| core::array::from_fn(of_bits))
    }

    /// Shaft angle at an edge of a class with mean `offset`, by `entries`.
    #[inline]
    pub(crate) fn angle_with(&self, edge: u32, offset: TurnDelta32, entries: &[E]) -> Turn32 {
        let error = self.error_of(entries, edge, offset.0);
        self.grid
            .angle(edge)
            .plus(TurnDelta32(error.0.wrapping_neg()))
    }

    /// Shaft angle at an edge.
    #[inline]
    #[must_use]
    pub fn angle(&self, edge: u32, referenced: bool) -> Turn32 {
        let error = self.error(edge, referenced);
        self.grid
            .angle(edge)
            .plus(TurnDelta32(error.0.wrapping_neg()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn offsets() -> [TurnDelta32; CLASSES_MAX] {
        [
            TurnDelta32(-30),
            TurnDelta32(10),
            TurnDelta32(15),
            TurnDelta32(5),
            TurnDelta32(0),
            TurnDelta32(0),
        ]
    }

    #[test]
    fn before_the_index_only_the_class_is_corrected() {
        let entries = [100, -100, 7, 8, 0, 0, 0, 0];
        let shape = EncoderShape::new(8, 4).unwrap();
        let table = ErrorTable::new(shape, offsets(), &entries, 2).unwrap();
        assert_eq!(table.error(1, false), TurnDelta32(10));
        assert_eq!(table.error(1, true), TurnDelta32(10 - 400));
        assert_eq!(table.angle(2, true), Turn32((1 << 30) - 15 - 28));
        assert_eq!(table.angle(0, true), Turn32(0_u32.wrapping_sub(400 - 30)));
    }

    #[test]
    fn a_table_of_another_length_or_scale_is_refused() {
        let shape = EncoderShape::new(8, 4).unwrap();
        assert_eq!(
            ErrorTable::new(shape, offsets(), &[0; 7], 2).unwrap_err(),
            TableError::Length(7)
        );
        assert_eq!(
            ErrorTable::new(shape, offsets(), &[0; 8], 17).unwrap_err(),
            TableError::Shift(17)
        );
    }

    proptest! {
        #[test]
        fn any_edge_number_is_answered(edge in any::<u32>(), entry in any::<i16>(), shift in 0_u32..=16) {
            let entries = [entry; 12];
            let shape = EncoderShape::new(12, 6).unwrap();
            let table = ErrorTable::new(shape, offsets(), &entries, shift).unwrap();
            let error = table.error(edge, true).0;
            prop_assert!((error - (i32::from(entry) << shift)).abs() <= 30 || edge >= 12);
            prop_assert!(table.error(edge, false).0.abs() <= 30);
        }
    }
}

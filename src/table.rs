//! The error table: what is subtracted from the grid angle of an edge to get the shaft's, and from its time.
//!
//! # Delays
//! An edge is captured some time after the mark on the disc passed the head. What all edges have in common can't be told from
//! the shaft's own position, so only the differences between edge classes are kept, and they sum to zero. A delay belongs to
//! the electrical edge, an error to the mark: passed in reverse, the mark at which A rises makes A fall, with that edge's delay.

use crate::edge::Direction;
use crate::shape::{CLASSES_MAX, EncoderShape, Grid};
use crate::step::Flags;
use crate::units::{TickDelta8, Turn32, TurnDelta32};

/// A table's entries do not match the encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TableError {
    /// Number of entries that is not the edges of a turn.
    Length(usize),
    /// A scale that shifts entries out of 32 bits.
    Shift(u32),
    /// Delays for a clock of 0 Hz, or too long for ticks of the clock asked for, in hertz.
    Clock(u64),
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

/// What an edge has from its class, in one direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OfClass {
    /// Mean error.
    pub offset: TurnDelta32,
    /// Delay of the capture.
    pub delay: Delay,
}

/// What the delays do to an edge's time and to the interval before it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Delay {
    /// How late the edge is captured.
    pub late: TickDelta8,
    /// By how much that is more than for the edge before.
    pub stretch: TickDelta8,
}

impl OfClass {
    /// Nothing.
    pub const NONE: Self = Self {
        offset: TurnDelta32(0),
        delay: Delay::NONE,
    };
}

impl Delay {
    const NONE: Self = Self {
        late: TickDelta8::ZERO,
        stretch: TickDelta8::ZERO,
    };
}

/// Largest scale of entries: more than any error needs.
pub(crate) const SHIFT_MAX: u32 = 16;

const NO_DELAYS: [TickDelta8; CLASSES_MAX] = [TickDelta8::ZERO; CLASSES_MAX];

/// A view of an error table, wherever its entries are (RAM or memory-mapped flash):
/// error of edge k = class offset + (entry k << shift), in 2^-32 turn.
#[derive(Clone, Copy, Debug)]
pub struct ErrorTable<'a, E: Entry = i16> {
    grid: Grid,
    class_offsets: [TurnDelta32; CLASSES_MAX],
    /// Zero beyond C.
    class_delays: [TickDelta8; CLASSES_MAX],
    /// Whether any of them is not zero.
    has_delays: bool,
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
        if shift > SHIFT_MAX {
            return Err(TableError::Shift(shift));
        }
        Ok(Self {
            grid: Grid::new(shape),
            class_offsets,
            class_delays: NO_DELAYS,
            has_delays: false,
            entries,
            scale: 1 << shift,
        })
    }

    /// This table with a delay for every edge class, in ticks of the clock that will stamp the edges; those beyond C are ignored.
    #[must_use]
    pub const fn with_delays(mut self, class_delays: [TickDelta8; CLASSES_MAX]) -> Self {
        self.class_delays = class_delays;
        self.has_delays = false;
        let mut class = 0;
        while class < CLASSES_MAX {
            self.has_delays |= class_delays[class].0 != 0;
            class += 1;
        }
        self
    }

    /// The same without its entries, for those who hand them to [`Self::angle_with`].
    #[cfg(feature = "device")]
    pub(crate) const fn without_entries(&self) -> ErrorTable<'static, i16> {
        ErrorTable {
            grid: self.grid,
            class_offsets: self.class_offsets,
            class_delays: self.class_delays,
            has_delays: self.has_delays,
            entries: &[],
            scale: self.scale,
        }
    }

    /// A table that corrects nothing.
    pub(crate) const fn of_grid(grid: Grid) -> Self {
        Self {
            grid,
            class_offsets: [TurnDelta32(0); CLASSES_MAX],
            class_delays: NO_DELAYS,
            has_delays: false,
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

    /// Whether any class is captured later than another.
    #[must_use]
    pub const fn has_delays(&self) -> bool {
        self.has_delays
    }

    /// How much later than the mean of all classes each electrical edge is captured; see the [module's](self) head.
    #[must_use]
    pub const fn class_delays(&self) -> &[TickDelta8; CLASSES_MAX] {
        &self.class_delays
    }

    /// Delay of the capture of an edge crossed in a direction.
    #[inline]
    #[must_use]
    pub fn delay(&self, edge: u32, direction: Direction) -> TickDelta8 {
        if !self.has_delays {
            return TickDelta8::ZERO;
        }
        let class = self.grid.class(edge) as usize;
        let class = match direction {
            Direction::Forward => class,
            Direction::Reverse => self.opposite(class),
        };
        self.class_delays.get(class).copied().unwrap_or_default()
    }

    /// Delay of a step's edge, and by how much it is more than that of the edge before.
    pub(crate) fn delay_after(&self, edge: u32, direction: Direction, flags: Flags) -> Delay {
        if !self.has_delays {
            return Delay::NONE;
        }
        let late = self.delay(edge, direction);
        let before = if flags.intersects(Flags::FIRST.with(Flags::ILLEGAL)) {
            // Which edge was before is not known.
            late
        } else if flags.contains(Flags::REVERSED) {
            self.delay(edge, direction.opposite())
        } else {
            // The first and the last class of a line meet at its end.
            let last = self.shape().classes() - 1;
            match direction {
                Direction::Forward if self.grid.class(edge) == 0 => self.delay(last, direction),
                Direction::Forward => self.delay(edge.wrapping_sub(1), direction),
                Direction::Reverse if self.grid.class(edge) == last => self.delay(0, direction),
                Direction::Reverse => self.delay(edge.wrapping_add(1), direction),
            }
        };
        Delay {
            late,
            stretch: late.minus(before),
        }
    }

    /// The class of the same channel's other edge: half of the classes on. With an odd number of classes there is none, and the
    /// class stands for itself.
    #[inline]
    const fn opposite(&self, class: usize) -> usize {
        let classes = self.shape().classes() as usize;
        let on = class + classes / 2;
        if classes % 2 == 1 {
            class
        } else if on >= classes {
            on - classes
        } else {
            on
        }
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

    /// What each class has of its own for a direction, by the last two bits of an edge's number, where classes are a power of two.
    pub(crate) fn classes_by_bits(&self, direction: Direction) -> Option<[OfClass; 4]> {
        let classes = self.shape().classes();
        let of_bits = |bits: usize| {
            let edge = bits as u32;
            OfClass {
                offset: self.error(edge, false),
                delay: self.delay_after(edge, direction, Flags::NONE),
            }
        };
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
mod tests;

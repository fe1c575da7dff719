//! Where a learner has its memory from, and where it goes in between.

use core::cell::Cell;
use core::mem;

use crate::estimate::{EdgeBuffers, Parts};

/// Hands out memory to learn in. What was dropped can be had again, so no memory is lost however learning ends.
pub trait LearnerMemory {
    /// The memory.
    type Buffers: EdgeBuffers;

    /// Takes it; none while it is out.
    fn take(&mut self) -> Option<Self::Buffers>;
}

/// Keeps memory that there is once, as a `static`'s: lent to one at a time, and back on the shelf when that one drops it.
pub struct Shelf<'m> {
    parts: Cell<Option<Parts<'m>>>,
}

/// Memory of a [`Shelf`].
pub struct Lent<'s, 'm> {
    parts: Parts<'m>,
    shelf: &'s Shelf<'m>,
}

impl<'m> Shelf<'m> {
    /// With these buffers on it.
    pub fn new<B: EdgeBuffers>(buffers: &'m mut B) -> Self {
        Self {
            parts: Cell::new(Some(buffers.parts())),
        }
    }
}

impl<'s, 'm> LearnerMemory for &'s Shelf<'m> {
    type Buffers = Lent<'s, 'm>;

    fn take(&mut self) -> Option<Lent<'s, 'm>> {
        let parts = self.parts.take()?;
        Some(Lent { parts, shelf: self })
    }
}

impl EdgeBuffers for Lent<'_, '_> {
    #[inline]
    fn parts(&mut self) -> Parts<'_> {
        Parts {
            sum: self.parts.sum,
            cells: self.parts.cells,
            coarse: self.parts.coarse,
        }
    }

    fn cells(&self) -> &[i16] {
        self.parts.cells
    }

    fn edges(&self) -> usize {
        self.parts.sum.len()
    }
}

impl Drop for Lent<'_, '_> {
    fn drop(&mut self) {
        self.shelf.parts.set(Some(Parts {
            sum: mem::take(&mut self.parts.sum),
            cells: mem::take(&mut self.parts.cells),
            coarse: mem::take(&mut self.parts.coarse),
        }));
    }
}

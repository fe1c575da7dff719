//! Whether the table goes on fitting: one block at a time at the place it should be.

use super::block::{BLOCK_EDGES, CONTRASTS};
use super::hunt::{Scale, Window};
use super::odds::{BIT, Bits, likelier};
use super::trail::{Trail, wrap};
use crate::table::Entry;

/// Evidence kept at the most, so that sums can't overflow.
const BITS_MAX: Bits = 1000 * BIT;

/// Sums up evidence for and against the table at one place (CUSUM: evidence against it never falls below none).
#[derive(Clone, Copy, Debug)]
pub(super) struct Watch {
    /// From the decoder's numbers to the table's.
    offset: u32,
    /// Intervals of the trail when a block was last looked at.
    seen: u32,
    /// Evidence that the table fits, since the watch began.
    pub fits: Bits,
    /// Evidence that it has stopped fitting.
    pub misfits: Bits,
}

impl Watch {
    /// A watch where the table's edge is the decoder's plus `offset`, on blocks after interval `seen`.
    pub const fn new(offset: u32, seen: u32) -> Self {
        Self {
            offset,
            seen,
            fits: 0,
            misfits: 0,
        }
    }

    /// Looks at the newest block if all of it is new.
    pub fn look<const W: usize, E: Entry>(
        &mut self,
        trail: &Trail<W>,
        entries: &[E],
        scale: &Scale,
    ) {
        let count = trail.count();
        // The search may have set its mark three edges ahead.
        if count.saturating_add(3) < self.seen {
            self.seen = 0;
        }
        if count.saturating_sub(self.seen) < BLOCK_EDGES + 3 {
            return;
        }
        let Ok(window) = Window::<1>::load(trail, scale) else {
            return;
        };
        self.seen = count;
        let first = wrap(window.first + self.offset, scale.slots);
        let (Some(left), _) = window.residual(entries, first, u64::MAX) else {
            return;
        };
        #[allow(clippy::cast_possible_truncation)]
        let bits = likelier(left, window.energy(), CONTRASTS as u32);
        self.fits = (self.fits + bits).clamp(-BITS_MAX, BITS_MAX);
        self.misfits = (self.misfits - bits).clamp(0, BITS_MAX);
    }
}

//! Errors as the table keeps them: 2^-32 turn, in 16-bit entries of a common scale.

use core::task::{Poll, ready};

use super::Parts;
use super::cursor::Cursor;
use super::scale::Fine;
use crate::shape::CLASSES_MAX;
use crate::units::TurnDelta32;
use crate::wide::over;

/// RMS of what varies within the classes and of their means together.
pub(super) fn with_offsets(rms: u32, class_offsets: &[TurnDelta32]) -> u32 {
    let square = |x: u32| u128::from(x) * u128::from(x);
    let offsets = class_offsets
        .iter()
        .map(|offset| square(offset.0.unsigned_abs()));
    let mean = over(offsets.sum(), class_offsets.len().max(1) as u128);
    u32::try_from((square(rms) + mean).isqrt()).unwrap_or(u32::MAX)
}

/// Edges of a slice: measured, and packed.
const MEASURED: usize = 250;
const PACKED: usize = 800;

/// Lines that are measured in a slice at the most: with few classes they cost more than their edges.
const LINES: usize = 150;

/// Scales the errors to 2^-32 turn and packs them as 16-bit entries in the cells.
#[derive(Default)]
pub(super) struct Packing {
    /// The entries' shift, once the largest error is known.
    shift: Option<u32>,
    largest: u32,
    /// Sum of the whole table's squares.
    squares: u128,
    cursor: Cursor,
}

/// What is found of the table as a whole.
#[derive(Clone, Copy)]
pub(super) struct Packed {
    /// Scale of the entries.
    pub shift: u32,
    /// RMS of the table, class offsets included, 2^-32 turn.
    pub rms: u32,
}

impl Packing {
    #[inline(never)]
    pub(super) fn slice(
        &mut self,
        parts: &mut Parts<'_>,
        fine: Fine,
        class_offsets: &[TurnDelta32; CLASSES_MAX],
        classes: usize,
    ) -> Poll<Packed> {
        let edges = parts.sum.len();
        let Some(shift) = self.shift else {
            let lines = edges / classes;
            let stretch = self.cursor.next((MEASURED / classes).min(LINES), lines);
            let stretch = &mut parts.sum[stretch.start * classes..stretch.end * classes];
            for line in stretch.chunks_exact_mut(classes) {
                for (entry, offset) in line.iter_mut().zip(class_offsets) {
                    *entry = fine.angle(*entry);
                    self.largest = self.largest.max(entry.unsigned_abs());
                    let error = entry.saturating_add(offset.0).unsigned_abs();
                    self.squares += u128::from(u64::from(error) * u64::from(error));
                }
            }
            ready!(self.cursor.at_end(lines));
            let digits = u32::BITS - self.largest.leading_zeros();
            self.shift = Some(digits.saturating_sub(15));
            self.cursor = Cursor::START;
            return Poll::Pending;
        };
        let half = 1_i32 << shift >> 1;
        let stretch = self.cursor.next(PACKED, edges);
        for (cell, &entry) in parts.cells[stretch.clone()]
            .iter_mut()
            .zip(&parts.sum[stretch])
        {
            let rounded = entry.saturating_add(half) >> shift;
            #[allow(clippy::cast_possible_truncation)]
            let packed = rounded.min(i32::from(i16::MAX)) as i16;
            *cell = packed;
        }
        ready!(self.cursor.at_end(edges));
        let rms = over(self.squares, edges.max(1) as u128).isqrt();
        Poll::Ready(Packed {
            shift,
            rms: u32::try_from(rms).unwrap_or(u32::MAX),
        })
    }
}

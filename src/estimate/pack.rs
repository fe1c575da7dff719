//! Errors as the table keeps them: 2^-32 turn, in 16-bit entries of a common scale.

use super::Parts;
use super::scale::Fine;
use crate::shape::CLASSES_MAX;
use crate::units::TurnDelta32;

/// RMS of what varies within the classes and of their means together.
pub(super) fn with_offsets(rms: u32, class_offsets: &[TurnDelta32]) -> u32 {
    let square = |x: u32| u128::from(x) * u128::from(x);
    let offsets = class_offsets
        .iter()
        .map(|offset| square(offset.0.unsigned_abs()));
    let mean = offsets.sum::<u128>() / class_offsets.len().max(1) as u128;
    u32::try_from((square(rms) + mean).isqrt()).unwrap_or(u32::MAX)
}

/// Scales the errors to 2^-32 turn and packs them as 16-bit entries in the cells; returns their shift, and the RMS of the
/// whole table.
#[inline(never)]
pub(super) fn pack(
    parts: &mut Parts<'_>,
    fine: Fine,
    class_offsets: &[TurnDelta32; CLASSES_MAX],
    classes: usize,
) -> (u32, u32) {
    let mut largest = 0;
    let mut squares = 0_u128;
    for line in parts.sum.chunks_mut(classes) {
        for (entry, offset) in line.iter_mut().zip(class_offsets) {
            *entry = fine.angle(*entry);
            largest = largest.max(entry.unsigned_abs());
            let error = (i64::from(*entry) + i64::from(offset.0)).unsigned_abs();
            squares += u128::from(error) * u128::from(error);
        }
    }
    let shift = (u32::BITS - largest.leading_zeros()).saturating_sub(15);
    let half = 1_i32 << shift >> 1;
    for (cell, &entry) in parts.cells.iter_mut().zip(&*parts.sum) {
        let rounded = entry.saturating_add(half) >> shift;
        #[allow(clippy::cast_possible_truncation)]
        let packed = rounded.min(i32::from(i16::MAX)) as i16;
        *cell = packed;
    }
    let table_rms = (squares / parts.sum.len().max(1) as u128).isqrt();
    (shift, u32::try_from(table_rms).unwrap_or(u32::MAX))
}

//! Errors as they are at the mean speed: an interval's share of error scales with the local speed.
//!
//! An interval is (1 - d) (1 + v) steps long in time, with d the step of the error over it and v the slowness of the shaft
//! there. The sum of intervals has -d + v - d v; the motion found at low orders is v, and d v, the amplitude modulation
//! of the encoder's pattern by the speed (eq. (5)), is put back here.

use super::close::rounded_quotient;
use super::spectrum::Sequence;
use crate::shape::CLASSES_MAX;

/// Puts d v back into `errors` (class means `offsets` apart), closed over the turn. `motion` is what was taken out of the
/// errors as motion, with its sign turned, in `2^-bits` of their unit, in which one step is `step`.
pub(super) fn undo_modulation<S: Sequence + ?Sized>(
    errors: &mut [i32],
    offsets: [i32; CLASSES_MAX],
    classes: usize,
    motion: &S,
    bits: u32,
    step: i64,
) {
    let edges = errors.len();
    let unit = step << bits;
    let total = modulation(errors, offsets, classes, motion, |_, _, _| {});
    let count = edges as i64;
    modulation(errors, offsets, classes, motion, |errors, edge, sum| {
        let trend = rounded_quotient(total, count) * edge as i64;
        #[allow(clippy::cast_possible_truncation)]
        let put_back = rounded_quotient(sum - trend, unit) as i32;
        errors[edge] = errors[edge].wrapping_add(put_back);
    });
}

/// Runs around the turn from edge 1 to edge 0 and sums the products of the steps of error and of motion; hands `visit` each
/// edge with the sum up to it, and returns the whole.
fn modulation<S: Sequence + ?Sized>(
    errors: &mut [i32],
    offsets: [i32; CLASSES_MAX],
    classes: usize,
    motion: &S,
    mut visit: impl FnMut(&mut [i32], usize, i64),
) -> i64 {
    let Some(&first) = errors.first() else {
        return 0;
    };
    let start = i64::from(first) + i64::from(offsets[0]);
    let (mut before, mut motion_before) = (start, i64::from(motion.get(0)));
    let mut class = 0;
    let mut sum = 0_i64;
    for edge in 1..errors.len() {
        class = if class + 1 == classes { 0 } else { class + 1 };
        let error = i64::from(errors[edge]) + i64::from(offsets[class]);
        let motion_here = i64::from(motion.get(edge));
        sum = sum.saturating_sub((error - before) * (motion_here - motion_before));
        (before, motion_before) = (error, motion_here);
        visit(errors, edge, sum);
    }
    sum.saturating_sub((start - before) * (i64::from(motion.get(0)) - motion_before))
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    #[test]
    fn a_pattern_modulated_by_a_known_swing_comes_back() {
        let edges = 400_usize;
        let step = 1_i64 << 18;
        let angle =
            |k: usize, order: f64| (core::f64::consts::TAU * order * k as f64 / edges as f64).sin();
        // Errors of 20 % of a step at order 90 and a speed swing of 10 % at order 3, all in time.
        let truth: Vec<f64> = (0..edges)
            .map(|k| 0.2 * step as f64 * angle(k, 90.0))
            .collect();
        let swing = 0.1 * step as f64 * edges as f64 / (core::f64::consts::TAU * 3.0);
        let motion: Vec<f64> = (0..edges).map(|k| swing * angle(k, 3.0)).collect();
        let mut measured = std::vec![0.0];
        for k in 1..edges {
            let slowness = (motion[k] - motion[k - 1]) / step as f64;
            measured.push(measured[k - 1] + (truth[k] - truth[k - 1]) * (1.0 + slowness));
        }
        // What is taken out of the error is the motion with its sign turned.
        let taken: Vec<i32> = motion.iter().map(|m| (4.0 * m) as i32).collect();
        let off = |errors: &[i32]| {
            errors
                .iter()
                .zip(&truth)
                .map(|(e, t)| (f64::from(*e) - t).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        let mut errors: Vec<i32> = measured.iter().map(|e| *e as i32).collect();
        let before = off(&errors);
        undo_modulation(&mut errors, [0; CLASSES_MAX], 1, taken.as_slice(), 2, step);
        // What is left is the swing squared.
        assert!(off(&errors) < 0.15 * before, "{} {before}", off(&errors));
    }
}

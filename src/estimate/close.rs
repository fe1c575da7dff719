//! From summed deviations to a closed turn: every edge's error, with the mean speed and the class means taken out.

use super::scale::{Fine, Ratio};
use crate::shape::CLASSES_MAX;

/// How a sum over turns becomes angle: it counts 2^`unit_shift` of 2^-32 turn, for turns of `weight_q16` together.
#[derive(Clone, Copy)]
pub(super) struct SumScale {
    pub unit_shift: u32,
    pub weight_q16: u64,
}

impl SumScale {
    /// Factor to 2^-(32 + bits) turn.
    fn ratio(self, bits: u32) -> Ratio {
        Ratio::new(self.unit_shift + 16 + bits, self.weight_q16)
    }
}

/// Runs along the deviations in `slots` (slot 0 is the turn's last), hands `visit` each edge and its error in the sums'
/// unit; edge 0 is the origin and the turn is closed.
fn run(slots: &mut [i32], mut visit: impl FnMut(&mut i32, i64)) {
    let Some((last, rest)) = slots.split_first_mut() else {
        return;
    };
    let count = rest.len() as i64 + 1;
    let total = rest.iter().map(|&x| i64::from(x)).sum::<i64>() + i64::from(*last);
    // The mean step as a whole number and a fraction in Q32.
    let (whole, part) = (total.div_euclid(count), total.rem_euclid(count));
    let part_q32 = (part << 32) / count;
    visit(last, 0);
    let (mut sum, mut fraction) = (0_i64, 0_i64);
    for entry in rest {
        sum += i64::from(*entry) - whole;
        fraction += part_q32;
        visit(entry, (fraction >> 32) - sum);
    }
}

/// Largest error of a turn before its deviations are closed, 2^-32 turn.
pub(super) fn largest_error(sum: &mut [i32], scale: SumScale) -> u64 {
    let mut largest = 0;
    run(sum, |_, error| largest = largest.max(error.unsigned_abs()));
    // The class means are still in; what they leave of the range is not worth a second look.
    scale.ratio(0).times(largest.cast_signed()).unsigned_abs()
}

/// Turns the summed deviations of a turn into each edge's error in fine angles. Of one half of the coarse sums, with its last
/// block first, the same makes the errors at the blocks' first edges.
pub(super) fn close_sum(sum: &mut [i32], scale: SumScale, fine: Fine) {
    let ratio = scale.ratio(fine.bits);
    run(sum, |entry, error| *entry = saturated(ratio.times(error)));
}

/// Takes the mean of every class out of a turn and returns the means less their own mean.
pub(super) fn take_class_means(errors: &mut [i32], classes: usize) -> [i32; CLASSES_MAX] {
    let lines = (errors.len() / classes.max(1)).max(1) as i64;
    let mut sums = [0_i64; CLASSES_MAX];
    for line in errors.chunks(classes) {
        for (sum, &error) in sums.iter_mut().zip(line) {
            *sum += i64::from(error);
        }
    }
    let mut means = sums.map(|sum| saturated(rounded_quotient(sum, lines)));
    for line in errors.chunks_mut(classes) {
        for (error, mean) in line.iter_mut().zip(means) {
            *error = error.saturating_sub(mean);
        }
    }
    let total: i64 = means[..classes].iter().map(|&mean| i64::from(mean)).sum();
    let middle = saturated(rounded_quotient(total, classes as i64));
    for mean in &mut means[..classes] {
        *mean -= middle;
    }
    means
}

/// `value` as 32 bits, capped.
#[allow(clippy::cast_possible_truncation)]
pub(super) fn saturated(value: i64) -> i32 {
    value.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32
}

/// Quotient to the nearest integer, halves up.
pub(super) fn rounded_quotient(numerator: i64, denominator: i64) -> i64 {
    (2 * numerator + denominator).div_euclid(2 * denominator)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    #[test]
    fn a_pattern_comes_back_from_its_steps_whatever_the_mean_step() {
        let error = |k: usize| 1000.0 * (k as f64 * 0.9).sin();
        let mut sum: Vec<i32> = (0..50_usize)
            .map(|k| 700 - (error(k) - error((k + 49) % 50)) as i32)
            .collect();
        let scale = SumScale {
            unit_shift: 0,
            weight_q16: 1 << 16,
        };
        let fine = Fine::for_angles(largest_error(&mut sum, scale));
        close_sum(&mut sum, scale, fine);
        for (k, &found) in sum.iter().enumerate() {
            let found = f64::from(found) / f64::from(1 << fine.bits);
            assert!((found - (error(k) - error(0))).abs() < 26.0, "{k}: {found}");
        }
    }

    #[test]
    fn class_means_leave_nothing_of_a_class() {
        let mut errors: Vec<i32> = (0..40).map(|k| [5, -3, 8, 2][k % 4] * 100).collect();
        assert_eq!(
            take_class_means(&mut errors, 4)[..4],
            [200, -600, 500, -100]
        );
        assert!(errors.iter().all(|&error| error == 0));
    }
}

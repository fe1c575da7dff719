//! From intervals to a closed turn: every edge's error, with the turn's mean speed and curvature and the class means taken
//! out.

use super::fold::contrast_shift;
use super::order::OrderPlan;
use super::spectrum::Sequence;
use super::{EdgeBuffers, Totals};
use crate::shape::CLASSES_MAX;

/// Turns the summed deviations into each edge's error: running sum, closed over the turn, curvature taken out.
pub(super) fn close_sum(sum: &mut [i32], totals: &Totals) {
    let edges = sum.len() as i64;
    let mut run = 0_i64;
    for (edge, entry) in sum.iter_mut().enumerate() {
        let edge = edge as i64;
        // Slot 0 is the last interval of the turn; edge 0 is the origin.
        run += if edge == 0 { 0 } else { i64::from(*entry) };
        let trend = rounded_quotient(totals.excess * edge, edges)
            - rounded_quotient(totals.bend * edge * (edges - edge), edges * edges);
        *entry = saturated(trend - run);
    }
}

/// The same for the contrast, with what the estimate itself leaves in it (an odd number of turns) taken out.
pub(super) fn close_contrast<B: EdgeBuffers>(buffers: &mut B, totals: &Totals) {
    let edges = buffers.edges();
    let count = edges as i64;
    let turns = i64::from(totals.turns);
    #[allow(clippy::cast_possible_truncation)]
    let shift = contrast_shift(edges as u32);
    let end: i64 = buffers.work().iter().map(|cells| i64::from(cells[1])).sum();
    let mut run = 0_i64;
    for edge in 0..edges {
        let position = edge as i64;
        // Slot 0 is the last interval of the turn, as in the sum.
        run += if edge == 0 {
            0
        } else {
            i64::from(buffers.work()[edge][1])
        };
        let trend = rounded_quotient((end * position) << shift, count)
            - rounded_quotient(
                totals.bend_contrast * position * (count - position),
                count * count,
            );
        let pattern = rounded_quotient(
            i64::from(totals.sign_sum) * i64::from(buffers.sum()[edge]),
            turns,
        );
        let error = trend - (run << shift) - pattern;
        buffers.work().set(edge, saturated(error));
    }
}

/// Takes the mean of every class out of a sequence and returns the means less their own mean.
pub(super) fn take_class_means<S: Sequence + ?Sized>(
    sequence: &mut S,
    plan: OrderPlan,
) -> [i32; CLASSES_MAX] {
    let classes = plan.edges / plan.lines;
    let mut sums = [0_i64; CLASSES_MAX];
    let each = |visit: &mut dyn FnMut(usize, usize)| {
        let mut class = 0;
        for edge in 0..plan.edges {
            visit(edge, class);
            class = if class + 1 == classes { 0 } else { class + 1 };
        }
    };
    each(&mut |edge, class| sums[class] += i64::from(sequence.get(edge)));
    let mut means = [0_i32; CLASSES_MAX];
    for (mean, sum) in means.iter_mut().zip(sums) {
        #[allow(clippy::cast_possible_truncation)]
        {
            *mean = rounded_quotient(sum, plan.lines as i64) as i32;
        }
    }
    each(&mut |edge, class| sequence.set(edge, sequence.get(edge).wrapping_sub(means[class])));
    let middle = rounded_quotient(
        means[..classes].iter().map(|&mean| i64::from(mean)).sum(),
        classes as i64,
    );
    for mean in &mut means[..classes] {
        #[allow(clippy::cast_possible_truncation)]
        {
            *mean -= middle as i32;
        }
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

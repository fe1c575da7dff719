//! Power of every single order, and of all orders above together.

use super::decimate::{decimate, undo_decimation};
use super::order::{ORDERS_MAX, OrderPlan};
use super::spectrum::{Coefficient, POWER_BITS, Sample};
use super::transform::take_orders;
use crate::trig::sin_cos;
use crate::units::Turn32;

/// Mean square of the steps from edge to edge around the turn, in 2^-[`POWER_BITS`] of the squared
/// unit.
fn mean_square_step(errors: &[i32]) -> u128 {
    let mut squares = 0_u128;
    let mut before = errors.last().copied().unwrap_or(0);
    for &error in errors {
        let step = (i64::from(error) - i64::from(before)).unsigned_abs();
        squares += u128::from(step * step);
        before = error;
    }
    (squares << POWER_BITS) / errors.len().max(1) as u128
}

/// Finds the coefficients of the single orders and returns the mean power of the common ones; `scratch` has room for the
/// decimated errors.
///
/// The common power is taken from the steps between edges: in the angle itself, low orders of torque are many thousand
/// times larger, and nothing would be left of a difference of such sums.
pub(super) fn split_orders<S: Sample>(
    errors: &[i32],
    scratch: &mut [S],
    plan: OrderPlan,
    coefficients: &mut [Coefficient; ORDERS_MAX],
) -> u64 {
    let mut steps = mean_square_step(errors);
    let samples = decimate(errors, scratch, plan.decimation);
    single_sizes(&scratch[..samples], plan, coefficients);
    let classes = plan.edges / plan.lines;
    let mut gain_q28 = (2 * (plan.edges - if classes > 1 { classes } else { 0 }) as u64) << 28;
    for order in (1..=plan.single).filter(|&n| !plan.is_class_order(n)) {
        let c = &mut coefficients[order - 1];
        *c = undo_decimation(*c, order, plan.decimation, plan.edges);
        let gain_q58 = step_gain_q58(order, plan.edges);
        gain_q28 = gain_q28.saturating_sub((2 * gain_q58) >> 30);
        steps = steps.saturating_sub((u128::from(c.power()) * u128::from(gain_q58)) >> 57);
    }
    if plan.common_count() == 0 {
        return 0;
    }
    let common = (steps << 28) / u128::from(gain_q28.max(1));
    u64::try_from(common).unwrap_or(u64::MAX)
}

/// Power gain from an angle to its steps at an order: 4 sin^2(pi n / N), Q58. All its digits count, as a low order of
/// torque may be a million times the rest.
fn step_gain_q58(order: usize, edges: usize) -> u64 {
    #[allow(clippy::cast_possible_truncation)]
    let half_turn = Turn32((((order as u64) << 31) / edges as u64) as u32);
    let sine = u64::from(sin_cos(half_turn).0.unsigned_abs());
    sine * sine
}

/// Fills `sizes` with the single orders of a sequence; orders of the edge classes count as zero.
pub(super) fn single_sizes<S: Sample>(
    sequence: &[S],
    plan: OrderPlan,
    sizes: &mut [Coefficient; ORDERS_MAX],
) {
    take_orders(sequence, &mut sizes[..plan.single]);
    for class_order in (plan.lines..=plan.single).step_by(plan.lines) {
        sizes[class_order - 1] = Coefficient::default();
    }
}

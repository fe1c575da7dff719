//! Power of every single order, and of all orders above together.

use super::Totals;
use super::order::{ORDERS_MAX, OrderPlan};
use super::spectrum::{Coefficient, Sequence, coefficient, decimate, undo_decimation};
use crate::trig::sin_cos;
use crate::units::Turn32;

/// Powers of every single order and the mean power of all common ones, in 2^-16 of the squared sequence unit.
pub(super) struct Powers {
    /// Power of order n at n - 1.
    pub single: [u64; ORDERS_MAX],
    /// Mean power of the orders above.
    pub common: u64,
}

/// Mean square of the steps from edge to edge around the turn, in 2^-16 of the squared unit.
fn mean_square_step_q16<S: Sequence + ?Sized>(sequence: &S) -> u128 {
    let mut squares = 0_u128;
    let mut before = sequence.get(sequence.len() - 1);
    for index in 0..sequence.len() {
        let value = sequence.get(index);
        let step = u128::from((i64::from(value) - i64::from(before)).unsigned_abs());
        squares += step * step;
        before = value;
    }
    (squares << 16) / sequence.len() as u128
}

impl Powers {
    /// None yet.
    pub(super) const ZERO: Self = Self {
        single: [0; ORDERS_MAX],
        common: 0,
    };

    /// Takes the powers of coefficients, which are zero where there is no single order. In place: the stack is short.
    pub(super) fn fill(&mut self, coefficients: &[Coefficient; ORDERS_MAX], common: u64) {
        for (power, coefficient) in self.single.iter_mut().zip(coefficients) {
            *power = coefficient.power();
        }
        self.common = common;
    }
}

/// Finds the coefficients of the single orders and returns the mean power of the common ones; leaves the decimated
/// sequence behind.
///
/// The common power is taken from the steps between edges: in the angle itself, low orders of torque are many thousand
/// times larger, and nothing would be left of a difference of such sums.
pub(super) fn split_orders<S: Sequence + ?Sized>(
    sequence: &mut S,
    plan: OrderPlan,
    coefficients: &mut [Coefficient; ORDERS_MAX],
) -> u64 {
    let mut steps = mean_square_step_q16(sequence);
    let samples = decimate(sequence, plan.decimation);
    let classes = plan.edges / plan.lines;
    let mut gain_q28 = (2 * (plan.edges - if classes > 1 { classes } else { 0 }) as u64) << 28;
    for order in (1..=plan.single).filter(|&n| !plan.is_class_order(n)) {
        let raw = coefficient(sequence, samples, order);
        let c = undo_decimation(raw, order, plan.decimation, plan.edges);
        coefficients[order - 1] = c;
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

/// Scales the contrast's powers to the noise in the sum of all turns: its signs have the squared sum q - sigma^2 / q.
pub(super) fn scale_contrast(noise: &mut Powers, totals: &Totals) {
    let turns = u128::from(totals.turns);
    let sigma = u128::from(totals.sign_sum.unsigned_abs());
    let numerator = turns * turns;
    let denominator = turns * turns - sigma * sigma;
    for power in noise
        .single
        .iter_mut()
        .chain(core::iter::once(&mut noise.common))
    {
        *power = u64::try_from(u128::from(*power) * numerator / denominator).unwrap_or(u64::MAX);
    }
}

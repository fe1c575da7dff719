//! Power of every single order, and of all orders above together.

use core::task::{Poll, ready};

use super::cursor::Cursor;
use super::decimate::{Decimation, undo_decimation};
use super::order::{ORDERS_MAX, OrderPlan};
use super::spectrum::{Coefficient, POWER_BITS, Sample};
use super::transform::TakeOrders;
use crate::trig::sin_cos;
use crate::units::Turn32;
use crate::wide::over;

/// Edges and orders of a slice.
const EDGES: usize = 400;
const ORDERS: usize = 3;

/// Takes the single orders of the errors and the mean power of the common ones.
///
/// The common power is taken from the steps between edges: in the angle itself, low orders of torque are many thousand
/// times larger, and nothing would be left of a difference of such sums.
pub(super) struct SplitOrders {
    part: Part,
    /// Sum of the squared steps, in 2^-[`POWER_BITS`] of the squared unit once they are all in; then what is left of it.
    steps: u128,
    before: i32,
    /// What is left of the gain from all orders' power to that of the steps.
    gain_q28: u64,
    cursor: Cursor,
}

// What one part works with takes the place of the last one's.
#[allow(clippy::large_enum_variant)]
enum Part {
    Steps,
    Decimate(Decimation),
    Transform(TakeOrders),
    /// The decimation's gain is undone, and the orders are taken out of the steps.
    Undo,
}

impl SplitOrders {
    pub(super) const START: Self = Self {
        part: Part::Steps,
        steps: 0,
        before: 0,
        gain_q28: 0,
        cursor: Cursor::START,
    };

    /// `scratch` has room for the decimated errors.
    pub(super) fn slice<S: Sample>(
        &mut self,
        errors: &[i32],
        scratch: &mut [S],
        plan: OrderPlan,
        coefficients: &mut [Coefficient; ORDERS_MAX],
    ) -> Poll<u64> {
        match &mut self.part {
            Part::Steps => {
                ready!(self.add_steps(errors));
                self.part = Part::Decimate(Decimation::START);
            }
            Part::Decimate(decimation) => {
                ready!(decimation.slice(errors, scratch, plan.decimation));
                self.part = Part::Transform(TakeOrders::START);
            }
            Part::Transform(take) => {
                let samples = &scratch[..plan.edges / plan.decimation];
                ready!(single_sizes(take, samples, plan, coefficients));
                let classes = plan.edges / plan.lines;
                let others = plan.edges - if classes > 1 { classes } else { 0 };
                self.gain_q28 = (2 * others as u64) << 28;
                (self.part, self.cursor) = (Part::Undo, Cursor::START);
            }
            Part::Undo => {
                for index in self.cursor.next(ORDERS, plan.single) {
                    self.undo(index + 1, plan, coefficients);
                }
                ready!(self.cursor.at_end(plan.single));
                if plan.common_count() == 0 {
                    return Poll::Ready(0);
                }
                let common = over(self.steps << 28, self.gain_q28.max(1).into());
                return Poll::Ready(u64::try_from(common).unwrap_or(u64::MAX));
            }
        }
        Poll::Pending
    }

    /// Adds up the squares of the steps from edge to edge around the turn.
    fn add_steps(&mut self, errors: &[i32]) -> Poll<()> {
        let stretch = self.cursor.next(EDGES, errors.len());
        if stretch.start == 0 {
            self.before = errors.last().copied().unwrap_or(0);
        }
        for &error in &errors[stretch] {
            let step = (i64::from(error) - i64::from(self.before)).unsigned_abs();
            self.steps += u128::from(step * step);
            self.before = error;
        }
        ready!(self.cursor.at_end(errors.len()));
        self.steps = over(self.steps << POWER_BITS, errors.len().max(1) as u128);
        Poll::Ready(())
    }

    fn undo(
        &mut self,
        order: usize,
        plan: OrderPlan,
        coefficients: &mut [Coefficient; ORDERS_MAX],
    ) {
        if plan.is_class_order(order) {
            return;
        }
        let c = &mut coefficients[order - 1];
        *c = undo_decimation(*c, order, plan.decimation, plan.edges);
        let gain_q58 = step_gain_q58(order, plan.edges);
        self.gain_q28 = self.gain_q28.saturating_sub((2 * gain_q58) >> 30);
        let of_order = (u128::from(c.power()) * u128::from(gain_q58)) >> 57;
        self.steps = self.steps.saturating_sub(of_order);
    }
}

/// Power gain from an angle to its steps at an order: 4 sin^2(pi n / N), Q58. All its digits count, as a low order of
/// torque may be a million times the rest.
fn step_gain_q58(order: usize, edges: usize) -> u64 {
    #[allow(clippy::cast_possible_truncation)]
    let half_turn = Turn32((((order as u64) << 31) / edges as u64) as u32);
    let sine = u64::from(sin_cos(half_turn).0.unsigned_abs());
    sine * sine
}

/// A slice of taking the single orders of a sequence; in the end, orders of the edge classes count as zero.
pub(super) fn single_sizes<S: Sample>(
    take: &mut TakeOrders,
    sequence: &[S],
    plan: OrderPlan,
    sizes: &mut [Coefficient; ORDERS_MAX],
) -> Poll<()> {
    ready!(take.slice(sequence, &mut sizes[..plan.single]));
    for class_order in (plan.lines..=plan.single).step_by(plan.lines) {
        sizes[class_order - 1] = Coefficient::default();
    }
    Poll::Ready(())
}

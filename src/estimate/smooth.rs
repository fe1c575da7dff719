//! Level of the noise at every single order, from what a contrast shows at its neighbours.

use core::ops::RangeInclusive;
use core::task::{Poll, ready};

use super::cursor::Cursor;
use super::order::{ORDERS_MAX, OrderPlan};
use super::sizes::neighbours;
use super::weigh::single_orders;
use crate::log2::{LOG2_BITS, exp2, log2};

/// Orders that tell the size of the slope: above the lowest, which may be flatter, and below those where jitter rules.
const SLOPE_ORDERS: RangeInclusive<usize> = 7..=18;

/// Orders that the noise at an order is judged from at the least.
const ORDERS_ABOVE: usize = 24;

/// Orders of a slice: whose logarithms are taken, and whose level.
const LOGARITHMS: usize = 24;
const LEVELS: usize = 3;

/// Fraction bits of what the contrast showed at an order itself, in octaves.
pub(super) const OWN_BITS: u32 = 6;

/// Replaces the noise at every single order by its level, and says how far above twice that it was. The level is the
/// geometric mean over the neighbours, with a slope of the fourth power that ends in a floor taken out, and not below the same
/// mean over [`ORDERS_ABOVE`] orders from there up: few neighbours are no good judge of noise.
pub(super) struct Smoothing {
    part: Part,
    /// The slope's size at order 1, a logarithm.
    size: i32,
    /// Logarithms of the noise over slope and floor.
    flat: [i32; ORDERS_MAX],
    cursor: Cursor,
}

#[derive(Clone, Copy)]
enum Part {
    Slope,
    Flatten,
    Level,
}

impl Smoothing {
    pub(super) const START: Self = Self {
        part: Part::Slope,
        size: 0,
        flat: [0; ORDERS_MAX],
        cursor: Cursor::START,
    };

    /// Order n of the noise is at n - 1; `own` gets logarithms in 2^-[`OWN_BITS`] octave.
    #[inline(never)]
    pub(super) fn slice(
        &mut self,
        plan: OrderPlan,
        noise: &mut [u64; ORDERS_MAX],
        own: &mut [u8; ORDERS_MAX],
        floor: u64,
    ) -> Poll<()> {
        match self.part {
            Part::Slope => {
                self.size = slope_size(plan, noise);
                self.part = Part::Flatten;
            }
            Part::Flatten => {
                for index in self.cursor.next(LOGARITHMS, plan.single) {
                    self.flat[index] = log2(noise[index].into()) - self.slope(index + 1, floor);
                }
                ready!(self.cursor.at_end(plan.single));
                (self.part, self.cursor) = (Part::Level, Cursor::START);
            }
            Part::Level => {
                for index in self.cursor.next(LEVELS, plan.single) {
                    if !plan.is_class_order(index + 1) {
                        (noise[index], own[index]) = self.level(plan, index + 1, floor);
                    }
                }
                return self.cursor.at_end(plan.single);
            }
        }
        Poll::Pending
    }

    /// Logarithm of slope and floor together.
    fn slope(&self, order: usize, floor: u64) -> i32 {
        let rest = exp2(self.size - fourth(order)).max(1);
        log2(u128::from(rest) + u128::from(floor))
    }

    /// Level at an order, and how far above twice that it was itself.
    fn level(&self, plan: OrderPlan, order: usize, floor: u64) -> (u64, u8) {
        // Mean of the logarithm of an exponential distribution: -0.5772 / ln 2 = -0.8327 octaves.
        const MEAN_OVER_LOG_MEAN: i64 = 54_574;
        let last = (order + ORDERS_ABOVE)
            .max(order + order / 3)
            .min(plan.single);
        let first = order.min(last.saturating_sub(ORDERS_ABOVE)).max(1);
        let above = self.mean((first..=last).filter(|&n| !plan.is_class_order(n)));
        let flat = self.mean(neighbours(plan, order)).max(above);
        let slope = self.slope(order, floor);
        let level = flat + i64::from(slope) + MEAN_OVER_LOG_MEAN;
        #[allow(clippy::cast_possible_truncation)]
        let level = level.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32;
        let shown = self.flat[order - 1].saturating_add(slope);
        let above = shown.saturating_sub(level).saturating_sub(1 << LOG2_BITS);
        #[allow(clippy::cast_possible_truncation)]
        let own = (above >> (LOG2_BITS - OWN_BITS)).clamp(0, u8::MAX.into()) as u8;
        // At least the smallest number, so that ratios to it mean something.
        (exp2(level).max(1), own)
    }

    fn mean(&self, orders: impl Iterator<Item = usize>) -> i64 {
        let (mut sum, mut count) = (0_i64, 0_i64);
        for n in orders {
            sum += i64::from(self.flat[n - 1]);
            count += 1;
        }
        sum / count.max(1)
    }
}

/// Logarithm of the order's fourth power.
fn fourth(order: usize) -> i32 {
    4 * log2(order as u128)
}

/// The slope's size, from orders where it rules if it rules at all.
fn slope_size(plan: OrderPlan, noise: &[u64; ORDERS_MAX]) -> i32 {
    let (mut sum, mut count) = (0_i64, 0_i64);
    for order in single_orders(plan).filter(|order| SLOPE_ORDERS.contains(order)) {
        sum += i64::from(log2(noise[order - 1].into()) + fourth(order));
        count += 1;
    }
    #[allow(clippy::cast_possible_truncation)]
    let size = (sum / count.max(1)) as i32;
    size
}

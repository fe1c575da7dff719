//! How large geometry is at every order, as far as it stands above the noise: judged by the order's neighbours, and where noise
//! drowns it, carried down from the higher orders.

use core::task::{Poll, ready};

use super::cursor::Cursor;
use super::low::LOW_ORDERS;
use super::order::{ORDERS_MAX, OrderPlan};
use super::weigh::Estimate;
use crate::log2::{LOG2_BITS, exp2, log2};

const Q: i32 = 1 << LOG2_BITS;

/// Orders whose logarithms a slice takes.
const LOGARITHMS: usize = 60;

/// Looks for the geometry's power at every single order, as far as it stands above the noise; where it does not, that of the next
/// order above.
pub(super) struct Sizing {
    part: Part,
    /// Logarithms of signal and noise at every single order, Q9.
    signal: [i16; ORDERS_MAX],
    noise: [i16; ORDERS_MAX],
    cursor: Cursor,
    /// Size of the next order above.
    carried: u64,
}

#[derive(Clone, Copy)]
enum Part {
    Logarithms,
    /// From the highest order down: the median of signal over noise around an order is to be found.
    Ratio,
    /// That is known, and the median of the signal is to be found.
    Plain {
        ratio: i32,
    },
}

impl Sizing {
    /// `common_size` is that of the orders above the single ones.
    pub(super) const fn new(common_size: u64) -> Self {
        Self {
            part: Part::Logarithms,
            signal: [0; ORDERS_MAX],
            noise: [0; ORDERS_MAX],
            cursor: Cursor::START,
            carried: common_size,
        }
    }

    /// Order n of the `sizes` is at n - 1.
    #[inline(never)]
    pub(super) fn slice(
        &mut self,
        plan: OrderPlan,
        estimate: &Estimate<'_>,
        sizes: &mut [u64; ORDERS_MAX],
    ) -> Poll<()> {
        match self.part {
            Part::Logarithms => {
                for index in self.cursor.next(LOGARITHMS, plan.single) {
                    self.signal[index] = short(log2(estimate.coefficients[index].power().into()));
                    self.noise[index] = short(log2(estimate.noise[index].into()));
                }
                ready!(self.cursor.at_end(plan.single));
                (self.part, self.cursor) = (Part::Ratio, Cursor::START);
                Poll::Pending
            }
            Part::Ratio => {
                let order = plan.single - self.cursor.next(1, plan.single).start;
                if plan.has_neighbours() && !plan.is_class_order(order) {
                    let ratio = |n| self.signal(n) - self.noise(n);
                    let (ratio, _) = median(plan, order, ratio);
                    self.part = Part::Plain { ratio };
                    return Poll::Pending;
                }
                if !plan.is_class_order(order) {
                    let excess = excess(
                        estimate.coefficients[order - 1].power(),
                        estimate.noise[order - 1],
                        LONE_MARGIN_Q8,
                    );
                    (sizes[order - 1], self.carried) = (excess, excess);
                }
                self.cursor.at_end(plan.single)
            }
            Part::Plain { ratio } => {
                let order = plan.single + 1 - self.cursor.count();
                let (plain, count) = median(plan, order, |n| self.signal(n));
                let level = self.level(order, ratio, plain);
                sizes[order - 1] = self.size(plan, estimate, order, level, count);
                self.part = Part::Ratio;
                self.cursor.at_end(plan.single)
            }
        }
    }

    fn signal(&self, order: usize) -> i32 {
        i32::from(self.signal[order - 1]) << SHORT
    }

    fn noise(&self, order: usize) -> i32 {
        i32::from(self.noise[order - 1]) << SHORT
    }

    /// Level of the signal at an order, from medians over its neighbours of signal over noise and of the signal, because
    /// torque ripple puts lines there. Where noise rules, it is the median of signal over noise, times the noise here,
    /// because noise alone rises steeply to low orders and would look like geometry; where the signal stands 32 to 128
    /// times above, it goes over to the median of the signal, which no roughness of the noise can disturb.
    fn level(&self, order: usize, ratio: i32, plain: i32) -> u64 {
        let by_ratio = ratio + self.noise(order);
        let signal_rules = i64::from((ratio - 5 * Q).clamp(0, 2 * Q));
        let over = i64::from(plain - by_ratio) * signal_rules / i64::from(2 * Q);
        // Median over mean of an exponential distribution is ln 2; -log2(ln 2) = 0.5288.
        const MEAN_OVER_MEDIAN: i32 = 34_654;
        #[allow(clippy::cast_possible_truncation)]
        let level = by_ratio + over as i32 + MEAN_OVER_MEDIAN;
        exp2(level)
    }

    /// Size at an order whose level rests on so many neighbours.
    fn size(
        &mut self,
        plan: OrderPlan,
        estimate: &Estimate<'_>,
        order: usize,
        level: u64,
        count: usize,
    ) -> u64 {
        let noise = estimate.noise[order - 1];
        let own = if estimate.suspect(plan, order) {
            0
        } else {
            let pairs = if order <= LOW_ORDERS {
                estimate.low_pairs
            } else {
                u32::MAX
            };
            let power = estimate.coefficients[order - 1].power();
            excess(power, noise, own_margin_q8(pairs))
        };
        let size = excess(level, noise, margin_q8(count))
            .max(self.carried.min(level))
            .max(own);
        // An order that stands alone, such as eccentricity, says nothing of those below it.
        self.carried = size.min(level);
        size
    }
}

/// An order that torque can't make, to count by itself, must stand so far above the noise that noise alone does once in 160,000
/// orders: twelve times its mean where that is known, n (e^(12 / n) - 1) times where it is judged by n pairs of turns (the tail of
/// Fisher's F with 2 and 2 n degrees of freedom).
fn own_margin_q8(pairs: u32) -> u64 {
    const TWELVE_OVER_LN_2: u32 = 1_134_573;
    let pairs = pairs.clamp(1, MANY);
    let exponent = (TWELVE_OVER_LN_2 / pairs).cast_signed();
    u64::from(pairs) * (exp2(exponent + 8 * Q) - (1 << 8))
}

/// From so many pairs on more of them make no difference.
const MANY: u32 = 256;

/// An order without neighbours must stand four times above the noise.
const LONE_MARGIN_Q8: u64 = 4 << 8;

/// 2^(10.4 / sqrt(count)): above this ratio a level of `count` orders is no accident of noise (about 4 sigma of both).
fn margin_q8(count: usize) -> u64 {
    #[allow(clippy::cast_possible_truncation)]
    let root_q8 = ((count as u32) << 16).isqrt();
    #[allow(clippy::cast_possible_wrap)]
    let exponent = (2662 * Q as u32 / root_q8.max(256)) as i32;
    exp2(exponent + 8 * Q)
}

/// `factor x noise`.
pub(super) fn margin(noise: u64, factor_q8: u64) -> u64 {
    u64::try_from((u128::from(noise) * u128::from(factor_q8)) >> 8).unwrap_or(u64::MAX)
}

/// `power - factor x noise`, not below zero.
pub(super) fn excess(power: u64, noise: u64, factor_q8: u64) -> u64 {
    power.saturating_sub(margin(noise, factor_q8))
}

/// Neighbours at the most: half as many as there are orders, and more where few are left above.
const NEIGHBOURS_MAX: usize = ORDERS_MAX * 2 / 3 + 2;

/// Neighbours of an order: a third of it to either side, four at least.
pub(super) fn neighbours(plan: OrderPlan, order: usize) -> impl Iterator<Item = usize> {
    let reach = (order / 3).max(4);
    let first = order.saturating_sub(reach).max(1);
    let last = (order + reach).min(plan.single);
    (first..=last).filter(move |&n| !plan.is_class_order(n))
}

/// Digits of a logarithm that are dropped where many are kept.
const SHORT: u32 = LOG2_BITS - 9;

/// A logarithm as [`Sizing`] keeps it.
fn short(log2: i32) -> i16 {
    #[allow(clippy::cast_possible_truncation)]
    let short = (log2 >> SHORT) as i16;
    short
}

/// Median of a value over an order's neighbours, and their number.
fn median(plan: OrderPlan, order: usize, value: impl Fn(usize) -> i32) -> (i32, usize) {
    let mut values = [0; NEIGHBOURS_MAX];
    let mut count = 0;
    for (n, cell) in neighbours(plan, order).zip(&mut values) {
        *cell = value(n);
        count += 1;
    }
    let values = &mut values[..count];
    // An order has four neighbours at least. Selecting, unlike sorting, does not recurse.
    let (below, &mut middle, _) = values.select_nth_unstable(count / 2);
    let below = if count.is_multiple_of(2) {
        below.iter().copied().max()
    } else {
        None
    };
    (i32::midpoint(below.unwrap_or(middle), middle), count)
}

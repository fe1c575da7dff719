//! How large geometry is at every order, as far as it stands above the noise: judged by the order's neighbours, and where noise
//! drowns it, carried down from the higher orders.

use super::low::LOW_ORDERS;
use super::order::{ORDERS_MAX, OrderPlan};
use super::weigh::Estimate;
use crate::log2::{LOG2_BITS, exp2, log2};

const Q: i32 = 1 << LOG2_BITS;

/// The geometry's power at every single order, as far as it stands above the noise; where it does not, that of the next
/// order above.
#[inline(never)]
pub(super) fn find_sizes(
    plan: OrderPlan,
    estimate: &Estimate<'_>,
    common_size: u64,
    sizes: &mut [u64; ORDERS_MAX],
) {
    let mut levels = Levels {
        signal: [0; ORDERS_MAX],
        noise: [0; ORDERS_MAX],
        scratch: [0; NEIGHBOURS_MAX],
    };
    for index in 0..plan.single {
        levels.signal[index] = log2(estimate.coefficients[index].power().into());
        levels.noise[index] = log2(estimate.noise[index].into());
    }
    let mut carried = common_size;
    for order in (1..=plan.single).rev().filter(|&n| !plan.is_class_order(n)) {
        let (power, noise) = (
            estimate.coefficients[order - 1].power(),
            estimate.noise[order - 1],
        );
        let trusted = !estimate.suspect(plan, order);
        let size;
        (size, carried) = if plan.has_neighbours() {
            let (level, count) = levels.of_neighbourhood(plan, order);
            let own = if trusted {
                let pairs = if order <= LOW_ORDERS {
                    estimate.low_pairs
                } else {
                    u32::MAX
                };
                excess(power, noise, own_margin_q8(pairs))
            } else {
                0
            };
            let size = excess(level, noise, margin_q8(count))
                .max(carried.min(level))
                .max(own);
            // An order that stands alone, such as eccentricity, says nothing of those below it.
            (size, size.min(level))
        } else {
            let size = excess(power, noise, LONE_MARGIN_Q8);
            (size, size)
        };
        sizes[order - 1] = size;
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

/// Logarithms of signal and noise at every single order.
struct Levels {
    signal: [i32; ORDERS_MAX],
    noise: [i32; ORDERS_MAX],
    scratch: [i32; NEIGHBOURS_MAX],
}

impl Levels {
    /// Level of the signal at an order, and the number of neighbours it rests on: a median over the neighbours, because
    /// torque ripple puts lines there. Where noise rules, it is the median of signal over noise, times the noise here,
    /// because noise alone rises steeply to low orders and would look like geometry; where the signal stands 32 to 128
    /// times above, it goes over to the median of the signal, which no roughness of the noise can disturb.
    fn of_neighbourhood(&mut self, plan: OrderPlan, order: usize) -> (u64, usize) {
        let (signal, noise) = (&self.signal, &self.noise);
        let scratch = &mut self.scratch;
        let (ratio, count) = median(plan, order, scratch, |n| signal[n - 1] - noise[n - 1]);
        let (plain, _) = median(plan, order, scratch, |n| signal[n - 1]);
        let by_ratio = ratio + noise[order - 1];
        let signal_rules = i64::from((ratio - 5 * Q).clamp(0, 2 * Q));
        let over = i64::from(plain - by_ratio) * signal_rules / i64::from(2 * Q);
        // Median over mean of an exponential distribution is ln 2; -log2(ln 2) = 0.5288.
        const MEAN_OVER_MEDIAN: i32 = 34_654;
        #[allow(clippy::cast_possible_truncation)]
        let level = by_ratio + over as i32 + MEAN_OVER_MEDIAN;
        (exp2(level), count)
    }
}

/// Median of a value over an order's neighbours, and their number.
fn median(
    plan: OrderPlan,
    order: usize,
    scratch: &mut [i32; NEIGHBOURS_MAX],
    value: impl Fn(usize) -> i32,
) -> (i32, usize) {
    let mut count = 0;
    for (n, cell) in neighbours(plan, order).zip(scratch.iter_mut()) {
        *cell = value(n);
        count += 1;
    }
    let values = &mut scratch[..count];
    // An order has four neighbours at least. Selecting, unlike sorting, does not recurse.
    let (below, &mut middle, _) = values.select_nth_unstable(count / 2);
    let below = if count.is_multiple_of(2) {
        below.iter().copied().max()
    } else {
        None
    };
    (i32::midpoint(below.unwrap_or(middle), middle), count)
}

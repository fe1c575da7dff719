//! How far each order is believed: its size against the noise that the contrast shows and against its neighbours.
//!
//! Noise of a shaft falls with the fourth power of the order, encoder geometry is about as large at every order. So the
//! noise is averaged over neighbours after that slope is taken out, and where it drowns the geometry, the geometry's size
//! is carried down from the higher orders. The weight is Wiener's, S / (S + N), drawn to zero where little is known. All
//! decisions are continuous, so that no rounding can flip one.

use super::order::{ORDERS_MAX, OrderPlan};
use super::power::Powers;
use super::ripple::{Standing, StandingOrders, keep_strongest, product};
use super::spectrum::Coefficient;
use crate::log2::{LOG2_BITS, exp2, log2};

/// One in Q15, the unit of a weight.
pub(super) const WEIGHT_ONE: u32 = 1 << 15;

const Q: i32 = 1 << LOG2_BITS;

/// What the weighing found.
pub(super) struct Weights {
    /// Weight of order n at n - 1, Q15.
    pub single: [u16; ORDERS_MAX],
    /// Weight of all orders above, Q15.
    pub common: u32,
    /// Expected squared error of an edge after correction, 2^-16 of the squared unit, class offsets not counted.
    pub residual: u64,
    /// Orders left alone because torque might make them.
    pub standing: StandingOrders,
}

/// Weighs the signal (all turns: `coefficients` of the single orders, `common` power of the others) against `noise`
/// (contrast, scaled to all turns). `one_speed_turn` is the length of a turn in the sequence's unit where all turns were too
/// alike in speed to tell torque ripple from geometry; else none.
///
/// Not inlined, so that the stack it needs is free again for what comes after.
#[inline(never)]
pub(super) fn weigh(
    plan: OrderPlan,
    coefficients: &[Coefficient; ORDERS_MAX],
    common: u64,
    noise: &mut Powers,
    one_speed_turn: Option<u64>,
) -> Weights {
    let common_size = excess(common, noise.common, COMMON_MARGIN_Q8);
    let mut own_noise = [0_i32; ORDERS_MAX];
    let sizes = {
        // Ends here, as the stack is short.
        let mut scratch = [0_i32; ORDERS_MAX];
        smooth_noise(plan, noise, &mut own_noise, &mut scratch);
        sizes(plan, coefficients, noise, common_size, &mut scratch)
    };

    let suspect_torque = plan.has_neighbours() && one_speed_turn.is_some();
    let common_weight = wiener(common_size, noise.common);
    // Filled in place: the stack is short.
    let mut weights = Weights {
        single: [0; ORDERS_MAX],
        common: common_weight,
        residual: 0,
        standing: StandingOrders::new(),
    };
    for order in single_orders(plan).filter(|_| suspect_torque) {
        let power = coefficients[order - 1].power();
        if height(power, sizes[order - 1], noise.single[order - 1]) > STANDING_HEIGHT {
            #[allow(clippy::cast_possible_truncation)]
            keep_strongest(
                &mut weights.standing,
                Standing {
                    order: order as u16,
                    power,
                },
            );
        }
    }
    let turn = one_speed_turn.unwrap_or(0);

    // Geometry that the margin hides may be there all the same.
    let hidden = margin(noise.common, COMMON_MARGIN_Q8 - 256);
    let left_common = left_over(common_weight, common_size.max(hidden), noise.common);
    let mut residual = u128::from(left_common) * plan.common_count() as u128;
    for order in single_orders(plan) {
        let index = order - 1;
        let size = sizes[index];
        // Not below half of what the order itself shows, for a line that comes and goes.
        let doubt = noise.single[index].max(exp2(own_noise[index]) / 2);
        let product = u64::from(product(&weights.standing, turn, order));
        let doubt = doubt.saturating_add(product.pow(2));
        let mut weight = wiener(size, doubt);
        if suspect_torque {
            let gate =
                (STANDING_HEIGHT - height(coefficients[index].power(), size, doubt)).clamp(0, Q);
            weight = (weight * gate.unsigned_abs()) >> LOG2_BITS;
        }
        residual += 2 * u128::from(left_over(weight, size, doubt));
        #[allow(clippy::cast_possible_truncation)]
        {
            weights.single[index] = weight as u16;
        }
    }
    weights.residual = u64::try_from(residual).unwrap_or(u64::MAX);
    weights
}

/// The geometry's power at every single order, as far as it stands above the noise; where it does not, that of the next
/// order above.
fn sizes(
    plan: OrderPlan,
    coefficients: &[Coefficient; ORDERS_MAX],
    noise_levels: &Powers,
    common_size: u64,
    scratch: &mut [i32; ORDERS_MAX],
) -> [u64; ORDERS_MAX] {
    let mut sizes = [0; ORDERS_MAX];
    let mut carried = common_size;
    for order in (1..=plan.single).rev().filter(|&n| !plan.is_class_order(n)) {
        let (power, noise) = (
            coefficients[order - 1].power(),
            noise_levels.single[order - 1],
        );
        let size = if plan.has_neighbours() {
            let (level, count) =
                neighbourhood_level(plan, coefficients, noise_levels, order, scratch);
            excess(level, noise, margin_q8(count)).max(carried.min(level))
        } else {
            excess(power, noise, LONE_MARGIN_Q8)
        };
        sizes[order - 1] = size;
        carried = size;
    }
    sizes
}

fn single_orders(plan: OrderPlan) -> impl Iterator<Item = usize> {
    (1..=plan.single).filter(move |&n| !plan.is_class_order(n))
}

/// How far a power stands above what is expected of it, in octaves (Q16).
fn height(power: u64, size: u64, noise: u64) -> i32 {
    log2(power.into()) - log2(u128::from(size) + u128::from(noise))
}

/// An order 16 times (log2 = 4) above its neighbours in power is left alone; from 8 times on its weight falls.
const STANDING_HEIGHT: i32 = 4 * Q;

/// Of thousands of common orders, ten percent above the noise is significant.
const COMMON_MARGIN_Q8: u64 = 282;

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
fn margin(noise: u64, factor_q8: u64) -> u64 {
    u64::try_from((u128::from(noise) * u128::from(factor_q8)) >> 8).unwrap_or(u64::MAX)
}

/// `power - factor x noise`, not below zero.
fn excess(power: u64, noise: u64, factor_q8: u64) -> u64 {
    power.saturating_sub(margin(noise, factor_q8))
}

/// Wiener's weight, Q15, drawn linearly to zero at 0.3.
fn wiener(size: u64, noise: u64) -> u32 {
    let total = u128::from(size) + u128::from(noise);
    if total == 0 {
        return 0;
    }
    #[allow(clippy::cast_possible_truncation)]
    let weight = ((u128::from(size) << 15) / total) as u32;
    const FLOOR: u32 = WEIGHT_ONE * 3 / 10;
    weight.saturating_sub(FLOOR) * 10 / 7
}

/// Expected power left when a size is corrected with a weight: (1 - w)^2 S + w^2 N.
fn left_over(weight: u32, size: u64, noise: u64) -> u64 {
    let rest = u128::from(WEIGHT_ONE - weight.min(WEIGHT_ONE));
    let weight = u128::from(weight);
    u64::try_from((rest * rest * u128::from(size) + weight * weight * u128::from(noise)) >> 30)
        .unwrap_or(u64::MAX)
}

/// Neighbours of an order: a third of it to either side, two at least.
fn neighbours(plan: OrderPlan, order: usize) -> impl Iterator<Item = usize> {
    let reach = (order / 3).max(2);
    let first = order.saturating_sub(reach).max(1);
    let last = (order + reach).min(plan.single);
    (first..=last).filter(move |&n| !plan.is_class_order(n))
}

/// Level of the signal at an order, and the number of neighbours it rests on: a median over the neighbours, because torque
/// ripple puts lines there. Where noise rules, it is the median of signal over noise, times the noise here, because noise
/// alone rises steeply to low orders and would look like geometry; where the signal stands 32 to 128 times above, it goes
/// over to the median of the signal, which no roughness of the noise can disturb.
fn neighbourhood_level(
    plan: OrderPlan,
    coefficients: &[Coefficient; ORDERS_MAX],
    noise: &Powers,
    order: usize,
    scratch: &mut [i32; ORDERS_MAX],
) -> (u64, usize) {
    let mut median = |value: &dyn Fn(usize) -> i32| {
        let mut count = 0;
        for (n, cell) in neighbours(plan, order).zip(scratch.iter_mut()) {
            *cell = value(n);
            count += 1;
        }
        let values = &mut scratch[..count];
        // An order has two neighbours at least. Selecting, unlike sorting, does not recurse.
        let (below, &mut middle, _) = values.select_nth_unstable(count / 2);
        let below = if count.is_multiple_of(2) {
            below.iter().copied().max()
        } else {
            None
        };
        (i32::midpoint(below.unwrap_or(middle), middle), count)
    };
    let signal_log = |n: usize| log2(coefficients[n - 1].power().into());
    let noise_log = |n: usize| log2(noise.single[n - 1].into());
    let (ratio, count) = median(&|n| signal_log(n) - noise_log(n));
    let (plain, _) = median(&signal_log);
    let by_ratio = ratio + noise_log(order);
    let signal_rules = i64::from((ratio - 5 * Q).clamp(0, 2 * Q));
    let over = i64::from(plain - by_ratio) * signal_rules / i64::from(2 * Q);
    // Median over mean of an exponential distribution is ln 2; -log2(ln 2) = 0.5288.
    const MEAN_OVER_MEDIAN: i32 = 34_654;
    #[allow(clippy::cast_possible_truncation)]
    let level = by_ratio + over as i32 + MEAN_OVER_MEDIAN;
    (exp2(level), count)
}

/// Replaces the noise at every single order by its level; the logarithms of what was there go to `own`. The level is the
/// geometric mean over the neighbours with the slope of the fourth power taken out, and not below the same mean over
/// [`ORDERS_ABOVE`] orders from there up: few neighbours are no good judge of noise.
fn smooth_noise(
    plan: OrderPlan,
    noise: &mut Powers,
    own: &mut [i32; ORDERS_MAX],
    scratch: &mut [i32; ORDERS_MAX],
) {
    // Mean of the logarithm of an exponential distribution: -0.5772 / ln 2 = -0.8327 octaves.
    const MEAN_OVER_LOG_MEAN: i64 = 54_574;
    let slope = |order: usize| 4 * log2(order as u128);
    for order in single_orders(plan) {
        own[order - 1] = log2(noise.single[order - 1].into());
        scratch[order - 1] = own[order - 1] + slope(order);
    }
    for order in single_orders(plan) {
        let mean = |orders: &mut dyn Iterator<Item = usize>| {
            let (mut sum, mut count) = (0_i64, 0_i64);
            for n in orders {
                sum += i64::from(scratch[n - 1]);
                count += 1;
            }
            sum / count.max(1)
        };
        let last = (order + ORDERS_ABOVE)
            .max(order + order / 3)
            .min(plan.single);
        let first = order.min(last.saturating_sub(ORDERS_ABOVE)).max(1);
        let above = mean(&mut (first..=last).filter(|&n| !plan.is_class_order(n)));
        let level = mean(&mut neighbours(plan, order)).max(above) - i64::from(slope(order))
            + MEAN_OVER_LOG_MEAN;
        #[allow(clippy::cast_possible_truncation)]
        let level = exp2(level.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32);
        // At least the smallest number, so that ratios to it mean something.
        noise.single[order - 1] = level.max(1);
    }
}

/// Orders that the noise at an order is judged from at the least.
const ORDERS_ABOVE: usize = 24;

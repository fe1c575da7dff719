//! How far each order is believed: its size against the noise that the contrast shows and against its neighbours.
//!
//! Noise of a shaft falls with the fourth power of the order, encoder geometry is about as large at every order. So the
//! noise is averaged over neighbours after that slope is taken out, and where it drowns the geometry, the geometry's size
//! is carried down from the higher orders. The weight is Wiener's, S / (S + N), drawn to zero where little is known. All
//! decisions are continuous, so that no rounding can flip one.

use super::DriveKnowledge;
use super::order::{ORDERS_MAX, OrderPlan, OrderSet};
use super::ripple::{Standing, StandingOrders, keep_strongest, product, strongest_swing};
use super::sizes::{excess, find_sizes, margin};
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
    /// Expected squared error of an edge after correction, 2^-8 of the squared unit, class offsets not counted.
    pub residual: u64,
    /// The same without correction.
    pub uncorrected: u64,
    /// Orders left alone because torque might make them.
    pub standing: StandingOrders,
}

/// The estimate that is to be weighed: its orders, and what is known of its noise.
pub(super) struct Estimate<'a> {
    pub coefficients: &'a [Coefficient; ORDERS_MAX],
    /// Power of the orders above the single ones.
    pub common: u64,
    pub noise: &'a [u64; ORDERS_MAX],
    /// Logarithms of what the contrast showed at each order itself over its level, Q8.
    pub own: &'a [i16; ORDERS_MAX],
    pub common_noise: u64,
    /// Pairs of turns that the noise of the lowest orders rests on.
    pub low_pairs: u32,
    /// Length of a turn in the sequence's unit.
    pub turn: u64,
    /// Orders at which the turns' speeds do not tell torque from geometry.
    pub untold: OrderSet,
    pub knowledge: DriveKnowledge,
}

impl Estimate<'_> {
    /// Whether torque may make an order.
    pub(super) fn suspect(&self, plan: OrderPlan, order: usize) -> bool {
        let base = usize::from(self.knowledge.torque_base);
        self.untold.contains(order)
            && plan.has_neighbours()
            && (base == 0 || order.is_multiple_of(base))
    }
}

/// Weighs the orders of an estimate against its noise; `sizes` gets the geometry's power at every single order.
///
/// Not inlined, so that the stack it needs is free again for what comes after.
#[inline(never)]
pub(super) fn weigh(
    plan: OrderPlan,
    estimate: &Estimate<'_>,
    sizes: &mut [u64; ORDERS_MAX],
) -> Weights {
    let common_size = excess(estimate.common, estimate.common_noise, COMMON_MARGIN_Q8);
    find_sizes(plan, estimate, common_size, sizes);
    let common_weight = wiener(common_size, estimate.common_noise);
    // Filled in place: the stack is short.
    let mut weights = Weights {
        single: [0; ORDERS_MAX],
        common: common_weight,
        residual: 0,
        uncorrected: 0,
        standing: StandingOrders::new(),
    };
    for order in single_orders(plan).filter(|&n| estimate.suspect(plan, n)) {
        let power = estimate.coefficients[order - 1].power();
        if height(power, sizes[order - 1], estimate.noise[order - 1]) > STANDING_HEIGHT {
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
    // By two standard errors more than what shows, which noise may have made small.
    let mounting = core::array::from_fn(|index| {
        let shown = estimate.coefficients[index].power();
        shown.saturating_add(estimate.noise[index].saturating_mul(4))
    });

    // Geometry that the margin hides may be there all the same.
    let hidden = margin(estimate.common_noise, COMMON_MARGIN_Q8 - 256);
    let left_common = left_over(
        common_weight,
        common_size.max(hidden),
        estimate.common_noise,
    );
    let mut residual = u128::from(left_common) * plan.common_count() as u128;
    let believed = left_over(common_weight, 0, estimate.common);
    let mut uncorrected = residual + u128::from(believed) * plan.common_count() as u128;
    for order in single_orders(plan) {
        let index = order - 1;
        let size = sizes[index];
        // Not below half of what the order itself shows, for a line that comes and goes.
        let noise = estimate.noise[index];
        let own = log2(noise.into())
            .saturating_add(i32::from(estimate.own[index]) << (LOG2_BITS - 8))
            - Q;
        let product = u64::from(product(&weights.standing, mounting, estimate.turn, order)).pow(2);
        let mut doubt = noise.max(exp2(own)).saturating_add(product);
        if estimate.suspect(plan, order) && estimate.knowledge.torque_base > 0 {
            doubt = doubt.saturating_add(strongest_swing(&weights.standing, order));
        }
        let of_mounting = order <= 2 && !estimate.suspect(plan, order) && plan.has_neighbours();
        let shown = estimate.coefficients[index].power();
        // What a product may have made is no sign of geometry.
        let mut weight = wiener(size.saturating_sub(product), doubt);
        if of_mounting {
            weight = weight.max(mounting_weight(shown, doubt));
        }
        if estimate.suspect(plan, order) {
            let gate = (STANDING_HEIGHT - height(shown, size, doubt)).clamp(0, Q);
            weight = (weight * gate.unsigned_abs()) >> LOG2_BITS;
        }
        if order <= usize::from(estimate.knowledge.hidden_up_to) {
            weight = 0;
        }
        let (rest, before) = if of_mounting {
            (
                left_of_mounting(weight, shown, doubt),
                shown.saturating_sub(doubt),
            )
        } else {
            let rest = left_over(weight, size, doubt);
            (rest, rest.saturating_add(left_over(weight, 0, shown)))
        };
        residual += 2 * u128::from(rest);
        uncorrected += 2 * u128::from(before);
        #[allow(clippy::cast_possible_truncation)]
        {
            weights.single[index] = weight as u16;
        }
    }
    weights.residual = u64::try_from(residual).unwrap_or(u64::MAX);
    weights.uncorrected = u64::try_from(uncorrected).unwrap_or(u64::MAX);
    weights
}

pub(super) fn single_orders(plan: OrderPlan) -> impl Iterator<Item = usize> {
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

/// Weight of orders 1 and 2 at the least, which a disc's mounting makes large (eccentricity, tilt): 1 - N / P, so that what shows
/// up no larger than noise is not believed, and what is ten times as large nearly is. Whatever their true size, the expected
/// error's power is at most 1.2 times that of the estimate itself, and a fifth of it where there is nothing.
fn mounting_weight(power: u64, noise: u64) -> u32 {
    let drawn = (u128::from(noise) << 15) / u128::from(power.max(1));
    #[allow(clippy::cast_possible_truncation)]
    let weight = WEIGHT_ONE - drawn.min(WEIGHT_ONE.into()) as u32;
    weight
}

/// Expected power left of orders 1 and 2. Nothing is known of their size beforehand: as far as the estimate is believed its noise
/// stays, and as far as it is not, what shows; within a tenth of the mean over the noise for any true size.
fn left_of_mounting(weight: u32, power: u64, noise: u64) -> u64 {
    let rest = WEIGHT_ONE - weight.min(WEIGHT_ONE);
    let not_believed = u128::from(rest * rest);
    let believed = (1 << 30) - not_believed;
    u64::try_from((believed * u128::from(noise) + not_believed * u128::from(power)) >> 30)
        .unwrap_or(u64::MAX)
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

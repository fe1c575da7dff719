//! How far each order is believed: its size against the noise that the contrast shows and against its neighbours.
//!
//! Noise of a shaft falls with the fourth power of the order, encoder geometry is about as large at every order. So the
//! noise is averaged over neighbours after that slope is taken out, and where it drowns the geometry, the geometry's size
//! is carried down from the higher orders. The weight is Wiener's, S / (S + N), drawn to zero where little is known. All
//! decisions are continuous, so that no rounding can flip one.

use core::task::{Poll, ready};

use super::DriveKnowledge;
use super::cursor::Cursor;
use super::order::{ORDERS_MAX, OrderPlan, OrderSet};
use super::ripple::{Standing, StandingOrders, keep_strongest, product, strongest_swing};
use super::sizes::{Sizing, excess, margin};
use super::smooth::OWN_BITS;
use super::spectrum::Coefficient;
use crate::log2::{LOG2_BITS, exp2, log2};
use crate::wide::over;

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

impl Weights {
    pub(super) const NONE: Self = Self {
        single: [0; ORDERS_MAX],
        common: 0,
        residual: 0,
        uncorrected: 0,
        standing: StandingOrders::new(),
    };
}

/// The estimate that is to be weighed: its orders, and what is known of its noise.
pub(super) struct Estimate<'a> {
    pub coefficients: &'a [Coefficient; ORDERS_MAX],
    /// Power of the orders above the single ones.
    pub common: u64,
    pub noise: &'a [u64; ORDERS_MAX],
    /// Logarithms of what the contrast showed at each order itself over twice its level, in 2^-[`OWN_BITS`] octave.
    pub own: &'a [u8; ORDERS_MAX],
    pub common_noise: u64,
    /// Pairs of turns that the noise of the lowest orders rests on.
    pub low_pairs: u32,
    /// Length of a turn in the sequence's unit.
    pub turn: u64,
    /// Orders at which the turns' speeds do not tell torque from geometry.
    pub untold: OrderSet,
    /// Power that the shaft's damping may have left in all orders together beyond their noise.
    pub hidden: u64,
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

/// Orders of a slice: looked at for what stands out, and weighed.
const LOOKED_AT: usize = 12;
const WEIGHED: usize = 2;

/// Weighs the orders of an estimate against its noise.
pub(super) struct Weighting {
    part: Part,
    /// Size of the orders above the single ones.
    common_size: u64,
    /// Roots of what orders 1 and 2 show, by two standard errors more, which noise may have made small.
    mounting: [u64; 2],
    residual: u128,
    uncorrected: u128,
    cursor: Cursor,
}

// What one part works with takes the place of the last one's.
#[allow(clippy::large_enum_variant)]
enum Part {
    Begin,
    Sizes(Sizing),
    Standing,
    Orders,
}

impl Weighting {
    pub(super) const START: Self = Self {
        part: Part::Begin,
        common_size: 0,
        mounting: [0; 2],
        residual: 0,
        uncorrected: 0,
        cursor: Cursor::START,
    };

    /// Fills in the weights; `sizes` gets the geometry's power at every single order.
    #[inline(never)]
    pub(super) fn slice(
        &mut self,
        plan: OrderPlan,
        estimate: &Estimate<'_>,
        sizes: &mut [u64; ORDERS_MAX],
        weights: &mut Weights,
    ) -> Poll<()> {
        match &mut self.part {
            Part::Begin => {
                let size = excess(estimate.common, estimate.common_noise, COMMON_MARGIN_Q8);
                self.common_size = size;
                self.part = Part::Sizes(Sizing::new(size));
            }
            Part::Sizes(sizing) => {
                ready!(sizing.slice(plan, estimate, sizes));
                self.begin(plan, estimate, weights);
                self.part = Part::Standing;
            }
            Part::Standing => {
                for index in self.cursor.next(LOOKED_AT, plan.single) {
                    keep_standing(plan, estimate, index + 1, sizes[index], weights);
                }
                ready!(self.cursor.at_end(plan.single));
                (self.part, self.cursor) = (Part::Orders, Cursor::START);
            }
            Part::Orders => {
                for index in self.cursor.next(WEIGHED, plan.single) {
                    if !plan.is_class_order(index + 1) {
                        self.weigh(plan, estimate, index + 1, sizes[index], weights);
                    }
                }
                ready!(self.cursor.at_end(plan.single));
                weights.residual = u64::try_from(self.residual).unwrap_or(u64::MAX);
                weights.uncorrected = u64::try_from(self.uncorrected).unwrap_or(u64::MAX);
                return Poll::Ready(());
            }
        }
        Poll::Pending
    }

    /// Weighs the common orders, and sees how far the disc's mounting shows.
    fn begin(&mut self, plan: OrderPlan, estimate: &Estimate<'_>, weights: &mut Weights) {
        let noise = estimate.common_noise;
        let common = wiener(self.common_size, noise);
        *weights = Weights::NONE;
        weights.common = common;
        self.mounting = core::array::from_fn(|index| {
            let shown = estimate.coefficients[index].power();
            shown
                .saturating_add(estimate.noise[index].saturating_mul(4))
                .isqrt()
        });
        // Geometry that the margin hides may be there all the same.
        let hidden = margin(noise, COMMON_MARGIN_Q8 - 256);
        let left_common = left_over(common, self.common_size.max(hidden), noise);
        let count = plan.common_count() as u128;
        self.residual = u128::from(left_common) * count;
        let believed = left_over(common, 0, estimate.common);
        self.uncorrected = self.residual + u128::from(believed) * count;
        self.residual += 2 * u128::from(estimate.hidden);
    }

    /// Weighs one order of a geometry's `size`.
    fn weigh(
        &mut self,
        plan: OrderPlan,
        estimate: &Estimate<'_>,
        order: usize,
        size: u64,
        weights: &mut Weights,
    ) {
        let index = order - 1;
        let suspect = estimate.suspect(plan, order);
        // Not below half of what the order itself shows, for a line that comes and goes.
        let noise = estimate.noise[index];
        let own = i32::from(estimate.own[index]) << (LOG2_BITS - OWN_BITS);
        let own = exp2(log2(noise.into()).saturating_add(own));
        let product = product(&weights.standing, self.mounting, estimate.turn, order);
        let product = u64::from(product).pow(2);
        let mut doubt = noise.max(own).saturating_add(product);
        if suspect && estimate.knowledge.torque_base > 0 {
            doubt = doubt.saturating_add(strongest_swing(&weights.standing, order));
        }
        let of_mounting = order <= 2 && !suspect && plan.has_neighbours();
        let shown = estimate.coefficients[index].power();
        // What a product may have made is no sign of geometry.
        let mut weight = wiener(size.saturating_sub(product), doubt);
        if of_mounting {
            weight = weight.max(mounting_weight(shown, doubt));
        }
        if suspect {
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
        self.residual += 2 * u128::from(rest);
        self.uncorrected += 2 * u128::from(before);
        #[allow(clippy::cast_possible_truncation)]
        {
            weights.single[index] = weight as u16;
        }
    }
}

/// Keeps an order of a geometry's `size` that torque may have made and that stands out.
fn keep_standing(
    plan: OrderPlan,
    estimate: &Estimate<'_>,
    order: usize,
    size: u64,
    weights: &mut Weights,
) {
    if plan.is_class_order(order) || !estimate.suspect(plan, order) {
        return;
    }
    let power = estimate.coefficients[order - 1].power();
    if height(power, size, estimate.noise[order - 1]) > STANDING_HEIGHT {
        #[allow(clippy::cast_possible_truncation)]
        keep_strongest(&mut weights.standing, Standing::new(order as u16, power));
    }
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

/// Weight of orders 1 and 2 at the least, which a disc's mounting makes large (eccentricity, tilt): 1 - (N / P)^2, so that what
/// shows up no larger than noise is not believed, and what is five times as large nearly is. Whatever their true size, the expected
/// error's power is at most 1.2 times that of the estimate itself, and two fifths of it where there is nothing.
fn mounting_weight(power: u64, noise: u64) -> u32 {
    let ratio = over(u128::from(noise) << 15, power.max(1).into());
    #[allow(clippy::cast_possible_truncation)]
    let ratio = ratio.min(WEIGHT_ONE.into()) as u32;
    WEIGHT_ONE - ((ratio * ratio) >> WEIGHT_ONE.trailing_zeros())
}

/// Expected power left of orders 1 and 2. Nothing is known of their size beforehand: as far as the estimate is believed its noise
/// stays, as far as it is not, what shows, and in between the noise counts twice more, as it moves the weight too: w (4 - 3 w) N +
/// (1 - w)^2 P. That is within a tenth of the mean where they are as large as the noise or larger.
fn left_of_mounting(weight: u32, power: u64, noise: u64) -> u64 {
    let weight = weight.min(WEIGHT_ONE);
    let rest = WEIGHT_ONE - weight;
    let believed = u128::from(weight) * u128::from(WEIGHT_ONE + 3 * rest);
    let left = believed * u128::from(noise) + u128::from(rest * rest) * u128::from(power);
    u64::try_from(left >> 30).unwrap_or(u64::MAX)
}

/// Wiener's weight, Q15, drawn linearly to zero at 0.3.
fn wiener(size: u64, noise: u64) -> u32 {
    let total = u128::from(size) + u128::from(noise);
    if total == 0 {
        return 0;
    }
    #[allow(clippy::cast_possible_truncation)]
    let weight = over(u128::from(size) << 15, total) as u32;
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

//! What the turns say of the noise at every order.
//!
//! At the lowest orders, which hold nearly all of it, turns of like speed are compared pair by pair. Above, the contrast
//! speaks: noise of a shaft falls with the fourth power of the order, so its level is averaged over neighbours after that
//! slope is taken out. High orders know no torque; there, time stamps' jitter is all.

use core::ops::RangeInclusive;

use super::low::{LOW_BITS, LOW_ORDERS};
use super::moments::{Shares, torque_power_q24};
use super::order::{ORDERS_MAX, OrderPlan};
use super::scale::Fine;
use super::sizes::neighbours;
use super::spectrum::{COEFFICIENT_BITS, POWER_BITS};
use super::speeds::{Bin, Speeds, octaves_q16, power_of_two};
use super::weigh::single_orders;
use crate::log2::{LOG2_BITS, exp2, log2};
use crate::units::STEP_FRACTION_BITS;

/// Turns the powers of a contrast, in `noise`, into the noise of the estimate whose turns have `shares` where they have
/// `contrast` there, in 2^-[`POWER_BITS`] of the squared fine unit; order n at n - 1. Logarithms of what the contrast showed at
/// each order itself over its level go to `own`. Returns how many pairs of turns the noise of the lowest orders rests on.
#[inline(never)]
pub(super) fn settle_noise(
    plan: OrderPlan,
    noise: &mut [u64; ORDERS_MAX],
    own: &mut [i16; ORDERS_MAX],
    speeds: &Speeds,
    shares: &Shares,
    contrast: &Shares,
    fine: Fine,
) -> u32 {
    // Where blocks begin, jitter shows with all its orders on those that blocks can tell.
    let jitter = jitter_power(plan, speeds, shares, fine);
    let folded = jitter.saturating_mul((plan.edges / plan.blocks) as u64);
    smooth_noise(plan, noise, own, folded);
    let norm = contrast.of_powers(speeds, torque_power_q24);
    let ratio = Ratio128::new(shares.of_powers(speeds, torque_power_q24), norm);
    let mut pairs = u32::MAX;
    for (index, (power, own)) in noise.iter_mut().zip(own).take(plan.single).enumerate() {
        *own = own.saturating_sub(log2_q8(*power));
        let level = *power - folded.saturating_sub(jitter).min(*power / 8 * 7);
        *power = if index < LOW_ORDERS {
            let low = low_noise(speeds, shares, index, fine, |b| {
                Ratio128::new(u128::from(torque_power_q24(b)) << 32, norm).times(level)
            });
            pairs = pairs.min(low.pairs);
            low.power
        } else {
            ratio.times(level)
        };
    }
    for power in noise {
        *power = (*power).max(1);
    }
    pairs
}

/// A quotient of two large numbers, as a factor.
struct Ratio128 {
    q40: u128,
}

impl Ratio128 {
    fn new(numerator: u128, denominator: u128) -> Self {
        // Whatever is lost of either is below one part in a million.
        let down = 88_u32.saturating_sub(numerator.leading_zeros());
        Self {
            q40: ((numerator >> down) << 40) / (denominator >> down).max(1),
        }
    }

    fn times(&self, value: u64) -> u64 {
        u64::try_from(u128::from(value).saturating_mul(self.q40) >> 40).unwrap_or(u64::MAX)
    }
}

/// Noise of one of the lowest orders.
pub(super) struct LowNoise {
    /// Expected.
    pub power: u64,
    /// Pairs of turns that it is worth; all there can be where none were compared.
    pub pairs: u32,
}

/// Noise at one of the lowest orders of the estimate whose turns have `shares`; `expected` of a turn of a bin where no pairs tell.
///
/// Few pairs are no exact measure of noise, and intervals must be as much wider as Student's are: by 1 + 2 / pairs, with so many pairs
/// as the speeds together are worth (Satterthwaite).
pub(super) fn low_noise(
    speeds: &Speeds,
    shares: &Shares,
    index: usize,
    fine: Fine,
    expected: impl Fn(usize) -> u64,
) -> LowNoise {
    let (mut sum, mut spread) = (0_u128, 0_u128);
    for (b, bin) in speeds
        .bins
        .iter()
        .enumerate()
        .filter(|(_, bin)| bin.count() > 0)
    {
        let power = low_power(bin, index, expected(b), fine);
        let noise = shares.of_power(speeds, b, power) >> 32;
        sum += noise;
        if let Some(part) = noise.saturating_mul(noise).checked_div(bin.pairs.into()) {
            spread = spread.saturating_add(part);
        }
    }
    let pairs = sum.checked_div(spread / sum.max(1)).unwrap_or(u128::MAX);
    LowNoise {
        power: u64::try_from(sum + 2 * (spread / sum.max(1))).unwrap_or(u64::MAX),
        pairs: u32::try_from(pairs).unwrap_or(u32::MAX),
    }
}

/// Power of one of the lowest orders in one turn of a bin, by the pairs of turns compared; by what is `expected` where there
/// are none, and by both where there are few, as a pair or two can look quiet by chance.
pub(super) fn low_power(bin: &Bin, index: usize, expected: u64, fine: Fine) -> u64 {
    let pairs = u64::from(bin.pairs);
    if pairs == 0 {
        return expected;
    }
    // From 2^-(32 + LOW_BITS) turn to the coefficients' unit, and a pair has two turns.
    let up = 2 * (fine.bits + COEFFICIENT_BITS - LOW_BITS);
    let pair_q16 = u128::from(pair_excess_q16(&bin.scatter));
    let scatter =
        (u128::from(bin.scatter[index]) << (up + 16 - 1)) / (u128::from(pairs) * pair_q16);
    let seen = u64::try_from(scatter).unwrap_or(u64::MAX);
    let prior = 4_u64.saturating_sub(pairs);
    // What neighbours share cancels in a sum but at its ends, and every gap adds two.
    let gaps = bin.runs().saturating_sub(1);
    let ends_q16 = (pair_q16 - (1 << 16)) * u128::from(gaps) / u128::from(bin.count().max(1));
    let ends = (u128::from(seen) * ends_q16) >> 16;
    let seen = seen.saturating_add(u64::try_from(ends).unwrap_or(u64::MAX));
    (seen / (pairs + prior)).saturating_mul(pairs)
        + (expected / (pairs + prior)).saturating_mul(prior)
}

/// Noise of the weighed mean at every order that is not single: jitter of time stamps, and the tail of torque, whose power at
/// the last single order is `last`.
pub(super) fn common_noise(
    plan: OrderPlan,
    speeds: &Speeds,
    shares: &Shares,
    last: u64,
    fine: Fine,
) -> u64 {
    let jitter = u128::from(jitter_power(plan, speeds, shares, fine));
    // Beyond K the sum of (K / n)^4 is K / 3.
    let tail =
        u128::from(last) * 2 * plan.single as u128 / (3 * plan.common_count().max(1) as u128);
    u64::try_from(jitter + tail).unwrap_or(u64::MAX).max(1)
}

/// Power at every order of what jitter of the time stamps makes of an estimate.
pub(super) fn jitter_power(plan: OrderPlan, speeds: &Speeds, shares: &Shares, fine: Fine) -> u64 {
    let norm = shares.of_powers(speeds, |b| {
        power_of_two((16 << LOG2_BITS) - 2 * octaves_q16(b))
    });
    // From squared step fractions to squared fine units, of N edges to one order.
    let up = 2 * (32 - STEP_FRACTION_BITS + fine.bits);
    let edges = plan.edges as u128;
    let per_edge = ((jitter_q16(plan, speeds) * (norm >> 32)) << up) >> (32 - POWER_BITS);
    u64::try_from(per_edge / (edges * edges * edges)).unwrap_or(u64::MAX)
}

/// Power of what the time stamp of one edge is uncertain by, at the first turn's speed.
pub(super) fn stamp_power(plan: OrderPlan, speeds: &Speeds, fine: Fine) -> u64 {
    let up = 2 * (32 - STEP_FRACTION_BITS + fine.bits);
    let edges = plan.edges as u128;
    let power = ((jitter_q16(plan, speeds) << up) >> (16 - POWER_BITS)) / (edges * edges);
    u64::try_from(power).unwrap_or(u64::MAX)
}

/// Variance of a time stamp at the first turn's speed, in squared step fractions, Q16: a second difference of two turns has
/// twelve of them. The speed that shows least of it counts, as all else that makes turns differ only adds.
fn jitter_q16(plan: OrderPlan, speeds: &Speeds) -> u128 {
    let of_bin = |(b, bin): (usize, &Bin)| {
        let square_q16 = power_of_two((16 << LOG2_BITS) + 2 * octaves_q16(b));
        let sum_q16 = u128::from(bin.jitter) * u128::from(square_q16);
        sum_q16.checked_div(12 * plan.edges as u128 * u128::from(bin.jitter_turns))
    };
    speeds
        .bins
        .iter()
        .enumerate()
        .filter_map(of_bin)
        .min()
        .unwrap_or(0)
}

/// How much more pairs of turns differ than their long-run noise, Q16.
///
/// A motion through the ends of two turns follows a wandering speed imperfectly, and neighbours share the blame, so that it
/// cancels in the sum but not in a difference. Where speed wanders like a random walk (its noise falls with the fourth power
/// of the order down to order 1) pairs show twice the noise, where it forgets within a fraction of a turn (order 1 far below
/// that slope) just the noise; in between, `1 + 0.95 x^2` with x = order 1 over slope is within 5 %, by simulation. The sum itself has 5 % more
/// than the long-run noise in the first case, which leaves 0.9.
fn pair_excess_q16(scatter: &[u64; LOW_ORDERS]) -> u64 {
    // Where the speed changes, so does what torque of one order makes of its neighbours: the lesser of two slopes is noise alone.
    let slope = slope_of(scatter, 2..=3).min(slope_of(scatter, 4..=6));
    let ratio_q16 = (u128::from(scatter[0]) << 16) / u128::from(slope.max(1));
    let ratio_q16 = u64::try_from(ratio_q16).unwrap_or(u64::MAX).min(5 << 14);
    const EXCESS_Q16: u64 = 58_982;
    (1 << 16) + ((((ratio_q16 * ratio_q16) >> 16) * EXCESS_Q16) >> 16)
}

/// Logarithm of a power, Q8, as short as [`Estimate::own`](super::weigh::Estimate::own) is kept.
fn log2_q8(power: u64) -> i16 {
    #[allow(clippy::cast_possible_truncation)]
    let short = (log2(power.into()) >> (LOG2_BITS - 8)) as i16;
    short
}

/// Mean over orders of the scatter times the order's fourth power: the same at all of them where speed is a random walk.
fn slope_of(scatter: &[u64; LOW_ORDERS], orders: RangeInclusive<usize>) -> u64 {
    let (mut sum, mut count) = (0_u64, 0);
    for order in orders {
        sum = sum.saturating_add(scatter[order - 1].saturating_mul((order as u64).pow(4)));
        count += 1;
    }
    sum / count
}

/// Square of the shaft's damping over its slowest speed, Q16, as far as the noise shows it: torque swings the speed by
/// 1 / (i n w + d), so at order 1 a damped shaft has less noise than the orders above promise, by 1 + (d / w)^2. Two standard errors
/// of that are taken off, and where jitter of the time stamps rules the orders above nothing is known of it. What does not show may
/// be there all the same.
pub(super) fn damping_square_q16(speeds: &Speeds) -> u64 {
    let slowest = speeds.bins.iter().rfind(|bin| bin.pairs >= 3);
    let shown = slowest.map_or(0, |bin| {
        let [middle, upper] = [3..=3, 6..=6].map(|order| slope_of(&bin.scatter, order));
        if upper / 4 > middle {
            return 0;
        }
        let ratio_q16 =
            (u128::from(slope_of(&bin.scatter, 4..=6)) << 16) / u128::from(bin.scatter[0].max(1));
        let root_q8 = u128::from((u64::from(bin.pairs) << 16).isqrt());
        let ratio_q16 = ratio_q16 * root_q8 / (root_q8 + 2 * 256);
        u64::try_from(ratio_q16)
            .unwrap_or(u64::MAX)
            .clamp(1 << 16, 17 << 16)
            - (1 << 16)
    });
    shown.max(HIDDEN_DAMPING_SQUARE_Q16)
}

/// Damping that no scatter of a few turns shows: a quarter of the slowest speed.
const HIDDEN_DAMPING_SQUARE_Q16: u64 = (1 << 16) / 16;

/// Replaces the noise at every single order by its level; the logarithms of what was there go to `own`. The level is the
/// geometric mean over the neighbours, with a slope of the fourth power that ends in `floor` taken out, and not below the same
/// mean over [`ORDERS_ABOVE`] orders from there up: few neighbours are no good judge of noise.
fn smooth_noise(
    plan: OrderPlan,
    noise: &mut [u64; ORDERS_MAX],
    own: &mut [i16; ORDERS_MAX],
    floor: u64,
) {
    let mut scratch = [0; ORDERS_MAX];
    // Mean of the logarithm of an exponential distribution: -0.5772 / ln 2 = -0.8327 octaves.
    const MEAN_OVER_LOG_MEAN: i64 = 54_574;
    let fourth = |order: usize| 4 * log2(order as u128);
    // The slope's size, from orders where it rules if it rules at all.
    let (mut sum, mut count) = (0_i64, 0_i64);
    for order in single_orders(plan) {
        own[order - 1] = log2_q8(noise[order - 1]);
        if SLOPE_ORDERS.contains(&order) {
            sum += i64::from(log2(noise[order - 1].into()) + fourth(order));
            count += 1;
        }
    }
    #[allow(clippy::cast_possible_truncation)]
    let size = (sum / count.max(1)) as i32;
    // Of slope and floor together, over one: what is taken out.
    let slope = |order: usize| {
        let rest = exp2(size - fourth(order)).max(1);
        -log2(u128::from(rest) + u128::from(floor))
    };
    for order in single_orders(plan) {
        scratch[order - 1] = log2(noise[order - 1].into()) + slope(order);
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
        noise[order - 1] = level.max(1);
    }
}

/// Orders that tell the size of the slope: above the lowest, which may be flatter, and below those where jitter rules.
const SLOPE_ORDERS: RangeInclusive<usize> = 7..=18;

/// Orders that the noise at an order is judged from at the least.
const ORDERS_ABOVE: usize = 24;

//! What the turns say of the noise at every order.
//!
//! At the lowest orders, which hold nearly all of it, turns of like speed are compared pair by pair. Above, the contrast
//! speaks: noise of a shaft falls with the fourth power of the order, so its level is averaged over neighbours after that
//! slope is taken out. High orders know no torque; there, time stamps' jitter is all.

use core::ops::RangeInclusive;
use core::task::Poll;

use super::locked::NoiseShares;
use super::low::{LOW_BITS, LOW_ORDERS};
use super::moments::Shares;
use super::order::OrderPlan;
use super::scale::Fine;
use super::spectrum::{COEFFICIENT_BITS, POWER_BITS};
use super::speeds::{Speeds, octaves_q16, power_of_two};
use crate::log2::LOG2_BITS;
use crate::units::STEP_FRACTION_BITS;
use crate::wide::over;

/// Noise of one of the lowest orders.
pub(super) struct LowNoise {
    /// Expected.
    pub power: u64,
    /// Pairs of turns that it is worth; all there can be where none were compared.
    pub pairs: u32,
}

/// Noise at one of the lowest orders of an estimate, added up over the speeds.
///
/// Few pairs are no exact measure of noise, and intervals must be as much wider as Student's are: by 1 + 2 / pairs, with so many pairs
/// as the speeds together are worth (Satterthwaite). Neighbouring pairs share a turn, so three are worth two.
pub(super) struct LowSum {
    /// Of the order less one.
    pub index: usize,
    sum: u128,
    spread: u128,
    /// The next bin to look at, and the power of one turn of it once that is known.
    bin: usize,
    power: Option<u64>,
}

impl LowSum {
    pub(super) const fn of(index: usize) -> Self {
        Self {
            index,
            sum: 0,
            spread: 0,
            bin: 0,
            power: None,
        }
    }

    /// Adds a speed of the estimate, in two slices: the power of its turns first, then what their `shares` make of it.
    /// `expected` of a turn of a bin where no pairs tell.
    pub(super) fn slice(
        &mut self,
        scatter: Scatter<'_>,
        shares: &Shares,
        expected: impl Fn(usize) -> u64,
    ) -> Poll<LowNoise> {
        let speeds = scatter.speeds;
        let Some((b, bin)) = speeds.taken().find(|(b, _)| *b >= self.bin) else {
            return Poll::Ready(self.noise());
        };
        let Some(power) = self.power.take() else {
            self.power = Some(scatter.low_power(b, self.index, expected(b)));
            return Poll::Pending;
        };
        self.bin = b + 1;
        let noise = shares.of_power(speeds, b, power) >> 32;
        self.sum += noise;
        let square = noise.saturating_mul(noise).saturating_mul(3);
        if bin.pairs > 0 {
            let part = over(square, 2 * u128::from(bin.pairs));
            self.spread = self.spread.saturating_add(part);
        }
        Poll::Pending
    }

    fn noise(&self) -> LowNoise {
        let one_pair = over(self.spread, self.sum);
        let pairs = if one_pair == 0 {
            u128::MAX
        } else {
            over(self.sum, one_pair)
        };
        LowNoise {
            power: u64::try_from(self.sum + 2 * one_pair).unwrap_or(u64::MAX),
            pairs: u32::try_from(pairs).unwrap_or(u32::MAX),
        }
    }
}

/// What the scatter of pairs of turns is read with.
#[derive(Clone, Copy)]
pub(super) struct Scatter<'a> {
    pub speeds: &'a Speeds,
    pub noise: &'a NoiseShares,
    /// In the squared unit of `fine`.
    pub stamp: Stamp,
    pub fine: Fine,
}

impl Scatter<'_> {
    /// Power of one of the lowest orders in one turn of a bin, by the pairs of turns compared; by what is `expected` where there
    /// are none, and by both where there are few, as a pair or two can look quiet by chance.
    ///
    /// A stamp that is uncertain at the crossing of edge 0 tilts the turns on either side of it against each other. In a pair of turns that
    /// counts three times, in a sum at the ends of a row alone, where turns may count thrice as much as others.
    pub(super) fn low_power(&self, b: usize, index: usize, expected: u64) -> u64 {
        let Self {
            speeds,
            noise,
            stamp,
            fine,
        } = *self;
        let bin = &speeds.bins[b];
        let pairs = u64::from(bin.pairs);
        if pairs == 0 {
            return expected;
        }
        let scatter = noise.of(&bin.scatter);
        // From 2^-(32 + LOW_BITS) turn to the coefficients' unit, and a pair has two turns.
        let up = 2 * (fine.bits + COEFFICIENT_BITS - LOW_BITS);
        let pair_q16 = u128::from(pair_excess_q16(&scatter));
        let scatter = over(
            u128::from(scatter[index]) << (up + 16 - 1),
            u128::from(pairs) * pair_q16,
        );
        let seen = u64::try_from(scatter).unwrap_or(u64::MAX);
        let prior = 4_u64.saturating_sub(pairs);
        let (count, at_ends) = (u64::from(bin.count()), 2 * u64::from(bin.runs().max(1)));
        let tilts = u128::from(tilt_power(stamp.edge, b, index))
            * u128::from(3 * pairs * count.saturating_sub(3 * at_ends));
        let tilts = u64::try_from(over(tilts, count.max(1).into())).unwrap_or(u64::MAX);
        let alike = at_speed(stamp.order, b).saturating_mul(pairs);
        let seen = seen.saturating_sub(tilts).max(seen.min(alike));
        // What neighbours share cancels in a sum but at its ends, and every gap adds two.
        let gaps = bin.runs().saturating_sub(1);
        let ends_q16 = over(
            (pair_q16 - (1 << 16)) * u128::from(gaps),
            bin.count().max(1).into(),
        );
        let ends = (u128::from(seen) * ends_q16) >> 16;
        let seen = seen.saturating_add(u64::try_from(ends).unwrap_or(u64::MAX));
        (seen / (pairs + prior)).saturating_mul(pairs)
            + (expected / (pairs + prior)).saturating_mul(prior)
    }
}

/// Power at one of the lowest orders in a turn, mean over the bins whose turns were compared.
pub(super) struct MeanLowPower {
    sum: u128,
    turns: u128,
    /// The next bin to look at.
    bin: usize,
}

impl MeanLowPower {
    pub(super) const START: Self = Self {
        sum: 0,
        turns: 0,
        bin: 0,
    };

    /// Adds a bin; none in the end where few turns were compared.
    pub(super) fn slice(&mut self, scatter: Scatter<'_>, index: usize) -> Poll<Option<u64>> {
        let Some((b, bin)) = scatter.speeds.taken().find(|(b, _)| *b >= self.bin) else {
            let mean = |turns| u64::try_from(over(self.sum, turns)).unwrap_or(u64::MAX);
            return Poll::Ready((self.turns >= 4).then(|| mean(self.turns)));
        };
        self.bin = b + 1;
        let power = scatter.low_power(b, index, 0);
        self.sum += u128::from(power) * u128::from(bin.pairs);
        self.turns += u128::from(bin.pairs);
        Poll::Pending
    }
}

/// Power at one of the lowest orders of a turn of a bin whose end is off by what a time stamp is, of which `stamp` is the power at the first
/// turn's speed: 1 / (2 pi n)^2 of it.
fn tilt_power(stamp: u64, b: usize, index: usize) -> u64 {
    const OVER_Q16: u64 = 1660;
    let order = index as u64 + 1;
    at_speed(stamp, b).saturating_mul(OVER_Q16) / ((order * order) << 16)
}

/// A time stamp's power at a bin's speed over that at the first turn's.
pub(super) fn at_speed(power: u64, b: usize) -> u64 {
    let ratio_q16 = power_of_two((16 << LOG2_BITS) - 2 * octaves_q16(b));
    u64::try_from((u128::from(power) * u128::from(ratio_q16)) >> 16).unwrap_or(u64::MAX)
}

/// Power at every order of what jitter of the time stamps makes of an estimate.
pub(super) fn jitter_power(
    plan: OrderPlan,
    speeds: &Speeds,
    shares: &Shares,
    jitter_q16: u128,
    fine: Fine,
) -> u64 {
    let norm = shares.of_powers(speeds, |b| {
        power_of_two((16 << LOG2_BITS) - 2 * octaves_q16(b))
    });
    // From squared step fractions to squared fine units, of N edges to one order.
    let up = 2 * (32 - STEP_FRACTION_BITS + fine.bits);
    let edges = plan.edges as u128;
    let per_edge = ((jitter_q16 * (norm >> 32)) << up) >> (32 - POWER_BITS);
    u64::try_from(over(per_edge, edges * edges * edges)).unwrap_or(u64::MAX)
}

/// Powers of what time stamps are uncertain by, at the first turn's speed.
#[derive(Clone, Copy)]
pub(super) struct Stamp {
    /// At one edge.
    pub edge: u64,
    /// At an order of a turn, of all its edges.
    pub order: u64,
}

impl Stamp {
    pub(super) const NONE: Self = Self { edge: 0, order: 0 };

    pub(super) fn of(plan: OrderPlan, jitter_q16: u128, fine: Fine) -> Self {
        let up = 2 * (32 - STEP_FRACTION_BITS + fine.bits);
        let edges = plan.edges as u128;
        let power = over((jitter_q16 << up) >> (16 - POWER_BITS), edges * edges);
        let edge = u64::try_from(power).unwrap_or(u64::MAX);
        Self {
            edge,
            order: edge / plan.edges as u64,
        }
    }
}

/// Variance of a time stamp at the first turn's speed, in squared step fractions, Q16: a second difference of two turns has
/// twelve of them. The speed that shows least of it counts, as all else that makes turns differ only adds.
pub(super) fn jitter_q16(plan: OrderPlan, speeds: &Speeds) -> u128 {
    // The least of sum / turns, without a division each.
    let mut least: Option<(u128, u128)> = None;
    for (b, bin) in speeds.bins.iter().enumerate() {
        if bin.jitter_turns == 0 {
            continue;
        }
        let square_q16 = power_of_two((16 << LOG2_BITS) + 2 * octaves_q16(b));
        let sum_q16 = u128::from(bin.jitter) * u128::from(square_q16);
        let turns = u128::from(bin.jitter_turns);
        let less =
            |(least_q16, of)| sum_q16.saturating_mul(of) < u128::saturating_mul(least_q16, turns);
        if least.is_none_or(less) {
            least = Some((sum_q16, turns));
        }
    }
    least.map_or(0, |(sum_q16, turns)| {
        over(sum_q16, 12 * plan.edges as u128 * turns)
    })
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
    let ratio_q16 = over(u128::from(scatter[0]) << 16, slope.max(1).into());
    let ratio_q16 = u64::try_from(ratio_q16).unwrap_or(u64::MAX).min(5 << 14);
    const EXCESS_Q16: u64 = 58_982;
    (1 << 16) + ((((ratio_q16 * ratio_q16) >> 16) * EXCESS_Q16) >> 16)
}

/// Mean over orders of the scatter times the order's fourth power: the same at all of them where speed is a random walk.
#[inline(never)]
pub(super) fn slope_of(scatter: &[u64; LOW_ORDERS], orders: RangeInclusive<usize>) -> u64 {
    let (mut sum, mut count) = (0_u64, 0);
    for order in orders {
        sum = sum.saturating_add(scatter[order - 1].saturating_mul((order as u64).pow(4)));
        count += 1;
    }
    sum / count
}

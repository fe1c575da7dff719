//! How the shaft is damped, as far as torque may pass for geometry by it: what the torque itself tells, and what the noise shows.

use core::task::{Poll, ready};

use super::course::Falls;
use super::cursor::Cursor;
use super::damped::{Damped, Telling, Told};
use super::low::LOW_ORDERS;
use super::noise::{MeanLowPower, Scatter, at_speed, slope_of};
use super::speeds::{Bin, Speeds};
use crate::log2::{LOG2_BITS, exp2, log2};
use crate::recip::Recip;
use crate::wide::over;

/// What is known of the shaft.
#[derive(Clone, Copy)]
pub(super) struct Shaft {
    pub damping: Damping,
    pub falls: Falls,
}

/// What is known of the shaft, worked out in slices.
pub(super) struct DampingFit {
    falls: Falls,
    telling: Telling,
    /// Of the noise that the torque is told through.
    noise: MeanLowPower,
    /// What the torque tells, once it does.
    told: Option<Option<Told>>,
    /// Powers at the lowest orders in a turn of the slowest bin that tells them.
    powers: [u64; LOW_ORDERS],
    cursor: Cursor,
}

impl DampingFit {
    pub(super) const fn new(falls: Falls) -> Self {
        Self {
            falls,
            telling: Telling::START,
            noise: MeanLowPower::START,
            told: None,
            powers: [0; LOW_ORDERS],
            cursor: Cursor::START,
        }
    }

    /// With the shortest and the longest turn taken, and the scatter in squared units of the lowest orders.
    #[inline(never)]
    pub(super) fn slice(
        &mut self,
        damped: &Damped,
        scatter: Scatter<'_>,
        durations: [u64; 2],
    ) -> Poll<Shaft> {
        let Self {
            falls,
            telling,
            noise,
            told,
            powers,
            cursor,
        } = self;
        let Some(told) = *told else {
            let of_order = |index| noise.slice(scatter, index);
            *told = Some(ready!(telling.slice(damped, falls.friction_q16, of_order)));
            return Poll::Pending;
        };
        let speeds = scatter.speeds;
        let slowest = speeds.bins.iter().rposition(|bin| bin.pairs >= 3);
        if let Some(b) = slowest
            && cursor.at_end(LOW_ORDERS).is_pending()
        {
            for index in cursor.next(1, LOW_ORDERS) {
                powers[index] = scatter.low_power(b, index, 0);
            }
            return Poll::Pending;
        }
        let shown_square_q16 = slowest.map_or(0, |b| {
            shown_square_q16(&speeds.bins[b], at_speed(scatter.stamp.order, b), powers)
        });
        Poll::Ready(Shaft {
            damping: Damping::of(speeds, durations, shown_square_q16, told),
            falls: *falls,
        })
    }
}

/// Squares of the shaft's damping over its slowest speed, Q32, in parts of what it makes torque pass for geometry.
#[derive(Clone, Copy)]
pub(super) struct Damping {
    /// What an order is weighed with.
    pub likely_q32: u64,
    /// What is stated: it is hardly ever more.
    pub most_q32: u64,
}

impl Damping {
    /// With the shortest and the longest turn taken, and with what the torque itself tells.
    ///
    /// Beside the angle of torque that goes with the square of a turn's duration t, damping makes one that goes with t^3. Turns of t1 and
    /// t2, the longer, have it pass for geometry by t2 / (t1 + t2) of its ratio to torque's own at t2.
    fn of(
        speeds: &Speeds,
        [shortest, longest]: [u64; 2],
        shown_square_q16: u64,
        told: Option<Told>,
    ) -> Self {
        let both = Recip::of_u64(shortest.saturating_add(longest));
        let part_q16 = (u128::from(longest) * u128::from(both.mantissa)) >> (both.shift - 16);
        let shown_q32 = shown_square_q16 << 16;
        let told_q32 = told.map_or(u64::MAX, |told| {
            let reference = Recip::of_u64(speeds.reference());
            let slowest_q16 =
                (u128::from(longest) * u128::from(reference.mantissa)) >> (reference.shift - 16);
            let square = (u128::from(told.expected_q32()) * slowest_q16 * slowest_q16) >> 32;
            u64::try_from(square).unwrap_or(u64::MAX)
        });
        let with = |hidden_q32: u64| {
            let hidden_q32 = hidden_q32.min(told_q32);
            let square = (u128::from(shown_q32.max(hidden_q32)) * part_q16 * part_q16) >> 32;
            u64::try_from(square).unwrap_or(u64::MAX)
        };
        Self {
            likely_q32: with(LIKELY_DAMPING_SQUARE_Q32),
            most_q32: with(HIDDEN_DAMPING_SQUARE_Q32),
        }
    }
}

impl Told {
    /// Square of the damping to expect, Q32. Either friction is all there is, or a drive damps the shaft, by anything up to a quarter of the
    /// speed: what is told comes near nothing with odds of 1 to 10 e exp(z^2 / 2) then, with the standard error e and z of them told.
    fn expected_q32(self) -> u64 {
        let square = self.size_q32.saturating_add(self.error_q32);
        let [size, error] = [self.size_q32, self.error_q32].map(|part| log2(part.into()));
        // (z^2 / 2) / ln 2, Q16.
        let unlike = exp2((size - error).min(8 << LOG2_BITS) + (16 << LOG2_BITS) - HALF_E_LOG2);
        let unlike = i32::try_from(unlike).unwrap_or(i32::MAX >> 1);
        let odds = (error - (32 << LOG2_BITS)) / 2 + TEN_LOG2 + unlike;
        exp2(log2(square.into()) + odds.min(0))
    }
}

/// log2 of 10 and of 2 ln 2, Q16.
const TEN_LOG2: i32 = 217_706;
const HALF_E_LOG2: i32 = 30_882;

/// Square of the shaft's damping over its slowest speed, Q16, as far as the noise shows it: torque swings the speed by
/// 1 / (i n w + d), so at order 1 a damped shaft has less noise than the orders above promise, by 1 + (d / w)^2. Two standard errors
/// of that are taken off, and where jitter of the time stamps rules the orders above, so that the slope goes on to rise, nothing is known.
///
/// By the powers at the lowest orders in the slowest bin that tells.
fn shown_square_q16(bin: &Bin, stamp: u64, powers: &[u64; LOW_ORDERS]) -> u64 {
    if powers[LOW_ORDERS - 1] / 4 < stamp {
        return 0;
    }
    let [middle, upper] = [3..=3, 6..=6].map(|order| slope_of(powers, order));
    // So they do where torque locked to the shaft changes with the speed.
    let [low, high] = [2..=3, 5..=6].map(|orders| slope_of(powers, orders));
    if upper / 4 > middle || high / 7 > low / 2 {
        return 0;
    }
    let ratio_q16 = over(
        u128::from(slope_of(powers, 4..=6)) << 16,
        powers[0].max(1).into(),
    );
    let root_q8 = u128::from((u64::from(bin.pairs) << 16).isqrt());
    let ratio_q16 = over(ratio_q16 * root_q8, root_q8 + 2 * 256);
    u64::try_from(ratio_q16)
        .unwrap_or(u64::MAX)
        .clamp(1 << 16, 17 << 16)
        - (1 << 16)
}

/// Damping that no scatter of a few turns shows: a quarter of the slowest speed.
const HIDDEN_DAMPING_SQUARE_Q32: u64 = (1 << 32) / 16;

/// A quarter of that. Sizes are asked to be twelve times the noise in power, for chance; of a limit they need not be more than it.
const LIKELY_DAMPING_SQUARE_Q32: u64 = HIDDEN_DAMPING_SQUARE_Q32 / 16;

//! From what a contrast shows to the noise of an estimate at every order.

use core::task::{Poll, ready};

use super::contrast::Leftovers;
use super::cursor::Cursor;
use super::locked::NoiseShares;
use super::low::LOW_ORDERS;
use super::moments::{Mean, Moments, Shares, torque_power_q24};
use super::noise::{LowSum, Scatter, Stamp, jitter_power};
use super::order::{ORDERS_MAX, OrderPlan};
use super::scale::Fine;
use super::smooth::Smoothing;
use super::speeds::Speeds;
use crate::wide::over;

/// Orders of a slice.
const ORDERS: usize = 32;

/// Whose noise is looked for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Estimated {
    /// What the plain mean differs from the weighed one.
    Difference,
    /// The weighed mean.
    Weighed,
}

/// Turns the powers of a contrast into the noise of an estimate, in 2^-[`POWER_BITS`] of the squared fine unit.
pub(super) struct Settling {
    part: Part,
    estimated: Estimated,
    /// Shares of the turns: in the contrast at first, then in the estimate.
    shares: Shares,
    /// What white torque noise comes to in the contrast.
    norm: u128,
    /// The same in the estimate over that.
    ratio: Ratio128,
    /// Jitter's power at every order, and what of it is folded on those that blocks can tell from all above.
    jitter: u64,
    folded: u64,
    /// Pairs of turns that the noise of the lowest orders rests on.
    pairs: u32,
    cursor: Cursor,
}

// What one part works with takes the place of the last one's.
#[allow(clippy::large_enum_variant)]
enum Part {
    Contrast,
    Norm,
    Ratio,
    Jitter,
    Smooth(Smoothing),
    Low(LowSum),
    Rest,
}

/// What an estimate is known from.
#[derive(Clone, Copy)]
pub(super) struct Known<'a> {
    pub plan: OrderPlan,
    pub moments: &'a Moments,
    pub leftovers: Leftovers,
    pub speeds: &'a Speeds,
    pub noise_shares: &'a NoiseShares,
    /// As [`jitter_q16`] has it.
    pub jitter_q16: u128,
    pub fine: Fine,
}

/// What is found beside the noise itself.
#[derive(Clone, Copy)]
pub(super) struct Settled {
    /// Noise of the orders above the single ones.
    pub common: u64,
    /// Pairs of turns that the noise of the lowest orders rests on.
    pub low_pairs: u32,
}

impl Settling {
    pub(super) fn of(estimated: Estimated) -> Self {
        Self {
            part: Part::Contrast,
            estimated,
            shares: Shares::NONE,
            norm: 0,
            ratio: Ratio128 { q40: 0 },
            jitter: 0,
            folded: 0,
            pairs: u32::MAX,
            cursor: Cursor::START,
        }
    }

    /// Whose noise this is about.
    pub(super) const fn estimated(&self) -> Estimated {
        self.estimated
    }

    /// Order n of the noise is at n - 1; logarithms of what the contrast showed at each order itself over twice its level, in
    /// 2^-[`OWN_BITS`](super::smooth::OWN_BITS) octave, go to `own`.
    #[inline(never)]
    pub(super) fn slice(
        &mut self,
        known: Known<'_>,
        noise: &mut [u64; ORDERS_MAX],
        own: &mut [u8; ORDERS_MAX],
    ) -> Poll<Settled> {
        let Known { plan, speeds, .. } = known;
        match &mut self.part {
            Part::Contrast => {
                self.set_shares(|mean| known.contrast(mean));
                self.part = Part::Norm;
            }
            Part::Norm => {
                self.norm = self.shares.of_powers(speeds, torque_power_q24);
                self.set_shares(|mean| known.moments.shares(mean));
                self.part = Part::Ratio;
            }
            Part::Ratio => {
                let of_estimate = self.shares.of_powers(speeds, torque_power_q24);
                self.ratio = Ratio128::new(of_estimate, self.norm);
                self.part = Part::Jitter;
            }
            Part::Jitter => {
                self.jitter =
                    jitter_power(plan, speeds, &self.shares, known.jitter_q16, known.fine);
                let folds = (plan.edges / plan.blocks) as u64 - 1;
                self.folded = self.jitter.saturating_mul(folds);
                self.part = Part::Smooth(Smoothing::START);
            }
            Part::Smooth(smoothing) => {
                let floor = self.jitter.saturating_add(self.folded);
                ready!(smoothing.slice(plan, noise, own, floor));
                self.part = Part::Low(LowSum::of(0));
            }
            Part::Low(low) => {
                let index = low.index;
                let level = level(noise[index], self.folded);
                let norm = self.norm;
                let scatter = Scatter {
                    speeds,
                    noise: known.noise_shares,
                    stamp: Stamp::of(plan, known.jitter_q16, known.fine),
                    fine: known.fine,
                };
                let found = ready!(low.slice(scatter, &self.shares, |b| {
                    Ratio128::new(u128::from(torque_power_q24(b)) << 32, norm).times(level)
                }));
                noise[index] = found.power.max(1);
                self.pairs = self.pairs.min(found.pairs);
                self.part = if index + 1 < LOW_ORDERS.min(plan.single) {
                    Part::Low(LowSum::of(index + 1))
                } else {
                    self.cursor.next(index + 1, plan.single);
                    Part::Rest
                };
            }
            Part::Rest => {
                for index in self.cursor.next(ORDERS, plan.single) {
                    noise[index] = self.ratio.times(level(noise[index], self.folded)).max(1);
                }
                ready!(self.cursor.at_end(plan.single));
                return Poll::Ready(Settled {
                    common: self.common(plan, noise[plan.single - 1]),
                    low_pairs: self.pairs,
                });
            }
        }
        Poll::Pending
    }

    /// Sets the shares of the turns in what is estimated, from those in both means.
    #[inline(never)]
    fn set_shares(&mut self, of_mean: impl Fn(Mean) -> Shares) {
        match self.estimated {
            Estimated::Weighed => self.shares = of_mean(Mean::Weighed),
            Estimated::Difference => {
                self.shares = of_mean(Mean::Plain);
                self.shares.take_off(&of_mean(Mean::Weighed));
            }
        }
    }

    /// Noise at every order that is not single: jitter of time stamps, and the tail of torque, whose power at the last single order is
    /// `last`.
    fn common(&self, plan: OrderPlan, last: u64) -> u64 {
        // Beyond K the sum of (K / n)^4 is K / 3.
        let tail = over(
            u128::from(last) * 2 * plan.single as u128,
            3 * plan.common_count().max(1) as u128,
        );
        u64::try_from(u128::from(self.jitter) + tail)
            .unwrap_or(u64::MAX)
            .max(1)
    }
}

impl Known<'_> {
    fn contrast(&self, mean: Mean) -> Shares {
        let leftover = match mean {
            Mean::Plain => self.leftovers.plain,
            Mean::Weighed => self.leftovers.weighed,
        };
        self.moments.contrast(mean, leftover)
    }
}

/// What of the level that a contrast shows is torque and the order's own jitter.
fn level(shown: u64, folded: u64) -> u64 {
    shown - folded.min(shown / 8 * 7)
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
            q40: over((numerator >> down) << 40, denominator >> down),
        }
    }

    fn times(&self, value: u64) -> u64 {
        u64::try_from(u128::from(value).saturating_mul(self.q40) >> 40).unwrap_or(u64::MAX)
    }
}

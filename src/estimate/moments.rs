//! What the turns' speeds make of signal and noise: how far geometry and torque come apart, and how much of the noise is left.
//!
//! With w the weight of a turn in the sum, u the square of its duration over the first one's, g geometry and r the angle that
//! locked torque makes at the first turn's speed, the weighed mean is g + r u_w and the plain mean g + r u_1. White torque
//! noise makes angle noise with power as the cube of the duration.

use core::task::Poll;

use super::scale::Ratio;
use super::speeds::{BINS, Bin, Speeds, Weighing, octaves_q16, power_of_two};
use crate::log2::LOG2_BITS;
use crate::wide::{over, over_signed};

/// One, in the unit of a turn's share of an estimate.
const ONE_Q30: i64 = 1 << 30;

/// What a turn of each speed adds to an estimate: Q30, for turns that count plus and minus in the contrasts.
#[derive(Clone, Copy)]
pub(super) struct Shares([[i64; 2]; BINS]);

/// The weighed mean and the plain one.
#[derive(Clone, Copy)]
pub(super) enum Mean {
    Weighed,
    Plain,
}

/// Moments of all turns.
pub(super) struct Moments {
    pub weight_q16: u64,
    pub turns: u32,
    /// Share of a turn of each bin in the weighed mean, and of any turn in the plain one, Q30.
    weighed: [i64; BINS],
    plain: i64,
    /// u_w and u_1, Q32.
    weighed_square: i128,
    plain_square: i128,
    /// u_w / (u_1 - u_w), Q30, where the speeds differ enough to tell geometry from torque.
    pub separation: Option<i64>,
}

impl Moments {
    pub(super) const NONE: Self = Self {
        weight_q16: 0,
        turns: 0,
        weighed: [0; BINS],
        plain: 0,
        weighed_square: 0,
        plain_square: 0,
        separation: None,
    };

    pub(super) fn of(speeds: &Speeds, weighing: &Weighing, two_speeds: bool) -> Self {
        let bins = &speeds.bins;
        let turns: u32 = bins.iter().map(Bin::count).sum();
        let weight_q16: u64 = (0..BINS)
            .map(|b| u64::from(bins[b].count()) * weighing.weight_q16(b))
            .sum();
        let share = Ratio::new(30, weight_q16);
        let weighed: [i64; BINS] =
            core::array::from_fn(|b| share.times(weighing.weight_q16(b).cast_signed()));
        let square = |b: usize| i128::from(bins[b].square());
        let weighed_square = (0..BINS)
            .map(|b| (square(b) * i128::from(weighed[b])) >> 30)
            .sum();
        let plain_square = over_signed((0..BINS).map(square).sum(), turns.max(1).into());
        let difference = plain_square - weighed_square;
        let separation = if two_speeds && difference > 0 {
            i64::try_from(over_signed(weighed_square << 30, difference)).ok()
        } else {
            None
        };
        Self {
            weight_q16,
            turns,
            weighed,
            plain: ONE_Q30 / i64::from(turns.max(1)),
            weighed_square,
            plain_square,
            // Two turns leave nothing in the contrast. How little speeds near each other tell is in every order's doubt.
            separation: separation.filter(|_| turns > 3),
        }
    }

    /// Share of a turn of a bin in a mean, Q30.
    fn share(&self, mean: Mean, bin: usize) -> i64 {
        match mean {
            Mean::Weighed => self.weighed[bin],
            Mean::Plain => self.plain,
        }
    }

    /// Shares of the turns in a mean.
    pub(super) fn shares(&self, mean: Mean) -> Shares {
        Shares(core::array::from_fn(|b| [self.share(mean, b); 2]))
    }

    /// What the contrast of a mean holds of geometry and of torque, as a combination of the weighed and the plain mean, Q30.
    pub(super) fn leftover(&self, mean: Mean, speeds: &Speeds) -> [i64; 2] {
        let (mut geometry, mut torque) = (0_i128, 0_i128);
        for (b, bin) in speeds.taken() {
            let share = i128::from(self.share(mean, b));
            let signed = |x: [i128; 2]| x[0] - x[1];
            geometry += share * signed(bin.turns.map(i128::from));
            torque += (share * signed(bin.squares.map(i128::from))) >> 30;
        }
        let plain = if self.separation.is_some() {
            // a u_w + b u_1 = torque, a + b = geometry
            let excess = torque - ((geometry * self.weighed_square) >> 30);
            over_signed(
                excess << 30,
                (self.plain_square - self.weighed_square).max(1),
            )
        } else {
            0
        };
        #[allow(clippy::cast_possible_truncation)]
        [(geometry - plain) as i64, plain as i64]
    }

    /// Shares of the turns in the contrast of a mean, less what it holds of geometry and torque, its `leftover`.
    pub(super) fn contrast(&self, mean: Mean, leftover: [i64; 2]) -> Shares {
        let [weighed, plain] = leftover.map(i128::from);
        Shares(core::array::from_fn(|b| {
            let share = self.share(mean, b);
            let repeats = weighed * i128::from(self.share(Mean::Weighed, b))
                + plain * i128::from(self.share(Mean::Plain, b));
            #[allow(clippy::cast_possible_truncation)]
            let repeats = (repeats >> 30) as i64;
            [share - repeats, -share - repeats]
        }))
    }

    /// Torque's angle at the first turn's speed over its part in the plain less the weighed mean: 1 / (u_1 - u_w), Q30.
    pub(super) fn torque_scale_q30(&self) -> i64 {
        let difference = (self.plain_square - self.weighed_square).max(1);
        i64::try_from(over_signed(1 << 62, difference)).unwrap_or(i64::MAX)
    }
}

/// Mean of the turns' speed over the first one's, as the weighed mean has it.
#[derive(Default)]
pub(super) struct MeanSpeed {
    sum_q16: u128,
    /// The next bin to look at.
    bin: usize,
}

impl MeanSpeed {
    /// In the end, Q16.
    pub(super) fn slice(&mut self, moments: &Moments, speeds: &Speeds) -> Poll<u64> {
        let Some((b, bin)) = speeds.taken().find(|(b, _)| *b >= self.bin) else {
            return Poll::Ready(u64::try_from(self.sum_q16).unwrap_or(u64::MAX));
        };
        self.bin = b + 1;
        // Speed is one over duration; turns of a bin are alike.
        let count = u128::from(bin.count());
        let mean_square_q32 = over(bin.square().into(), count);
        let duration_q32 = (mean_square_q32 << 32).isqrt();
        let speed_q16 = if duration_q32 == 0 {
            0
        } else {
            over(1 << 48, duration_q32)
        };
        let share = u128::from(moments.weighed[b].unsigned_abs());
        self.sum_q16 += (speed_q16 * count * share) >> 30;
        Poll::Pending
    }
}

impl Shares {
    pub(super) const NONE: Self = Self([[0; 2]; BINS]);

    /// Makes of the shares in an estimate those in what it differs from another.
    pub(super) fn take_off(&mut self, other: &Self) {
        for (shares, others) in self.0.iter_mut().zip(&other.0) {
            for (share, other) in shares.iter_mut().zip(others) {
                *share -= other;
            }
        }
    }

    /// What a power that all turns of one bin have in common comes to.
    pub(super) fn of_bin(&self, speeds: &Speeds, bin: usize, power: u64) -> u64 {
        let share_q30: i128 = (0..2)
            .map(|side| i128::from(self.0[bin][side]) * i128::from(speeds.bins[bin].turns[side]))
            .sum();
        let share_q30 = share_q30.unsigned_abs();
        let of_bin = (((share_q30 * share_q30) >> 30) * u128::from(power)) >> 30;
        u64::try_from(of_bin).unwrap_or(u64::MAX)
    }

    /// Sum over turns of share^2 x `power` of a turn of the bin: Q32 times the powers' unit.
    pub(super) fn of_powers(&self, speeds: &Speeds, power: impl Fn(usize) -> u64) -> u128 {
        let taken = speeds.taken();
        taken
            .map(|(b, _)| self.of_power(speeds, b, power(b)))
            .fold(0, u128::saturating_add)
    }

    /// The same over the turns of one bin.
    pub(super) fn of_power(&self, speeds: &Speeds, b: usize, power: u64) -> u128 {
        let sides = self.0[b].iter().zip(speeds.bins[b].turns);
        sides.fold(0, |sum, (share, turns)| {
            let share = u128::from(share.unsigned_abs());
            let square = ((share * share) >> 28) * u128::from(turns);
            sum.saturating_add(square.saturating_mul(u128::from(power)))
        })
    }
}

/// Power of white torque noise in a turn of a bin over that in one of the first turn's speed, Q24: the cube of the duration.
pub(super) fn torque_power_q24(bin: usize) -> u64 {
    power_of_two((24 << LOG2_BITS) + 3 * octaves_q16(bin))
}

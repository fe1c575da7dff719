//! What of the lowest orders' scatter is no noise but torque locked to the shaft, which changes with the speed.
//!
//! Its angle goes with the square of the durations. Where the speed goes one way through a row of turns, every pair of them differs by some
//! of it. A regression of the differences on those of the squares takes that out: recursive least squares, as the pairs come. Where the speed
//! only wanders its changes go with the noise itself, and nothing is taken out.

use core::task::Poll;

use super::close::saturated;
use super::cursor::Cursor;
use super::low::{LOW_ORDERS, LowOrder};
use crate::recip::Recip;
use crate::wide::over;

/// The regression.
pub(super) struct Locked {
    /// Torque's angle at the first turn's speed.
    orders: [LowOrder; LOW_ORDERS],
    /// Sums of the differences between the durations' squares, Q32, and of what those square to, Q28.
    trend_q32: i64,
    squares_q28: u64,
    /// Sums of the orders' squared differences, and of what the regression leaves of them.
    all: [u64; LOW_ORDERS],
    left: [u64; LOW_ORDERS],
}

impl Locked {
    pub(super) const NONE: Self = Self {
        orders: [LowOrder { re: 0, im: 0 }; LOW_ORDERS],
        trend_q32: 0,
        squares_q28: 1,
        all: [0; LOW_ORDERS],
        left: [0; LOW_ORDERS],
    };

    /// Takes a pair of turns: how much the square of the second one's duration is above the first one's, over that of the first turn of all,
    /// and how the lowest orders changed, as a turn forward sees them. A pair that tells more of the torque than all before says nothing of
    /// the noise.
    pub(super) fn take(&mut self, growth_q32: i64, changes: &[LowOrder; LOW_ORDERS]) {
        let square = u128::from(growth_q32.unsigned_abs()).pow(2) >> 36;
        let square = u64::try_from(square).unwrap_or(u64::MAX).min(1 << 48);
        let says = square <= self.squares_q28;
        self.trend_q32 = self.trend_q32.saturating_add(growth_q32);
        self.squares_q28 = self.squares_q28.saturating_add(square);
        let sum = Recip::of_u64(self.squares_q28);
        let gain_q20 = i128::from(sum.times_signed(growth_q32 << 16));
        // As large as noise makes it at a pair that is not in the regression.
        let kept_q15 = (1 << 15) - sum.times(square << 15).min(1 << 15);
        for (index, (angle, change)) in self.orders.iter_mut().zip(changes).enumerate() {
            let of_torque = |angle: i32| {
                let product = (i128::from(angle) * i128::from(growth_q32)) >> 32;
                saturated(i64::try_from(product).unwrap_or(0))
            };
            let off = change.less(LowOrder {
                re: of_torque(angle.re),
                im: of_torque(angle.im),
            });
            let with = |angle: i32, off: i32| {
                let more = (i128::from(off) * gain_q20) >> 20;
                saturated(i64::from(angle).saturating_add(i64::try_from(more).unwrap_or(0)))
            };
            *angle = LowOrder {
                re: with(angle.re, off.re),
                im: with(angle.im, off.im),
            };
            if says {
                let [all, left] = [*change, off].map(|size| size.distance(LowOrder::default()));
                let left = u64::try_from((u128::from(left) * u128::from(kept_q15)) >> 15);
                self.all[index] = self.all[index].saturating_add(all);
                self.left[index] = self.left[index].saturating_add(left.unwrap_or(u64::MAX));
            }
        }
    }

    /// How much of an order's scatter is noise, Q32: a long division, to be made once. A wandering speed's changes cancel, so that the
    /// square of their sum hardly ever is four times the sum of their squares.
    fn noise_q32(&self, index: usize) -> u64 {
        let trend = u128::from(self.trend_q32.unsigned_abs()).pow(2) >> 36;
        if trend <= 4 * u128::from(self.squares_q28) {
            return 1 << 32;
        }
        let left = over(
            u128::from(self.left[index]) << 32,
            self.all[index].max(1).into(),
        );
        u64::try_from(left).unwrap_or(1 << 32).min(1 << 32)
    }
}

/// How much of the scatter of each of the lowest orders is noise, worked out in slices.
#[derive(Clone, Copy)]
pub(super) struct NoiseShares {
    /// Q32.
    q32: [u64; LOW_ORDERS],
    cursor: Cursor,
}

/// Orders of a slice.
const ORDERS: usize = 3;

impl NoiseShares {
    pub(super) const START: Self = Self {
        q32: [0; LOW_ORDERS],
        cursor: Cursor::START,
    };

    pub(super) fn slice(&mut self, locked: &Locked) -> Poll<()> {
        for index in self.cursor.next(ORDERS, LOW_ORDERS) {
            self.q32[index] = locked.noise_q32(index);
        }
        self.cursor.at_end(LOW_ORDERS)
    }

    /// What of the orders' scatter is noise.
    pub(super) fn of(&self, scatter: &[u64; LOW_ORDERS]) -> [u64; LOW_ORDERS] {
        core::array::from_fn(|index| {
            let noise = u128::from(scatter[index]) * u128::from(self.q32[index]);
            u64::try_from(noise >> 32).unwrap_or(u64::MAX)
        })
    }
}

//! One turn with one table: running sums, and at its end what they leave of the power.

use crate::units::TickDelta8;
use crate::wide::over;

/// Farthest that an edge may be off, 2^-32 turn: a sixteenth of a turn. A turn with more is not used.
const OFF_MOST: i32 = 1 << 28;

/// One turn with one table.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    /// How late the turn's first edge was, 2^-8 tick.
    pub late: i64,
    /// Way since then, in the direction of motion, 2^-32 turn.
    pub way: i64,
    /// r at the last edge.
    last: i32,
    /// Sum of r, the sum of those sums, and the sum of these: below 2^44, 2^60 and 2^76, as a turn has 2^16 edges at the most.
    first: i64,
    second: i64,
    third: i128,
    /// Sum of r^2.
    squares: u128,
    /// Sum of (r(k) - r(k - 1))^2.
    interval_squares: u128,
}

/// Mean powers over a turn, (2^-32 turn)^2 in Q8.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Powers {
    pub interval: u128,
    pub angle: u128,
}

impl From<TickDelta8> for Sums {
    /// A turn whose first edge was so late.
    fn from(late: TickDelta8) -> Self {
        Self {
            late: late.0.into(),
            ..Self::default()
        }
    }
}

impl Sums {
    /// Adds an edge; false where it is too far off.
    #[inline]
    pub fn add(&mut self, off: i64) -> bool {
        let off = match i32::try_from(off) {
            Ok(off) if off.abs() <= OFF_MOST => off,
            _ => return false,
        };
        // Both are below 2^30.
        let step = off - self.last;
        self.last = off;
        self.first += i64::from(off);
        self.second += self.first;
        self.third += i128::from(self.second);
        self.squares += u128::from(square(off));
        self.interval_squares += u128::from(square(step));
        true
    }

    /// Powers over a turn of `edges`: the sums of squares less what falls on a constant, a slope and a bend.
    pub fn powers(&self, edges: u32) -> Powers {
        let n = i128::from(edges);
        // The sums of w r and of w^2 r with w = n + 1 - k, which the running sums are.
        let [first, weighed] = [self.first, self.second].map(i128::from);
        let weighed_twice = 2 * self.third - weighed;
        // The same with x = n + 1 - 2 w, which runs from 1 - n to n - 1, and with 3 x^2 - (n^2 - 1), whose sum is zero.
        let slope = (n + 1) * first - 2 * weighed;
        let square = (n + 1) * (n + 1) * first - 4 * (n + 1) * weighed + 4 * weighed_twice;
        let bend = 3 * square - (n * n - 1) * first;
        let n = u128::from(edges);
        // The sums of the squares of 1, of x and of that.
        let slope_norm = over(n * (n * n - 1), 3);
        let bend_norm = over(4 * n * (n * n - 1) * (n * n - 4), 5);
        let angle = self
            .squares
            .saturating_sub(share(first, n))
            .saturating_sub(share(slope, slope_norm))
            .saturating_sub(share(bend, bend_norm));
        let last = i128::from(self.last);
        let interval_slope = (i128::from(edges) + 1) * last - 2 * first;
        let interval = self
            .interval_squares
            .saturating_sub(share(last, n))
            .saturating_sub(share(interval_slope, slope_norm));
        Powers {
            interval: over(interval << 8, n),
            angle: over(angle << 8, n),
        }
    }
}

/// In one multiplication.
fn square(value: i32) -> u64 {
    let value = i64::from(value);
    (value * value).cast_unsigned()
}

/// `sum`^2 / `norm`.
fn share(sum: i128, norm: u128) -> u128 {
    let size = sum.unsigned_abs();
    let down = 66_u32.saturating_sub(size.leading_zeros());
    let top = size >> down;
    over(top * top, norm) << (2 * down)
}

//! The speed's own course from turn to turn, beyond the constant acceleration that a turn is folded with.
//!
//! A turn is folded along a motion through three crossings of edge 0: its ends and the one before. Friction and drag make the
//! acceleration itself change. What the motion is then off repeats turn after turn and falls with the speed as torque's angle does, so
//! that it passes for torque at the lowest orders. Two crossings more, of the next turn and of the one before last, tell it:
//! polynomials in time through all five (Newton's form). It is the same for all edges, so that its mean over the turns is taken out of
//! the sums when they are solved. In such a mean noise cancels but at the ends of a row of turns, as neighbours share a crossing.

use core::task::Poll;

use super::close::saturated;
use super::cursor::Cursor;
use super::scale::{Fine, Ratio};
use super::speeds::Weighing;
use crate::edge::Direction;
use crate::recip::Recip;
use crate::units::Turn32;

/// Edges of a slice.
const EDGES: usize = 300;

/// Fraction bits of a [`Path`] in a turn.
const PATH_BITS: u32 = 40;

/// What the angle is off at x = 0..1 of a turn, nothing at its ends: with a = x (1 - x) the parts of a, a (1 - 2 x) and a^2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Path([i64; 3]);

impl Path {
    /// Passed the other way.
    fn reversed(self) -> Self {
        let [even, odd, square] = self.0;
        Self([-even, odd, -square])
    }

    fn add(&mut self, other: Self, weight_q16: u64) {
        for (sum, part) in self.0.iter_mut().zip(other.0) {
            let product = i128::from(part) * i128::from(weight_q16);
            *sum = sum.saturating_add(i64::try_from(product >> 16).unwrap_or(0));
        }
    }
}

/// A turn that the next one is awaited of.
#[derive(Clone, Copy)]
struct Last {
    duration: u64,
    direction: Direction,
    bin: usize,
    /// What it was folded with.
    bend_q32: i32,
    /// The duration before, and the two before that together, over this one less one and two, Q32; none where it was not folded along
    /// the one before.
    before_q32: Option<i64>,
    both_q32: i64,
    /// Third divided difference of the four crossings of which its end is the last, in [`PATH_BITS`], with its duration as the unit of
    /// time.
    third: Option<i64>,
}

/// What the turns' motion is off constant acceleration, in both sums over turns.
pub(super) struct Course {
    last: Option<Last>,
    weighed: Path,
    plain: Path,
    /// Sum of the turns' bends, whatever their sign.
    bends_q32: u64,
}

impl Course {
    pub(super) const NONE: Self = Self {
        last: None,
        weighed: Path([0; 3]),
        plain: Path([0; 3]),
        bends_q32: 0,
    };

    /// Takes note of a turn that is taken, folded with a bend along the turn `before` of so many ticks.
    pub(super) fn take(
        &mut self,
        turn: (u64, Direction, usize),
        before: Option<u64>,
        bend_q32: i32,
        weighing: &Weighing,
    ) {
        let (duration, direction, bin) = turn;
        self.bends_q32 += u64::from(bend_q32.unsigned_abs());
        let mut last = Last {
            duration,
            direction,
            bin,
            bend_q32,
            before_q32: before.map(|before| change_q32(before, duration, duration)),
            both_q32: 0,
            third: None,
        };
        if let Some(ended) = self.last.take()
            && let Some(before_q32) = ended.before_q32
        {
            let next_q32 = change_q32(duration, ended.duration, ended.duration);
            let third = ended.third_with(next_q32, before_q32);
            let fourth = ended.third.map_or(0, |before| {
                quotient(third - before, 4 * ONE + next_q32 + ended.both_q32)
            });
            let path = ended.path(before_q32, next_q32, third, fourth);
            self.add(&ended, path, weighing);
            // In the new turn's unit of time.
            let ratio = ONE + next_q32;
            last.third = Some(times(times(times(third, ratio), ratio), ratio));
            // The one before that, over the new turn.
            let earlier = change_q32(ended.duration, duration, duration);
            last.both_q32 = earlier + times(ONE + before_q32, ONE + earlier) - ONE;
        }
        self.last = Some(last);
    }

    /// No turn follows on the last one: it goes on as the crossings up to its end tell. A fourth difference from there would be noise.
    pub(super) fn end(&mut self, weighing: &Weighing) {
        if let Some(ended) = self.last.take()
            && let (Some(before_q32), Some(third)) = (ended.before_q32, ended.third)
        {
            self.add(&ended, ended.path(before_q32, 0, third, 0), weighing);
        }
    }

    fn add(&mut self, turn: &Last, path: Path, weighing: &Weighing) {
        let path = if turn.direction == Direction::Forward {
            path
        } else {
            path.reversed()
        };
        self.plain.add(path, 1 << 16);
        self.weighed.add(path, weighing.weight_q16(turn.bin));
    }

    /// Follows the weighed sum where that is shifted down.
    pub(super) fn shift(&mut self, down: u32) {
        for part in &mut self.weighed.0 {
            *part >>= down;
        }
    }

    /// Mean bend of so many turns, whatever their sign.
    pub(super) fn mean_bend_q32(&self, turns: u32) -> u32 {
        u32::try_from(self.bends_q32 / u64::from(turns.max(1))).unwrap_or(u32::MAX)
    }

    /// Of the weighed mean and of the plain one.
    pub(super) fn curves(&self, weight_q16: u64, turns: u32, fine: Fine) -> [Curve; 2] {
        let curve = |path: &Path, weight_q16| {
            let ratio = Ratio::new(16 + 32 + fine.bits - PATH_BITS, weight_q16);
            Curve(path.0.map(|part| ratio.times(part)))
        };
        [
            curve(&self.weighed, weight_q16),
            curve(&self.plain, u64::from(turns) << 16),
        ]
    }
}

impl Last {
    /// Third divided difference of the crossings from the one before to the end of the next turn, which is longer by `next_q32`.
    fn third_with(&self, next_q32: i64, before_q32: i64) -> i64 {
        let (one, two) = (ONE + next_q32, 2 * ONE + next_q32);
        let both = times(one, two);
        let beyond = -(next_q32 + times(self.bend_q32.into(), both));
        quotient(
            beyond << (PATH_BITS - 32),
            times(both, two + ONE + before_q32),
        )
    }

    /// What the turn is off with these differences, by place: third t (t - 1) (t + before) + fourth t (t - 1) (t + before) (t - 1 - next)
    /// at the time t, where the turn has come to t - bend t (1 - t).
    fn path(&self, before_q32: i64, next_q32: i64, third: i64, fourth: i64) -> Path {
        let before = ONE + before_q32;
        let skew = (before_q32 - next_q32) / 2;
        let even = -times(third, before + ONE / 2)
            + times(fourth, times(before, 2 * ONE + next_q32) - skew);
        let odd = third / 2 + times(fourth, skew);
        let bent = |part| times(part, self.bend_q32.into());
        Path([even + bent(odd), odd + bent(even), fourth - 6 * bent(odd)])
    }
}

/// One, Q32.
const ONE: i64 = 1 << 32;

/// A product with a factor in Q32.
fn times(value: i64, factor_q32: i64) -> i64 {
    #[allow(clippy::cast_possible_truncation)]
    let product = ((i128::from(value) * i128::from(factor_q32)) >> 32) as i64;
    product
}

/// A quotient by a divisor in Q32, of which 16 digits count.
fn quotient(value: i64, divisor_q32: i64) -> i64 {
    Recip::of_u64(divisor_q32.max(1).cast_unsigned() >> 16).times_signed(value << 16)
}

/// `duration` less `from`, over `unit`, Q32.
fn change_q32(duration: u64, from: u64, unit: u64) -> i64 {
    let recip = Recip::of_u64(unit);
    let product = u128::from(duration.abs_diff(from)) * u128::from(recip.mantissa);
    let size = i64::try_from(product >> (recip.shift - 32)).unwrap_or(i64::MAX);
    if duration < from { -size } else { size }
}

/// A [`Path`] of a mean over turns, in fine angles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Curve([i64; 3]);

impl Curve {
    pub(super) const NONE: Self = Self([0; 3]);

    /// What it is less another.
    pub(super) fn less(self, other: Self) -> Self {
        Self(core::array::from_fn(|part| self.0[part] - other.0[part]))
    }

    /// At a place in the turn.
    pub(super) fn at(self, place: Turn32) -> i64 {
        let x = i64::from(place.0);
        let arc_q32 = (x * (ONE - x).min(u32::MAX.into())) >> 32;
        let [even, odd, square] = self.0;
        let odd = (odd * ((ONE >> 1) - x)) >> 31;
        ((even + odd + ((square * arc_q32) >> 32)) * arc_q32) >> 32
    }
}

/// Takes a curve out of the errors of every edge.
pub(super) struct Straightening {
    curve: Curve,
    cursor: Cursor,
}

impl Straightening {
    pub(super) const fn new(curve: Curve) -> Self {
        Self {
            curve,
            cursor: Cursor::START,
        }
    }

    pub(super) fn slice(&mut self, errors: &mut [i32]) -> Poll<()> {
        let edges = errors.len();
        let step = step_of(edges);
        let stretch = self.cursor.next(EDGES, edges);
        let first = stretch.start;
        for (at, error) in (first..).zip(&mut errors[stretch]) {
            let more = self.curve.at(place(at, step));
            *error = saturated(i64::from(*error) - more);
        }
        self.cursor.at_end(edges)
    }
}

/// A part of a turn cut into so many.
pub(super) fn step_of(parts: usize) -> u32 {
    #[allow(clippy::cast_possible_truncation)]
    let parts = parts.max(1) as u32;
    u32::MAX / parts
}

/// Where a part begins.
pub(super) fn place(part: usize, step: u32) -> Turn32 {
    #[allow(clippy::cast_possible_truncation)]
    let part = part as u32;
    Turn32(part.wrapping_mul(step))
}

#[cfg(test)]
mod tests;

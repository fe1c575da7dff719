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
use super::speeds::{Place, Weighing};
use crate::edge::Direction;
use crate::recip::Recip;
use crate::units::Turn32;
use crate::wide::over_signed;

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
            *sum = sum.saturating_add(weighed(part, weight_q16));
        }
    }
}

/// A turn that the next one is awaited of.
#[derive(Clone, Copy)]
struct Last {
    duration: u64,
    direction: Direction,
    place: Place,
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
    slowing: Slowing,
}

/// How the turns' speed falls within them.
#[derive(Clone, Copy)]
struct Slowing {
    /// Sums over turns, weighed and plain, of the share of the speed that goes in a radian of the shaft, by the square of the duration over
    /// the first one's, Q32.
    weighed: i64,
    plain: i64,
    /// The same of the fourth power of the duration over the first one's, Q16.
    fourth_weighed: i64,
    fourth_plain: i64,
    /// Sums of the squared bends and of the third differences, in [`PATH_BITS`].
    bends: i64,
    thirds: i64,
}

impl Course {
    pub(super) const NONE: Self = Self {
        last: None,
        weighed: Path([0; 3]),
        plain: Path([0; 3]),
        slowing: Slowing {
            weighed: 0,
            plain: 0,
            fourth_weighed: 0,
            fourth_plain: 0,
            bends: 0,
            thirds: 0,
        },
    };

    /// Takes note of a turn that is taken, folded with a bend along the turn `before` of so many ticks.
    pub(super) fn take(
        &mut self,
        turn: (u64, Direction, Place),
        before: Option<u64>,
        bend_q32: i32,
        weighing: &Weighing,
    ) {
        let (duration, direction, place) = turn;
        let fall_q32 = fall_q32(place, bend_q32);
        let ahead_q32 = if direction == Direction::Forward {
            fall_q32
        } else {
            -fall_q32
        };
        self.slowing
            .add(ahead_q32, place, weighing.weight_q16(place.bin));
        let mut last = Last {
            duration,
            direction,
            place,
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
            let square_q32 = times(ended.bend_q32.into(), ended.bend_q32.into());
            let slowing = &mut self.slowing;
            slowing.bends = slowing.bends.saturating_add(square_q32 << (PATH_BITS - 32));
            slowing.thirds = slowing.thirds.saturating_add(third);
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
        let weight_q16 = weighing.weight_q16(turn.place.bin);
        self.plain.add(path, 1 << 16);
        self.weighed.add(path, weight_q16);
    }

    /// Follows the weighed sum where that is shifted down.
    pub(super) fn shift(&mut self, down: u32) {
        for part in &mut self.weighed.0 {
            *part >>= down;
        }
        self.slowing.weighed >>= down;
        self.slowing.fourth_weighed >>= down;
    }

    /// How the speed falls within the turns of the weighed mean and of the plain one.
    pub(super) fn falls(&self, weight_q16: u64, turns: u32) -> Falls {
        let Slowing {
            weighed,
            plain,
            fourth_weighed,
            fourth_plain,
            bends,
            thirds,
        } = self.slowing;
        let third_q16 = over_signed(i128::from(thirds) * (3 << 15), bends.max(1).into());
        let power_q16 = third_q16.clamp(0, 2 << 16);
        Falls {
            weighed_q30: Ratio::new(14, weight_q16).times(weighed),
            plain_q30: plain / (4 * i64::from(turns.max(1))),
            fourth_weighed_q16: Ratio::new(16, weight_q16).times(fourth_weighed),
            fourth_plain_q16: fourth_plain / i64::from(turns.max(1)),
            #[allow(clippy::cast_possible_truncation)]
            friction_q16: power_q16 as i64,
        }
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

/// A part times a weight.
fn weighed(part: i64, weight_q16: u64) -> i64 {
    let product = i128::from(part) * i128::from(weight_q16);
    i64::try_from(product >> 16).unwrap_or(0)
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

impl Slowing {
    fn add(&mut self, fall_q32: i64, place: Place, weight_q16: u64) {
        let ratio_q16 = (place.ratio_q32 >> 16).cast_signed();
        let square_q16 = (ratio_q16 * ratio_q16) >> 16;
        let fourth_q16 = (square_q16 * square_q16) >> 16;
        self.fourth_plain = self.fourth_plain.saturating_add(fourth_q16);
        self.fourth_weighed = self
            .fourth_weighed
            .saturating_add(weighed(fourth_q16, weight_q16));
        self.plain = self.plain.saturating_add(fall_q32);
        self.weighed = self.weighed.saturating_add(weighed(fall_q32, weight_q16));
    }
}

/// Share of the speed that goes in a radian of the way, by the square of the duration over the first turn's, Q32.
pub(super) fn fall_q32(place: Place, bend_q32: i32) -> i64 {
    let ratio_q32 = place.ratio_q32.cast_signed();
    // A bend takes twice itself of the speed in a turn.
    let fall_q32 = times(-2 * i64::from(bend_q32), PER_RADIAN_Q32);
    times(fall_q32, times(ratio_q32, ratio_q32))
}

/// 1 / (2 pi), Q32.
const PER_RADIAN_Q32: i64 = 683_565_276;

/// How the speed falls within turns: a mean over them.
#[derive(Clone, Copy)]
pub(super) struct Falls {
    /// Share of the speed that goes in a radian, by the square of the duration over the first turn's, in the weighed and the plain mean, Q30.
    pub weighed_q30: i64,
    pub plain_q30: i64,
    /// Mean fourth power of the duration over the first turn's in either, Q16.
    pub fourth_weighed_q16: i64,
    pub fourth_plain_q16: i64,
    /// Power of the speed that friction goes with, as far as the speed's course tells: 0 to 2, Q16.
    pub friction_q16: i64,
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

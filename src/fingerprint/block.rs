//! Sixteen edges in a row, seen through nine contrasts that neither smooth motion nor class offsets touch.
//!
//! Over 16 edges a shaft's motion is a cubic in the edge's number to within what torque can do, and a class offset (width and
//! quadrature error, delays of the channels, whatever drifts with temperature and speed) repeats every four edges. Both
//! together span seven dimensions. The nine contrasts are an orthonormal basis of the rest: white noise of the edge
//! positions stays white in them, with the same variance. Five are even about the middle of the block, four odd, so each
//! takes eight products.

use core::iter::Sum;
use core::ops::{Add, Mul, Shr, Sub};

use super::trail::Run;
use crate::recip::Recip;
use crate::table::Entry;

/// Edges of a block.
pub(super) const BLOCK_EDGES: u32 = 16;

/// Contrasts of a block: its degrees of freedom.
pub(super) const CONTRASTS: usize = EVEN.len() + ODD.len();

/// Fraction bits of the weights.
const WEIGHT_BITS: i16 = 12;

/// Weights of edge i and, alike, of edge 15 - i: orthogonal to 1, t^2 and (+ - - +).
const EVEN: [[i16; 8]; 5] = [
    [1699, -1297, -589, -1116, -645, 825, 1061, 62],
    [0, -1784, 1967, 739, 106, 67, -249, -844],
    [0, 0, 1335, -1537, -220, -997, -338, 1757],
    [0, 0, 0, -1457, 2259, 510, -510, -802],
    [0, 0, 0, 0, -648, 1943, -1943, 648],
];

/// Weights of edge i and, negative, of edge 15 - i: orthogonal to t, t^3, (+ - + -) and (+ + - -).
const ODD: [[i16; 8]; 4] = [
    [-1362, 1818, 995, -751, -118, -1040, -217, -728],
    [0, 981, -1506, -341, 256, -369, 2117, 597],
    [0, 0, -1017, 1794, 718, -1495, -478, -1076],
    [0, 0, 0, -497, 1490, -993, -993, 1987],
];

/// Products of weights and numbers folded about the block's middle, one row a contrast.
#[inline]
fn products<T, const ROWS: usize>(rows: &[[i16; 8]; ROWS], folded: [T; 8]) -> [T; ROWS]
where
    T: Copy + Mul<Output = T> + Shr<Output = T> + Sum + From<i16>,
{
    rows.map(|weights| {
        let products = weights.iter().zip(folded).map(|(&w, x)| x * T::from(w));
        products.sum::<T>() >> T::from(WEIGHT_BITS)
    })
}

/// The even contrasts of sixteen numbers.
#[inline]
fn even<T>(values: &[T; 16]) -> [T; EVEN.len()]
where
    T: Copy + Add<Output = T> + Mul<Output = T> + Shr<Output = T> + Sum + From<i16>,
{
    products(&EVEN, core::array::from_fn(|i| values[i] + values[15 - i]))
}

/// The odd contrasts of sixteen numbers.
#[inline]
fn odd<T>(values: &[T; 16]) -> [T; ODD.len()]
where
    T: Copy + Sub<Output = T> + Mul<Output = T> + Shr<Output = T> + Sum + From<i16>,
{
    products(&ODD, core::array::from_fn(|i| values[i] - values[15 - i]))
}

/// Largest contrast kept, far above any table's: squares of a whole window fit 64 bits.
const CONTRAST_MAX: i64 = 1 << 26;

/// Intervals from here on, ticks, are no motion to measure with.
const INTERVAL_MAX: u32 = 1 << 26;

/// What a block of a run measures.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    /// Contrasts of the edges' errors, in the unit of the table's entries.
    even: [i32; EVEN.len()],
    odd: [i32; ODD.len()],
}

impl Block {
    pub const EMPTY: Self = Self {
        even: [0; EVEN.len()],
        odd: [0; ODD.len()],
    };

    /// Measures edges `16 block..16 block + 16` of a run, one grid step being `span` / 15 units of the table's entries; and the
    /// squared timer tick in such units times 2^16. None where the speed changes by more than a quarter within the block or
    /// the shaft nearly stands.
    pub fn measure<const W: usize>(run: &Run<'_, W>, block: u32, span: u64) -> Option<(Self, u64)> {
        let mut times = [0_u64; BLOCK_EDGES as usize];
        for i in 1..times.len() {
            #[allow(clippy::cast_possible_truncation)]
            let interval = run.interval(BLOCK_EDGES * block + i as u32);
            if interval == 0 || interval >= INTERVAL_MAX {
                return None;
            }
            times[i] = times[i - 1] + u64::from(interval);
        }
        let duration = times[15];
        // Seven intervals at either end, both from class 0 to class 3: how the speed changes, free of class offsets.
        let slowing = (duration - times[8]).cast_signed() - times[7].cast_signed();
        if slowing.unsigned_abs() > duration / 16 {
            return None;
        }
        let recip = Recip::of_u64(duration);
        // Relative growth of the interval from edge to edge, Q32: the two ends are 8 edges apart.
        let growth = recip.times_signed(slowing << 32) * 15 / 56;
        let mut errors = [0_i64; BLOCK_EDGES as usize];
        for (i, (error, &time)) in (0..).zip(errors.iter_mut().zip(&times)) {
            let even = (i * span / 15).cast_signed();
            let lag = even - recip.times(time * span).cast_signed();
            // An error of position takes the longer in time the slower the shaft is at that edge.
            let half_edges = 2 * i.cast_signed() - 15;
            *error = lag - ((lag * ((growth * half_edges) >> 17)) >> 16);
        }
        let tick_q8 = recip.times(span << 8).min(1 << 30);
        let block = Self {
            even: even(&errors).map(held),
            odd: odd(&errors).map(held),
        };
        Some((block, tick_q8 * tick_q8))
    }

    /// Sum of the squares.
    pub fn energy(&self) -> u64 {
        distance(&self.even, &[0; EVEN.len()]) + distance(&self.odd, &[0; ODD.len()])
    }

    /// Sum of the squared differences from `entries` from edge `first` on, across the turn's end where need be; or some sum above
    /// `limit`. And how many halves of the block were looked at.
    #[inline]
    pub fn residual<E: Entry>(&self, entries: &[E], first: usize, limit: u64) -> (u64, u32) {
        let values = match entries.get(first..).and_then(<[E]>::first_chunk::<16>) {
            Some(chunk) => chunk.map(|entry| i32::from(entry.value())),
            None => across_the_end(entries, first),
        };
        let left = distance(&self.even, &even(&values));
        if left > limit {
            return (left, 1);
        }
        (left + distance(&self.odd, &odd(&values)), 2)
    }
}

/// A contrast within [`CONTRAST_MAX`].
#[allow(clippy::cast_possible_truncation)]
fn held(contrast: i64) -> i32 {
    contrast.clamp(-CONTRAST_MAX, CONTRAST_MAX) as i32
}

/// Sum of the squared differences.
#[inline]
fn distance<const COUNT: usize>(a: &[i32; COUNT], b: &[i32; COUNT]) -> u64 {
    let mut sum = 0;
    for (a, b) in a.iter().zip(b) {
        let difference = i64::from(a - b);
        sum += difference * difference;
    }
    sum.cast_unsigned()
}

#[cold]
#[inline(never)]
fn across_the_end<E: Entry>(entries: &[E], first: usize) -> [i32; 16] {
    let mut edges = entries.iter().cycle().skip(first % entries.len().max(1));
    core::array::from_fn(|_| edges.next().map_or(0, |entry| i32::from(entry.value())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn all(values: [i64; 16]) -> [i64; CONTRASTS] {
        let mut both = even(&values).into_iter().chain(odd(&values));
        core::array::from_fn(|_| both.next().unwrap())
    }

    #[test]
    fn contrasts_are_orthonormal_to_three_parts_in_ten_thousand() {
        let units: [[i64; CONTRASTS]; 16] =
            core::array::from_fn(|edge| all(core::array::from_fn(|i| i64::from(i == edge) << 24)));
        for a in 0..CONTRASTS {
            for b in 0..CONTRASTS {
                let dot: f64 = units.iter().map(|u| u[a] as f64 * u[b] as f64).sum();
                let dot = dot / (2.0_f64.powi(48));
                assert!(
                    (dot - f64::from(u8::from(a == b))).abs() < 4e-4,
                    "{a} {b}: {dot}"
                );
            }
        }
    }

    proptest! {
        #[test]
        fn smooth_motion_and_class_offsets_leave_nothing(
            cubic in prop::array::uniform4(-1e4_f64..1e4), classes in prop::array::uniform4(-1e4_f64..1e4)
        ) {
            let values = core::array::from_fn(|i| {
                let t = i as f64 / 7.5 - 1.0;
                (cubic[0] + t * (cubic[1] + t * (cubic[2] + t * cubic[3])) + classes[i % 4]) as i64
            });
            for contrast in all(values) {
                prop_assert!(contrast.abs() < 30, "{contrast}");
            }
        }

        #[test]
        fn a_block_across_the_turns_end_is_a_block_like_any(entries in prop::collection::vec(any::<i16>(), 20..60), first in 0_usize..60) {
            let twice: std::vec::Vec<i16> = entries.iter().chain(&entries).copied().collect();
            let first = first % entries.len();
            let block = Block::EMPTY;
            prop_assert_eq!(block.residual(&entries, first, u64::MAX), block.residual(&twice, first, u64::MAX));
        }
    }
}

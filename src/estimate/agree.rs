//! Whether a turn agrees with those before it: its lowest orders against those of the turn taken last.
//!
//! Geometry is the same in both, and torque locked to the shaft goes with the square of the durations. What differs beyond that
//! is noise, whose usual size the pairs of turns so far show, or a disturbance: a load step, a shock.

use super::low::{LOW_ORDERS, LowOrder};
use super::speeds::Speeds;
use crate::edge::Direction;
use crate::recip::Recip;

/// What is compared of a turn.
#[derive(Clone, Copy)]
pub(super) struct Seen {
    pub duration: u64,
    /// Over the first turn's, Q32.
    pub ratio_q32: u64,
    pub direction: Direction,
    /// Its speed bin.
    pub bin: usize,
    pub low: [LowOrder; LOW_ORDERS],
}

/// How far a turn is off another.
#[derive(Clone, Copy)]
pub(super) struct Off {
    /// Sum of the squared differences.
    pub level: u64,
    /// Whether that is far more than usual.
    pub far: bool,
}

impl Off {
    const NONE: Self = Self {
        level: 0,
        far: false,
    };
}

/// How turns have agreed so far.
pub(super) struct Agreement {
    /// The turn taken last.
    taken: Option<Seen>,
    /// The turn after that, where it disagreed.
    rejected: Option<Seen>,
    /// How many disagreed one after the other.
    in_a_row: u8,
}

/// Turns one after the other that may disagree. One more is how the shaft runs now if it is like the one before, which a load that
/// comes and goes does not bring about.
const IN_A_ROW: u8 = 3;

/// The same where they do not agree with each other either.
const AT_ODDS: u8 = 8;

/// Pairs of turns that say what is usual, at the least.
const PAIRS: u16 = 3;

/// How many times the usual is far off, for a sum of squared differences.
struct Limit {
    /// With many pairs.
    of_many: u128,
    /// What few of them add to that, over their number.
    of_few: u128,
}

/// Of all orders, each weighed to count alike: 14 with three pairs, 8 with twelve.
const WEIGHED: Limit = Limit {
    of_many: 6,
    of_few: 24,
};

/// As they are, which is order 1 for the most part: 30 with three pairs, 15 with twelve. Torque noise came to neither limit in a
/// thousand turns of a simulation.
const PLAIN: Limit = Limit {
    of_many: 10,
    of_few: 60,
};

impl Limit {
    /// Whether a turn is beyond the limit, where so many pairs have come to a sum of `usual`.
    fn is_passed(&self, turn: u128, usual: u128, pairs: u16, wary: u128) -> bool {
        let pairs = u128::from(pairs);
        turn * pairs * pairs * wary > usual * (self.of_many * pairs + self.of_few)
    }
}

/// The limits are smaller by this after a turn that disagreed: what disturbed one may be in the next.
const WARY: u128 = 3;

impl Agreement {
    /// Nothing to agree with yet.
    pub(super) const NONE: Self = Self {
        taken: None,
        rejected: None,
        in_a_row: 0,
    };

    /// What comes next does not follow on what came before.
    pub(super) fn interrupt(&mut self) {
        self.rejected = None;
        self.in_a_row = 0;
    }

    /// How far a turn is off the turn taken last.
    pub(super) fn off(&self, turn: &Seen, speeds: &Speeds) -> Off {
        let wary = if self.in_a_row > 0 { WARY } else { 1 };
        self.taken
            .map_or(Off::NONE, |taken| turn.off(&taken, speeds, wary))
    }

    /// Takes note of a turn that does not agree; false where it has to be taken all the same.
    pub(super) fn reject(&mut self, turn: Seen, speeds: &Speeds) -> bool {
        let like_before = self
            .rejected
            .is_some_and(|before| !turn.off(&before, speeds, 1).far);
        let rejected = self.in_a_row < if like_before { IN_A_ROW } else { AT_ODDS };
        if rejected {
            self.in_a_row += 1;
            self.rejected = Some(turn);
        }
        rejected
    }

    /// Takes note of a turn that is taken. Together with the one taken before, if that was of like speed, it adds to the scatter;
    /// where it had to be taken without agreeing, together with the one rejected before.
    pub(super) fn take(&mut self, turn: Seen, agrees: bool, speeds: &mut Speeds) {
        let other = if agrees {
            self.taken.filter(|taken| turn.is_like(taken))
        } else {
            self.rejected
        };
        if let Some(other) = other
            && let Some(bin) = speeds.bins.get_mut(turn.bin)
        {
            bin.pairs = bin.pairs.saturating_add(1);
            for (sum, square) in bin.scatter.iter_mut().zip(turn.squares(&other)) {
                *sum = sum.saturating_add(square);
            }
            let growth_q32 = turn.growth_q32(&other);
            let changes = core::array::from_fn(|index| {
                let change = turn.low[index].less(other.low[index]);
                change.ahead(turn.direction)
            });
            speeds.locked.take(growth_q32, &changes);
        }
        self.taken = Some(turn);
        self.interrupt();
    }
}

impl Seen {
    /// By how much the square of its duration, over the first turn's, is above that of another, Q32.
    fn growth_q32(&self, other: &Self) -> i64 {
        let square = |ratio: u64| (u128::from(ratio).pow(2) >> 32) as i64;
        square(self.ratio_q32) - square(other.ratio_q32)
    }

    /// Whether noise is alike in both: the same direction, and durations within a sixteenth.
    fn is_like(&self, other: &Self) -> bool {
        self.within(other, self.duration >> 4)
    }

    fn within(&self, other: &Self, change: u64) -> bool {
        self.direction == other.direction && self.duration.abs_diff(other.duration) <= change
    }

    /// Squared differences of the lowest orders.
    fn squares(&self, other: &Self) -> [u64; LOW_ORDERS] {
        core::array::from_fn(|index| self.low[index].distance(other.low[index]))
    }

    /// How far this turn is off another, where what is too far is smaller by `wary`. It can't be told where the durations differ by
    /// more than a third, nor what is too far where too few pairs say what is usual.
    fn off(&self, other: &Self, speeds: &Speeds, wary: u128) -> Off {
        if !self.within(other, self.duration / 3) {
            return Off::NONE;
        }
        let mut squares = self.squares(other);
        if !self.is_like(other) {
            self.take_locked(other, &mut squares);
        }
        let level = weighed(&squares);
        let far = usual(self.bin, other.bin, speeds).is_some_and(|(usual, pairs)| {
            WEIGHED.is_passed(level, weighed(&usual), pairs, wary)
                || PLAIN.is_passed(plain(&squares), plain(&usual), pairs, wary)
        });
        Off {
            level: u64::try_from(level).unwrap_or(u64::MAX),
            far,
        }
    }

    /// Takes from squared differences what a change of speed may make of locked torque: with q the ratio of the durations' squares,
    /// q - 1 of what the order has in the turn with less of it, and, as geometry may hide half of the torque there, twice that.
    fn take_locked(&self, other: &Self, squares: &mut [u64; LOW_ORDERS]) {
        let shorter = self.duration.min(other.duration);
        let change = self.duration.abs_diff(other.duration);
        let change_q16 = Recip::of_u64(shorter).times(change << 16);
        let growth_q16 = 2 * change_q16 + ((change_q16 * change_q16) >> 16);
        let share_q32 = u128::from(4 * growth_q16 * growth_q16);
        let power = |low: &LowOrder| u128::from(low.distance(LowOrder::default()));
        for (square, (one, other)) in squares.iter_mut().zip(self.low.iter().zip(&other.low)) {
            let locked = (power(one).min(power(other)) * share_q32) >> 32;
            *square = square.saturating_sub(u64::try_from(locked).unwrap_or(u64::MAX));
        }
    }
}

/// How much the pairs of turns at a speed differ in all, and their number: of the bin itself, or, with too few there, of the other
/// one.
fn usual(bin: usize, other: usize, speeds: &Speeds) -> Option<([u64; LOW_ORDERS], u16)> {
    let pairs_of = |bin: usize| speeds.bins.get(bin).filter(|bin| bin.pairs >= PAIRS);
    if let Some(own) = pairs_of(bin) {
        return Some((own.scatter, own.pairs));
    }
    // Noise grows with the cube of the duration, by less than four from one bin to the next.
    let slower = u32::try_from(bin.saturating_sub(other)).unwrap_or(0);
    let known = pairs_of(other)?;
    let scatter = known.scatter;
    let scatter = scatter.map(|square| square.saturating_mul(1 << (2 * slower.min(8))));
    Some((scatter, known.pairs))
}

/// Squares of all orders together, each of which torque noise makes alike: it falls with the fourth power of the order.
fn weighed(squares: &[u64; LOW_ORDERS]) -> u128 {
    let weighed = squares.iter().zip(1_u128..);
    weighed
        .map(|(&square, n)| u128::from(square) * n.pow(4))
        .sum()
}

/// Squares of all orders together.
fn plain(squares: &[u64; LOW_ORDERS]) -> u128 {
    squares.iter().map(|&square| u128::from(square)).sum()
}

#[cfg(test)]
mod tests;

//! Two tables held against each other on turns that neither was learned from, in whole numbers.
//!
//! Both tables see the same edges of the same turns, so what the shaft does is the same in both and their difference is the
//! tables' alone. Within a turn, r(k) is the way that the time of edge k says, less the way that the table says:
//!
//! r(k) = (t(k) - t(0)) / T - (angle(k) - angle(0)), with T the turn before
//!
//! - *Interval*: the power of r(k) - r(k - 1) about its best straight line.
//! - *Angle*: the power of r(k) about its best parabola, which takes a steady change of speed out, and where the turn began.
//!
//! Each turn gives for each of the two one number, (old - new) / (old + new), between -1 and 1 however fast it was. A mean more than
//! twice its standard error away from zero is certain. A table is better if one mean is above zero for certain, and above
//! [`GAIN_LEAST`], and neither is below for certain: a disc that was mounted anew shows in the angle, worn marks show in the intervals.
//!
//! What the shaft does at the same angle of every turn, as cogging makes it, looks like the encoder's to both tables. It is the
//! estimator that leaves such orders alone.
//!
//! The work an edge is constant and divides nothing: a reciprocal once a turn, then three multiplications and six sums for each table.
//! What a whole turn says is worked out in the main loop.

mod sums;

use crate::edge::Direction;
use crate::recalibrate::{Figures, Scatter};
use crate::recip::Recip;
use crate::shape::EncoderShape;
use crate::step::{Flags, Step};
use crate::units::{TICK_FRACTION_BITS, TickDelta8, Ticks, TurnDelta32};
use crate::wide::{over, over_signed};
use sums::{Powers, Sums};

/// Least gain in power, as a share of both (Q30): one part in 64.
pub const GAIN_LEAST: i64 = 1 << 24;

/// Flags that spoil a turn.
const SPOILED: Flags = Flags::FIRST
    .with(Flags::REVERSED)
    .with(Flags::TURN_SUSPECT)
    .with(Flags::ILLEGAL)
    .with(Flags::ABRUPT)
    .with(Flags::SPIKE);

/// An edge as a table has it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Corrected {
    /// Way from the edge before, negative in reverse.
    pub moved: TurnDelta32,
    /// How late it was captured.
    pub late: TickDelta8,
}

/// A mean of shares that says how sure it is.
#[derive(Clone, Copy, Debug, Default)]
struct Shares {
    count: i64,
    sum_q30: i64,
    squares_q30: i64,
}

/// The turn that is coming in.
#[derive(Clone, Copy, Debug)]
struct Turn {
    start: Ticks,
    direction: Direction,
    edges: u32,
    /// Digits that times lose to fit 32 bits.
    down: u32,
    /// Of the turn before; none where it is not known.
    per_turn: Option<Recip>,
    old: Sums,
    new: Sums,
}

/// Holds two tables against each other; see the module's head.
#[derive(Clone, Debug)]
pub struct Proof {
    edges: u32,
    turn: Option<Turn>,
    /// A whole turn that was not yet settled: old and new.
    whole: Option<[Sums; 2]>,
    turns: u32,
    rejected: u32,
    old: Powers,
    new: Powers,
    interval: Shares,
    angle: Shares,
}

impl Proof {
    /// Nothing seen of an encoder.
    #[must_use]
    pub fn new(shape: EncoderShape) -> Self {
        Self {
            edges: shape.edges(),
            turn: None,
            whole: None,
            turns: 0,
            rejected: 0,
            old: Powers::default(),
            new: Powers::default(),
            interval: Shares::default(),
            angle: Shares::default(),
        }
    }

    /// Works out a turn that has come to its end; to be called from the main loop, as it divides. A turn that ends before the one before
    /// was worked out is passed over.
    pub fn settle(&mut self) {
        let Some([old, new]) = self.whole.take() else {
            return;
        };
        let (old, new) = (old.powers(self.edges), new.powers(self.edges));
        let add = |sum: &mut Powers, turn: Powers| {
            sum.interval += turn.interval;
            sum.angle += turn.angle;
        };
        add(&mut self.old, old);
        add(&mut self.new, new);
        self.interval.add(old.interval, new.interval);
        self.angle.add(old.angle, new.angle);
        self.turns = self.turns.saturating_add(1);
    }

    /// What the turns settled so far say.
    #[must_use]
    pub fn figures(&self) -> Figures {
        let turns = u128::from(self.turns.max(1));
        let root = |sum: u128| {
            let mean_q8 = u64::try_from(over(sum, turns)).unwrap_or(u64::MAX);
            // The root of Q8 has Q4.
            u32::try_from((mean_q8.isqrt() + 8) >> 4).unwrap_or(u32::MAX)
        };
        let scatter = |powers: &Powers| Scatter {
            interval: root(powers.interval),
            angle: root(powers.angle),
        };
        let both = [&self.interval, &self.angle];
        Figures {
            turns: self.turns,
            rejected: self.rejected,
            old: scatter(&self.old),
            new: scatter(&self.new),
            better: both.iter().any(|shares| shares.gain())
                && !both.iter().any(|shares| shares.lose()),
        }
    }

    /// Takes an accepted edge with what both tables make of it. On the edge path while proving.
    pub fn push(&mut self, step: &Step, old: Corrected, new: Corrected) {
        if step.flags.intersects(SPOILED) || step.resync != 0 || step.advance != 1 {
            return self.spoil();
        }
        let Some(turn) = &mut self.turn else {
            return self.open(step, None, old, new);
        };
        turn.edges += 1;
        let whole = turn.edges == self.edges;
        let fits = turn.direction == step.direction && (step.edge == 0) == whole;
        if !fits || !turn.take(step.ticks, old, new) {
            return self.spoil();
        }
        if whole {
            let turn = *turn;
            if turn.per_turn.is_some() && self.whole.is_none() {
                self.whole = Some([turn.old, turn.new]);
            }
            let duration = step.ticks.saturating_sub(turn.start);
            self.open(step, Some(duration), old, new);
        }
    }

    /// Gives up the turn that is coming in: an edge was taken back, or the count was moved.
    pub fn spoil(&mut self) {
        if self.turn.take().is_some_and(|turn| turn.per_turn.is_some()) {
            self.rejected = self.rejected.saturating_add(1);
        }
    }

    /// Begins a turn at edge 0.
    fn open(&mut self, step: &Step, before: Option<u64>, old: Corrected, new: Corrected) {
        if step.edge != 0 || !step.flags.contains(Flags::REFERENCED) {
            self.turn = None;
            return;
        }
        let sums = |edge: Corrected| Sums::from(edge.late);
        let before_q8 = before.map(|ticks| ticks.min(1 << 48) << TICK_FRACTION_BITS);
        // One digit less than 32, so that a turn may take up to twice as long.
        let down = before_q8.map_or(0, |time| 33_u32.saturating_sub(time.leading_zeros()));
        #[allow(clippy::cast_possible_truncation)]
        let per_turn = before_q8.map(|time| Recip::of_u32((time >> down) as u32));
        self.turn = Some(Turn {
            start: step.ticks,
            direction: step.direction,
            edges: 0,
            down,
            per_turn,
            old: sums(old),
            new: sums(new),
        });
    }
}

impl Turn {
    /// Adds an edge; false where it is too far off.
    fn take(&mut self, ticks: Ticks, old: Corrected, new: Corrected) -> bool {
        let Some(per_turn) = self.per_turn else {
            return true;
        };
        let since_q8 = ticks.saturating_sub(self.start).min(1 << 48) << TICK_FRACTION_BITS;
        let sign = self.direction.sign();
        let mut taken = true;
        for (sums, edge) in [(&mut self.old, old), (&mut self.new, new)] {
            let late = i64::from(edge.late.0) - sums.late;
            let since = since_q8.saturating_add_signed(-late) >> self.down;
            // More than two turns before would not fit.
            #[allow(clippy::cast_possible_truncation)]
            let since = since.min(u32::MAX.into()) as u32;
            let product = u64::from(since) * u64::from(per_turn.mantissa);
            let way = product >> per_turn.shift.wrapping_sub(32).min(63);
            sums.way += i64::from(edge.moved.0) * i64::from(sign);
            taken &= sums.add(way.cast_signed() - sums.way);
        }
        taken
    }
}

impl Shares {
    fn add(&mut self, old: u128, new: u128) {
        let both = old + new;
        let excess = 90_u32.saturating_sub(both.leading_zeros());
        let [old, new, both] = [old, new, both].map(|power| (power >> excess).cast_signed());
        #[allow(clippy::cast_possible_truncation)]
        let share = over_signed((old - new) << 30, both.max(1)) as i64;
        self.count += 1;
        self.sum_q30 += share;
        self.squares_q30 += (share * share) >> 30;
    }

    /// Whether there is less with the new table, for certain.
    fn gain(&self) -> bool {
        self.sum_q30 > self.count * GAIN_LEAST && self.is_certain()
    }

    /// Whether there is more with the new table, for certain.
    fn lose(&self) -> bool {
        self.sum_q30 < 0 && self.is_certain()
    }

    /// Whether the mean is more than two standard errors away from zero.
    fn is_certain(&self) -> bool {
        // mean^2 > 4 (n squares - sum^2) / (n^2 (n - 1))
        let sum_squared = i128::from(self.sum_q30) * i128::from(self.sum_q30);
        let scatter = i128::from(self.count) * (i128::from(self.squares_q30) << 30) - sum_squared;
        sum_squared * i128::from(self.count - 1) > 4 * scatter.max(0)
    }
}

#[cfg(test)]
mod tests;

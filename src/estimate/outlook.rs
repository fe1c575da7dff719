//! How good the table would be if learning ended now, and whether more turns would make it better.

use super::low::{LOW_BITS, LOW_ORDERS};
use super::moments::{Mean, Moments, Shares, torque_power_q24};
use super::noise::{jitter_power, low_noise, low_power, stamp_power};
use super::scale::Fine;
use super::spectrum::{COEFFICIENT_BITS, POWER_BITS};
use super::speeds::{Bin, Speeds};
use super::{EdgeBuffers, Estimator};
use crate::shape::CLASSES_MAX;

/// What a table would come to. The size of geometry is judged by the steps from edge to edge, as if all orders had the same. Torque
/// that is left in at one speed is not counted, nor what telling it from geometry costs at its few orders: those take [`Estimator::solve`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Outlook {
    /// Error RMS of an edge to expect after correction if learning ended now, 2^-32 turn.
    pub error: u32,
    /// The same after as many turns again at the same speeds.
    pub after_twice: u32,
    /// What the time stamp of one edge is uncertain by at the speed of the first turn, 2^-32 turn: no table helps against it.
    pub stamp: u32,
}

/// When to stop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Goal {
    /// Error RMS that is good enough, 2^-32 turn; 0: as good as it gets.
    pub error: u32,
}

/// Whether to go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Advice {
    /// More turns help.
    GoOn,
    /// The goal is met.
    GoalMet,
    /// Twice as many turns would make angles, time stamps' own error included, less than a sixteenth better.
    NoFurtherGain,
}

/// Pairs of turns that say how good a mean is: with fewer it looks better by chance too often.
const PAIRS_MIN: u16 = 5;

/// Units of the powers here.
const FINE: Fine = Fine { bits: LOW_BITS };

impl Outlook {
    /// Whether to go on towards a goal.
    #[must_use]
    pub fn advice(&self, goal: Goal) -> Advice {
        let with_stamp = |error: u32| {
            let square = |x: u32| u128::from(x) * u128::from(x);
            square(error) + square(self.stamp)
        };
        if self.error <= goal.error {
            Advice::GoalMet
        } else if with_stamp(self.after_twice) * 256 > with_stamp(self.error) * 225 {
            Advice::NoFurtherGain
        } else {
            Advice::GoOn
        }
    }
}

impl<B: EdgeBuffers> Estimator<B> {
    /// What the turns taken so far let expect; none before six turns of like speed came in a row. Right after
    /// [`Progress::TurnTaken`](super::Progress), not on the edge path: some hundred thousand instructions.
    #[must_use]
    #[inline(never)]
    pub fn outlook(&mut self) -> Option<Outlook> {
        let plan = self.plan();
        let moments = Moments::of(&self.speeds, &self.weighing, self.totals.two_speeds());
        let shares = moments.shares(Mean::Weighed);
        let jitter = jitter_power(plan, &self.speeds, &shares, FINE);
        let geometry = self.geometry_power(&moments).saturating_sub(jitter);
        let speeds = &self.speeds;
        let (mut now, mut twice, mut slope) = (0_u128, 0_u128, 0);
        for order in 1..=plan.single {
            let torque = if order <= LOW_ORDERS {
                let power = order_power(speeds, &shares, order - 1)?;
                if order > LOW_ORDERS / 2 {
                    slope += power.saturating_mul((order as u64).pow(4)) / 3;
                }
                power
            } else {
                slope / (order as u64).pow(4)
            };
            let noise = torque.saturating_add(jitter);
            // Eccentricity and tilt are taken as they show, whatever their size; of the rest no more is left than there is.
            let size = if order <= 2 && !self.may_be_torque(order) {
                u64::MAX
            } else {
                geometry
            };
            now += 2 * u128::from(left(noise, size));
            twice += 2 * u128::from(left(noise / 2, size));
        }
        let above = plan.edges.saturating_sub(2 * plan.single) as u128;
        now += above * u128::from(left(jitter, geometry));
        twice += above * u128::from(left(jitter / 2, geometry));
        let (bin, standing) = self.drift.standing();
        let standing = shares.of_bin(speeds, bin, standing << (2 * COEFFICIENT_BITS + 1));
        let root = |power: u128| FINE.root_mean_square(u64::try_from(power).unwrap_or(u64::MAX));
        Some(Outlook {
            error: root(now + u128::from(standing)),
            after_twice: root(twice + u128::from(standing)),
            stamp: root(stamp_power(plan, speeds, FINE).into()),
        })
    }

    /// Whether torque may make an order, which one speed does not tell.
    fn may_be_torque(&self, order: usize) -> bool {
        let base = usize::from(self.knowledge.torque_base);
        !self.totals.two_speeds() && (base == 0 || order.is_multiple_of(base))
    }

    /// Power at every order of what repeats from edge to edge beside the classes' means, time stamps' jitter included: the sum's
    /// intervals hardly know the low orders of torque.
    fn geometry_power(&mut self, moments: &Moments) -> u64 {
        let shape = self.fold.shape;
        let mut of_class = [[0_i64; 2]; CLASSES_MAX];
        for line in self.buffers.parts().sum.chunks(shape.classes as usize) {
            for (deviation, [sum, squares]) in line.iter().zip(&mut of_class) {
                let deviation = i64::from(*deviation);
                *sum += deviation;
                *squares = squares.saturating_add(deviation * deviation);
            }
        }
        let lines = i128::from(shape.edges / shape.classes).max(1);
        let squares: i128 = of_class
            .iter()
            .map(|&[sum, squares]| i128::from(squares) - i128::from(sum) * i128::from(sum) / lines)
            .sum();
        // The turn taken last is folded into the sum while the next one comes.
        let mut weight_q16 = moments.weight_q16;
        if let Some(place) = self
            .folding
            .filter(|_| 2 * self.fold.remaining > shape.edges)
        {
            let before = weight_q16.saturating_sub(self.weighing.weight_q16(place.bin));
            weight_q16 = before << self.fold.sum_down();
        }
        let edges = i128::from(shape.edges);
        // A step between two errors has twice the power of either; all orders together have an error's.
        let per_order = (squares.max(0).unsigned_abs() << 20) / (2 * edges * edges).unsigned_abs();
        let weight_q8 = u128::from(weight_q16 >> 8).max(1);
        let up = 2 * (shape.unit_shift + FINE.bits) + POWER_BITS + 16 - 20;
        u64::try_from((per_order << up) / (weight_q8 * weight_q8)).unwrap_or(u64::MAX)
    }
}

/// What Wiener's weight leaves of a size in noise: S N / (S + N).
fn left(noise: u64, size: u64) -> u64 {
    let excess = 32_u32.saturating_sub((noise | size).leading_zeros());
    let (small, large) = (noise.min(size), noise.max(size));
    if small >> excess == 0 || large / small.max(1) > 1 << 16 {
        return small;
    }
    let (a, b) = (noise >> excess, size >> excess);
    (a * b / (a + b)) << excess
}

/// Power of one of the lowest orders in a mean. A speed at which no turns were compared is taken to have the same torque noise as
/// the others.
fn order_power(speeds: &Speeds, shares: &Shares, index: usize) -> Option<u64> {
    let compared = |bin: &&Bin| bin.pairs >= PAIRS_MIN;
    speeds.bins.iter().find(compared)?;
    let (mut seen, mut torque) = (0_u128, 0_u128);
    for (b, bin) in speeds.bins.iter().enumerate() {
        let pairs = u128::from(bin.pairs);
        seen += u128::from(low_power(bin, index, 0, FINE)) * pairs;
        torque += u128::from(torque_power_q24(b)) * pairs;
    }
    let level_q24 = (seen << 24) / torque.max(1);
    let noise = low_noise(speeds, shares, index, FINE, |b| {
        let expected = (level_q24 * u128::from(torque_power_q24(b))) >> 24;
        u64::try_from(expected).unwrap_or(u64::MAX)
    });
    Some(noise.power)
}

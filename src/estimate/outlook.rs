//! How good the table would be if learning ended now, and whether more turns would make it better.

use super::low::{LOW_BITS, LOW_ORDERS};
use super::moments::{Mean, Moments, Shares, torque_power_q24};
use super::noise::{jitter_power, low_power, stamp_power};
use super::scale::Fine;
use super::spectrum::COEFFICIENT_BITS;
use super::speeds::{Bin, Speeds};
use super::{EdgeBuffers, Estimator};

/// What a table would come to. The orders that one speed alone leaves undecided are not counted, nor what telling torque from
/// geometry costs at its few orders: those take [`Estimator::solve`].
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
    /// What the turns taken so far let expect; none before six turns of like speed came in a row. Some tens of thousands of
    /// instructions: after [`Progress::TurnTaken`](super::Progress), not on the edge path.
    #[must_use]
    #[inline(never)]
    pub fn outlook(&self) -> Option<Outlook> {
        let speeds = &self.speeds;
        let plan = self.plan();
        let moments = Moments::of(speeds, &self.weighing, self.two_speeds());
        let shares = moments.shares(Mean::Weighed);
        let mut falling = 0_u128;
        // Beyond the sixth order the sum of 1 / n^4 is 1 / 834, of which the last three orders each tell the size.
        let mut slope = 0_u128;
        for index in 0..LOW_ORDERS {
            let power = u128::from(order_power(speeds, &shares, index)?);
            falling += 2 * power;
            if index >= LOW_ORDERS / 2 {
                slope += 2 * power * (index as u128 + 1).pow(4) / 3;
            }
        }
        falling += slope / 834;
        falling += u128::from(jitter_power(plan, speeds, &shares, FINE)) * plan.edges as u128;
        let (bin, standing) = self.drift.standing();
        let standing = shares.of_bin(speeds, bin, standing << (2 * COEFFICIENT_BITS + 1));
        let root = |power: u128| FINE.root_mean_square(u64::try_from(power).unwrap_or(u64::MAX));
        Some(Outlook {
            error: root(falling + u128::from(standing)),
            after_twice: root(falling / 2 + u128::from(standing)),
            stamp: root(stamp_power(plan, speeds, FINE).into()),
        })
    }
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
    let power = shares.of_powers(speeds, |b| {
        let expected = (level_q24 * u128::from(torque_power_q24(b))) >> 24;
        let expected = u64::try_from(expected).unwrap_or(u64::MAX);
        low_power(&speeds.bins[b], index, expected, FINE)
    });
    u64::try_from(power >> 32).ok()
}

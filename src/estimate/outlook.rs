//! How good the table would be if learning ended now, and whether more turns would make it better.

/// What a table would come to. The size of geometry is judged by the steps from edge to edge, as if all orders had the same. Torque
/// that is left in at one speed is not counted, nor what telling it from geometry costs at its few orders: those take [`Estimator::solve`](super::Estimator::solve).
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

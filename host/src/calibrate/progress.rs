//! How good the table was after each turn, and why learning ended.

use quadcal::estimate::{Advice, Goal, Outlook};
use quadcal::units::RAD_PER_TURN32;

/// What the core said after one turn.
#[derive(Clone, Copy, Debug)]
pub struct AfterTurn {
    /// Turns taken until then, of all recordings.
    pub turns: u32,
    /// What they let expect.
    pub outlook: Outlook,
}

impl AfterTurn {
    /// Error RMS of an edge to expect after correction, rad.
    #[must_use]
    pub fn error_rad(&self) -> f64 {
        f64::from(self.outlook.error) * RAD_PER_TURN32
    }

    /// The same after as many turns again, rad.
    #[must_use]
    pub fn after_twice_rad(&self) -> f64 {
        f64::from(self.outlook.after_twice) * RAD_PER_TURN32
    }
}

/// What the core said after every turn from the sixth of like speed on.
#[derive(Clone, Debug, Default)]
pub struct LearningProgress {
    turns: Vec<AfterTurn>,
}

impl LearningProgress {
    /// Takes what the core says after a turn; whether that is reason to stop.
    pub(super) fn push(
        &mut self,
        turns: u32,
        outlook: Option<Outlook>,
        goal: Option<Goal>,
    ) -> bool {
        let Some(outlook) = outlook else {
            return false;
        };
        self.turns.push(AfterTurn { turns, outlook });
        goal.is_some_and(|goal| outlook.advice(goal) != Advice::GoOn)
    }

    /// Every turn's.
    #[must_use]
    pub fn turns(&self) -> &[AfterTurn] {
        &self.turns
    }

    /// The last turn's.
    #[must_use]
    pub fn last(&self) -> Option<&AfterTurn> {
        self.turns.last()
    }

    /// Whether to go on, after the last turn.
    #[must_use]
    pub fn advice(&self, goal: Goal) -> Option<Advice> {
        Some(self.last()?.outlook.advice(goal))
    }
}

/// A goal in rad; none that small is said in the core's unit, 1.5e-9 rad, rounded down.
#[must_use]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub fn goal_of(rad: f64) -> Goal {
    Goal {
        error: (rad / RAD_PER_TURN32) as u32,
    }
}

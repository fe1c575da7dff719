//! Mechanisms that make another motion altogether: they are recognised before anything small is looked for.

pub mod agreement;
pub mod broke_away;
pub mod closed_loop;
pub mod cycles;
pub mod decided;
pub mod foretold;
pub mod gains;
pub mod rests;
pub mod sampled;
pub mod scan;
pub mod scatter;
pub mod sharp;
pub mod slide;
pub mod slide_fit;
pub mod slip;
pub mod slip_fit;
pub mod slip_law;
pub mod solve;
pub mod spans;
pub mod stick_slip;
pub mod sticking;
#[cfg(test)]
mod tests;

use crate::diagnose::board::Board;
use crate::diagnose::run::Recorded;
use crate::mechanism::Mechanism;
use crate::twin::Twin;

/// A parameter of a finding: its name, value and standard error. The error is infinite where the recording says nothing of it.
pub type Parameter = (&'static str, f64, f64);

/// A motion that the twins do not have.
#[derive(Clone, Debug)]
pub struct MotionFinding {
    /// What makes it.
    pub mechanism: Mechanism,
    /// How strong it is.
    pub parameters: Vec<Parameter>,
    /// Evidence over the twins as they are.
    pub delta_bic: f64,
    /// The finding in a sentence or two.
    pub text: String,
    /// The rig's twins with the mechanism in.
    pub twins: Vec<Twin>,
}

impl MotionFinding {
    /// Whether some rig may have its numbers.
    #[must_use]
    pub fn plausible(&self) -> bool {
        let numbers = self.parameters.iter().map(|one| (one.0, one.1));
        self.mechanism.card().implausible(numbers).is_none()
    }
}

/// The motion that the twins of a rig lack, if there is one.
#[must_use]
pub fn other_motion(rig: &[Recorded], board: &Board) -> Option<MotionFinding> {
    let sticks = stick_slip::recognised(rig).map(|(motion, _)| motion);
    sticks.or_else(|| closed_loop::recognised(rig, board))
}

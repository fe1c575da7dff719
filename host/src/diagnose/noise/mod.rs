//! What is missing in the noise: stamps worse than declared, late captures, a torsional mode that torque noise excites, and noise
//! of no catalogue.
//!
//! A pattern moves edges by so much; noise only spreads them. So each mechanism here is a model of the covariance, or the third
//! moment, of what the patterns left.

mod bursts;
mod class_spread;
mod flat;
mod jitter;
mod latency;
mod levels;
mod mode_fit;
mod mode_likelihood;
mod mode_scan;
mod odds;
mod own;
mod resonance;
mod rings;
mod spectral;
mod spikes;
mod task;
#[cfg(test)]
mod tests;
mod two_mass;

use super::board::{Board, Model};
use crate::mechanism::Mechanism;

pub use mode_fit::Mode;
pub use own::{is_own, own_columns};
pub use resonance::LOAD;
pub use task::{
    Busy, DOUBT, Refit, Task, absent, account, agrees, confirm, find as find_task, refit,
};
#[cfg(test)]
pub use two_mass::TwoMass;

/// Something that the noise lacks.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseFinding {
    /// Its name; [`Mechanism::Unknown`] for noise of no catalogue.
    pub mechanism: Mechanism,
    /// Its parameters by the twin's names.
    pub parameters: Vec<NoiseParameter>,
    /// Schwarz's criterion without it less that with it.
    pub delta_bic: f64,
    /// Probability that declared noise shows as much anywhere in what was searched.
    pub p_value: f64,
    /// What it is, in a sentence.
    pub text: String,
    /// Where it shows, Hz; empty where it shows at all.
    pub frequencies_hz: Vec<f64>,
    /// When it shows, s; empty where it always does.
    pub times_s: Vec<f64>,
    /// Classes of the edges that show it; empty where all do.
    pub edge_classes: Vec<usize>,
    /// The next best mechanism, and by how much it is worse by Schwarz's criterion.
    pub runner_up: Option<(Mechanism, f64)>,
    /// Busy times of a task.
    pub busy: Option<Busy>,
}

/// A parameter of a mechanism of noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseParameter {
    /// The twin's name of it.
    pub name: &'static str,
    /// Value.
    pub value: f64,
    /// Standard error.
    pub standard_error: f64,
}

impl NoiseFinding {
    /// Whether some rig may have its numbers.
    #[must_use]
    pub fn plausible(&self) -> bool {
        let numbers = self.parameters.iter().map(|one| (one.name, one.value));
        self.mechanism.card().implausible(numbers).is_none()
    }
}

/// Everything that the noise lacks, going by what the patterns of a model leave.
#[must_use]
pub fn noise_findings(board: &Board, left: &Model) -> Vec<NoiseFinding> {
    findings(board, left, false)
}

/// The same if there is a task or a mode in it; else nothing, which is soon known.
#[must_use]
pub fn rhythmic_findings(board: &Board, left: &Model) -> Vec<NoiseFinding> {
    findings(board, left, true)
}

fn findings(board: &Board, left: &Model, rhythmic: bool) -> Vec<NoiseFinding> {
    // A task is a pattern, but moves edges as no other does.
    let task = task::find(board, &left.left);
    let mut rest = left.left.clone();
    for (rest, column) in rest
        .iter_mut()
        .zip(task.iter().flat_map(|task| &task.column.0))
    {
        let each = rest.iter_mut().zip(column.iter().flatten());
        each.for_each(|(rest, late)| *rest -= late);
    }
    let mode = if task.is_some() {
        None
    } else {
        resonance::find(board, &left.left)
    };
    if rhythmic && task.is_none() && mode.is_none() {
        return Vec::new();
    }
    let levels = levels::fit(board, &rest);
    // A mode makes torque noise uneven and so moves the levels; stamps do not make a mode.
    let resonant = mode.filter(|mode| mode.gain > levels.gain() - 20.0);
    if let Some(mode) = resonant.map(|mode| mode.finding(board)) {
        return mode.plausible().then_some(mode).into_iter().collect();
    }
    let mut found: Vec<NoiseFinding> = task.into_iter().map(|task| task.finding).collect();
    if found.is_empty()
        && let Some(apart) = class_spread::find(board, &rest)
    {
        return vec![apart];
    }
    let bursts = if found.is_empty() {
        bursts::find(board, &levels)
    } else {
        None
    };
    if bursts.is_none() && flat::is_flat(board, &levels) {
        let stamps = jitter::find(board, &levels);
        found.extend(stamps.map(|found| spikes::instead(board, &levels, &found).unwrap_or(found)));
    }
    found.extend(bursts);
    found.retain(NoiseFinding::plausible);
    found
}

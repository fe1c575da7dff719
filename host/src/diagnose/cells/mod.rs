//! Cells of the map that have no frequency: few, and evaluated as they are.

mod groups;
mod local;
mod variants;

use rayon::prelude::*;

pub use groups::{SPEEDS, channels, classes, has_classes, numbers, steady};
pub use local::{bumps, loads};
pub use variants::{elsewhere, grown, harmonics, synchronous};

use super::effect::Effect;
use super::lsq::{Basis, OWN, dot};
use super::model::{Board, Fit};
use super::scan::Candidate;

/// White columns of the cells that are always tried: they hang on the noise alone, so they are worked out once for many looks.
#[derive(Clone, Debug)]
pub struct Bank {
    groups: Vec<Vec<Effect>>,
    effects: Vec<Effect>,
    columns: Vec<Vec<f64>>,
    steps: Vec<Vec<local::Step>>,
    bumps: Vec<local::Kind>,
}

impl Bank {
    /// Of a board.
    pub fn new(board: &Board) -> Self {
        let groups = steady(board);
        let mut effects: Vec<Effect> = Vec::new();
        for effect in groups.iter().flatten() {
            if !effects.contains(effect) {
                effects.push(*effect);
            }
        }
        let columns = board.columns_of(&effects).into_iter();
        Self {
            columns: columns.map(|mut own| own.swap_remove(0)).collect(),
            steps: local::steps(board),
            bumps: local::kinds_of_bumps(board),
            groups,
            effects,
        }
    }

    /// What each group explains beside a fit.
    pub fn candidates(&self, fit: &Fit, basis: &Basis) -> Vec<Candidate> {
        let cleared = self.columns.par_iter().map(|column| basis.beside(column));
        let cleared: Vec<Vec<f64>> = cleared.collect();
        // What is none of its own beside the model says nothing.
        let own = |(cleared, column): (&Vec<f64>, &Vec<f64>)| {
            dot(cleared, cleared) > OWN * dot(column, column)
        };
        let own: Vec<bool> = cleared.iter().zip(&self.columns).map(own).collect();
        let candidate = |effects: &Vec<Effect>| {
            let each = effects.iter();
            let at = each.filter_map(|effect| self.effects.iter().position(|one| one == effect));
            let at: Vec<usize> = at.collect();
            let columns: Vec<&[f64]> = at.iter().map(|&at| &cleared[at][..]).collect();
            let gain = if at.iter().all(|&at| own[at]) {
                Basis::default().gain(&columns, &fit.left)
            } else {
                0.0
            };
            Candidate {
                effects: effects.clone(),
                gain,
            }
        };
        self.groups.par_iter().map(candidate).collect()
    }
}

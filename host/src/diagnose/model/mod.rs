//! A model: effects beside what the twins declare, with all their numbers, fitted together to all recordings.

mod board;
mod fit;
mod noise;

pub use board::{Board, Correction};
pub use fit::Fit;
pub use noise::Wander;

use super::cells::numbers;
use super::effect::Effect;

/// An effect in a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// It.
    pub effect: Effect,
    /// Its sizes.
    pub sizes: Vec<f64>,
    /// Whether it is no finding: what nobody knows of any rig.
    pub nuisance: bool,
    /// Terms of one group are one finding.
    pub group: usize,
}

/// A model as fitted.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Its effects.
    pub terms: Vec<Term>,
}

impl Model {
    /// Adds effects that are one finding.
    pub fn add(&mut self, effects: &[Effect], group: usize) {
        self.terms.extend(effects.iter().map(|effect| Term {
            effect: *effect,
            sizes: vec![0.0; effect.sizes()],
            nuisance: false,
            group,
        }));
    }

    /// Adds effects that are no finding.
    pub fn add_open(&mut self, effects: &[Effect], group: usize) {
        self.add(effects, group);
        let added = self.terms.iter_mut().rev().take(effects.len());
        added.for_each(|term| term.nuisance = true);
    }

    /// The same with effects that are one finding.
    #[must_use]
    pub fn with(&self, effects: &[Effect], group: usize) -> Self {
        let mut model = self.clone();
        model.add(effects, group);
        model
    }

    /// Terms that are asked for.
    fn filtered(&self, asked: impl Fn(&Term) -> bool) -> Self {
        let some = self.terms.iter().filter(|term| asked(term));
        Self {
            terms: some.cloned().collect(),
        }
    }

    /// What is no finding, and not open beside one.
    #[must_use]
    pub fn nuisances(&self) -> Self {
        let groups = self.groups();
        self.filtered(|term| !groups.contains(&term.group))
    }

    /// A group alone.
    #[must_use]
    pub fn only(&self, group: usize) -> Self {
        self.filtered(|term| term.group == group)
    }

    /// The same without a group.
    #[must_use]
    pub fn without(&self, group: usize) -> Self {
        self.filtered(|term| term.group != group)
    }

    /// Terms of a finding, and where they are; not what is open beside it.
    pub fn finding(&self, group: usize) -> impl Iterator<Item = (usize, &Term)> {
        let terms = self.terms.iter().enumerate();
        terms.filter(move |(_, term)| term.group == group && !term.nuisance)
    }

    /// Effects of a finding.
    pub fn effects(&self, group: usize) -> Vec<Effect> {
        self.finding(group).map(|(_, term)| term.effect).collect()
    }

    /// Sizes and knobs of a finding.
    pub fn numbers(&self, group: usize) -> usize {
        numbers(&self.effects(group))
    }

    /// Groups that are findings, in the order in which they were found.
    pub fn groups(&self) -> Vec<usize> {
        let mut groups: Vec<usize> = Vec::new();
        for term in self.terms.iter().filter(|term| !term.nuisance) {
            if !groups.contains(&term.group) {
                groups.push(term.group);
            }
        }
        groups
    }

    /// A group that no term has yet: what turned out to be open keeps the one that it had as a finding.
    pub fn unused(&self) -> usize {
        let free = |group: &usize| self.terms.iter().all(|term| term.group != *group);
        (0..=self.terms.len()).find(free).unwrap_or_default()
    }
}

//! A mechanism with the patterns that it leaves: what is weighed against others.

use super::basis::{Basis, channels};
use super::board::{Board, Column};
use crate::mechanism::{Mechanism, Rhythm};

/// What may be missing in the twin.
#[derive(Clone, Debug, PartialEq)]
pub struct Hypothesis {
    /// Its name.
    pub mechanism: Mechanism,
    /// Its patterns.
    pub bases: Vec<Basis>,
}

impl Hypothesis {
    /// Of one pattern.
    #[must_use]
    pub fn of(mechanism: Mechanism, basis: Basis) -> Self {
        Self {
            mechanism,
            bases: vec![basis],
        }
    }

    /// Of one pattern, by the name that this has.
    #[must_use]
    pub fn by(basis: Basis) -> Self {
        Self::of(basis.mechanism(), basis)
    }

    /// Of patterns together, by the name of the first; none of none.
    #[must_use]
    pub fn by_all(bases: Vec<Basis>) -> Option<Self> {
        let mechanism = bases.first()?.mechanism();
        Some(Self { mechanism, bases })
    }

    /// Its columns in all recordings.
    #[must_use]
    pub fn columns(&self, board: &Board) -> Vec<Column> {
        self.bases
            .iter()
            .flat_map(|basis| board.columns(*basis))
            .collect()
    }

    /// The same as angles, not white.
    #[must_use]
    pub fn raw_columns(&self, board: &Board) -> Vec<Column> {
        self.bases
            .iter()
            .flat_map(|basis| board.raw_columns(*basis))
            .collect()
    }

    /// Numbers that describe it and are not sizes: what was searched for.
    #[must_use]
    pub fn searched(&self) -> usize {
        self.bases
            .iter()
            .map(|basis| searched(*basis))
            .max()
            .unwrap_or(0)
    }

    /// The frequency or order of its rhythm.
    #[must_use]
    pub fn rhythm(&self) -> Option<f64> {
        match *self.bases.first()? {
            Basis::Round { order } | Basis::Lagged { order } | Basis::TorqueOrder { order } => {
                Some(order)
            }
            Basis::TorqueTone { f_hz } | Basis::LevelTone { f_hz, .. } => Some(f_hz),
            _ => None,
        }
    }

    /// The same at another frequency or order.
    #[must_use]
    pub fn at_rhythm(&self, rhythm: f64) -> Self {
        let bases = self.bases.iter().map(|basis| match *basis {
            Basis::Round { .. } => Basis::Round { order: rhythm },
            Basis::Lagged { .. } => Basis::Lagged { order: rhythm },
            Basis::TorqueOrder { .. } => Basis::TorqueOrder { order: rhythm },
            Basis::TorqueTone { .. } => Basis::TorqueTone { f_hz: rhythm },
            Basis::LevelTone { channel, .. } => Basis::LevelTone {
                f_hz: rhythm,
                channel,
            },
            other => other,
        });
        Self {
            mechanism: self.mechanism,
            bases: bases.collect(),
        }
    }

    /// Whether its rhythm is a whole order.
    #[must_use]
    pub fn whole(&self) -> bool {
        matches!(
            self.bases.first(),
            Some(Basis::Round { order } | Basis::Lagged { order } | Basis::TorqueOrder { order }) if order.fract() == 0.0
        )
    }
}

fn searched(basis: Basis) -> usize {
    match basis {
        Basis::Round { order } | Basis::Lagged { order } | Basis::TorqueOrder { order } => {
            usize::from(order.fract() != 0.0)
        }
        Basis::TorqueTone { .. }
        | Basis::LevelTone { .. }
        | Basis::Warming { .. }
        | Basis::Stribeck { .. } => 1,
        Basis::LevelDrift { .. } | Basis::Bump { .. } | Basis::Load { .. } => 2,
        _ => 0,
    }
}

/// What is tried whatever the residual shows.
#[must_use]
pub fn whatever_shows(board: &Board) -> Vec<Hypothesis> {
    let all = Mechanism::ALL.into_iter();
    all.flat_map(|mechanism| (mechanism.card().handling.proposed)(board))
        .collect()
}

/// What may make a rhythm of all edges alike.
#[must_use]
pub fn of_rhythm(rhythm: Rhythm) -> Vec<Hypothesis> {
    let all = Mechanism::ALL.into_iter();
    all.filter_map(|mechanism| {
        let basis = (mechanism.card().handling.of_rhythm)(rhythm)?;
        Some(Hypothesis::of(mechanism, basis))
    })
    .collect()
}

/// The same where the disc's pattern is not known either: what could be of the disc is fitted beside it.
#[must_use]
pub fn with_disc(mut hypothesis: Hypothesis, board: &Board) -> Hypothesis {
    let Some(first) = board.benches.first() else {
        return hypothesis;
    };
    let channels = channels(first.seen.classes);
    if let Some(first) = hypothesis.bases.first().copied() {
        let beside = hypothesis.mechanism.card().handling.beside;
        hypothesis.bases.extend(beside(first, channels));
    }
    hypothesis
}

//! A mechanism with the patterns that it leaves: what is weighed against others.

use super::basis::{Basis, channels};
use super::board::{Board, Column};
use crate::mechanism::Mechanism;

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

    /// Its columns in all recordings.
    #[must_use]
    pub fn columns(&self, board: &Board) -> Vec<Column> {
        self.bases
            .iter()
            .flat_map(|basis| board.columns(*basis))
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
        Basis::TorqueTone { .. } | Basis::LevelTone { .. } | Basis::Stribeck { .. } => 1,
        Basis::LevelDrift { .. } | Basis::Bump { .. } | Basis::Load { .. } => 2,
        Basis::Task { .. } => 3,
        _ => 0,
    }
}

/// What is the same for all edges of a class: widths, shifts and delays.
#[must_use]
pub fn of_classes(classes: i64) -> Vec<Hypothesis> {
    let channels = channels(classes);
    let mut all = Vec::new();
    if classes < 2 {
        return all;
    }
    let each = |basis: &dyn Fn(usize) -> Basis, from: usize| (from..channels).map(basis).collect();
    all.push(Hypothesis::of(
        Mechanism::WidthError,
        Basis::Width { channel: None },
    ));
    all.push(Hypothesis::of(
        Mechanism::EdgeDelay,
        Basis::RiseLate { channel: None },
    ));
    if channels > 1 {
        all.push(Hypothesis {
            mechanism: Mechanism::WidthError,
            bases: each(&|c| Basis::Width { channel: Some(c) }, 0),
        });
        all.push(Hypothesis {
            mechanism: Mechanism::EdgeDelay,
            bases: each(&|c| Basis::RiseLate { channel: Some(c) }, 0),
        });
        all.push(Hypothesis {
            mechanism: Mechanism::QuadratureError,
            bases: each(&|c| Basis::Shift { channel: c }, 1),
        });
        all.push(Hypothesis {
            mechanism: Mechanism::ChannelSkew,
            bases: each(&|c| Basis::Late { channel: c }, 1),
        });
    }
    all
}

/// What may make a rhythm of all edges alike, at so many cycles a turn and Hz; each known to within `within` cycles a turn.
#[must_use]
pub fn of_rhythm(order: f64, f_hz: f64, within: f64) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    let whole = order.round();
    if whole > 0.0 && (order - whole).abs() < within {
        let geometry = if whole == 1.0 {
            Mechanism::Eccentricity
        } else if whole == 2.0 {
            Mechanism::DiscTilt
        } else {
            Mechanism::LineError
        };
        all.push(Hypothesis::of(geometry, Basis::Round { order: whole }));
        all.push(Hypothesis::of(
            Mechanism::TorqueRipple,
            Basis::TorqueOrder { order: whole },
        ));
    }
    if whole > 0.0 && (order - whole).abs() < 0.3 * within {
        all.push(Hypothesis::of(
            Mechanism::TorqueTone,
            Basis::TorqueTone { f_hz },
        ));
        return all;
    }
    // A hair off a whole number, so that it is known as searched for.
    let order = if order.fract() == 0.0 {
        order + 1e-9
    } else {
        order
    };
    all.push(Hypothesis::of(Mechanism::Bearing, Basis::Round { order }));
    all.push(Hypothesis::of(
        Mechanism::GearMesh,
        Basis::TorqueOrder { order },
    ));
    all.push(Hypothesis::of(
        Mechanism::TorqueTone,
        Basis::TorqueTone { f_hz },
    ));
    all
}

/// The same where the disc's pattern is not known either: what could be of the disc is fitted beside it.
#[must_use]
pub fn with_disc(mut hypothesis: Hypothesis, board: &Board) -> Hypothesis {
    let Some(first) = board.benches.first() else {
        return hypothesis;
    };
    let channels = channels(first.seen.classes);
    match hypothesis.bases.first() {
        Some(Basis::TorqueOrder { order }) if order.fract() == 0.0 => {
            let round = Basis::Round { order: *order };
            hypothesis.bases.push(round);
        }
        Some(Basis::RiseLate { .. } | Basis::Late { .. }) => {
            hypothesis
                .bases
                .extend((0..channels).map(|c| Basis::Width { channel: Some(c) }));
            hypothesis
                .bases
                .extend((1..channels).map(|c| Basis::Shift { channel: c }));
        }
        _ => {}
    }
    hypothesis
}

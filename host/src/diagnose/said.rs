//! Findings with what the result keeps beside them.

use super::diagnosis::{Finding, Sized};
use super::effect::Site;
use crate::mechanism::Mechanism;

/// A finding with what the result keeps beside it.
#[derive(Clone, Debug)]
pub struct Said {
    /// The finding.
    pub finding: Finding,
    /// Its effects with their sizes.
    pub cells: Vec<Sized>,
    /// By how much the sum of squares falls with it; none of what bends no edge.
    pub loss: Option<f64>,
    /// Whether it is a mechanism of the catalogue, or a number that the twin declares.
    pub named: bool,
}

impl Said {
    /// A finding that is no effect of the model.
    pub const fn alone(finding: Finding) -> Self {
        Self {
            named: !matches!(finding.mechanism, Mechanism::Unknown),
            finding,
            cells: Vec::new(),
            loss: None,
        }
    }

    /// Whether it is another value of what the twin declares.
    pub fn corrects(&self) -> bool {
        let declared = |cell: &Sized| matches!(cell.effect.site, Site::Declared(_));
        self.named && self.cells.iter().any(declared)
    }

    /// Whether one of them moves all edges alike and the other one flank or channel against the others, so that neither is a part of the
    /// other.
    pub fn is_apart(&self, other: &Self) -> bool {
        let differ = |said: &Self| {
            let mut each = said.cells.iter().map(|cell| cell.effect.site);
            let first = each.next().and_then(Site::moves_all_alike)?;
            each.all(|site| site.moves_all_alike() == Some(first))
                .then_some(first)
        };
        matches!((differ(self), differ(other)), (Some(one), Some(other)) if one != other)
    }

    /// Takes another one as a part of it.
    fn take(&mut self, other: Self) {
        self.cells.extend(other.cells);
        self.loss = match (self.loss, other.loss) {
            (Some(loss), Some(other)) => Some(loss + other),
            (loss, other) => loss.or(other),
        };
        if other.finding.evidence.delta_bic > self.finding.evidence.delta_bic {
            self.finding = other.finding;
        }
    }

    /// How strongly it shows.
    pub fn strength(&self) -> f64 {
        let worth = self.finding.evidence.delta_bic;
        self.loss.map_or(worth, |loss| loss.max(worth))
    }
}

/// The named findings, the strongest first, and what has no name after them: as one finding, but for what can be no part of another.
pub fn merged(all: Vec<Said>) -> Vec<Said> {
    let (mut named, nameless): (Vec<_>, Vec<_>) = all.into_iter().partition(|one| one.named);
    let mut apart: Vec<Said> = Vec::new();
    for one in nameless {
        match apart.iter_mut().find(|other| !other.is_apart(&one)) {
            Some(other) => other.take(one),
            None => apart.push(one),
        }
    }
    for all in [&mut named, &mut apart] {
        all.sort_by(|a, b| b.strength().total_cmp(&a.strength()));
    }
    named.extend(apart);
    named
}

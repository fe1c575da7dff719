//! Confusion matrices: what was missing against what was named first.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{self, Write as _};

use quadcal_host::mechanism::Mechanism;

use super::score::{Named, Score};
use super::truth::SizeClass;

/// What was named first for effects of one size: one effect a case, masked and under a speed loop included.
#[derive(Clone, Debug)]
pub struct Matrix {
    /// The effects' size.
    pub size: SizeClass,
    /// How often, by what was missing and what was named.
    pub counts: BTreeMap<(Mechanism, Named), usize>,
}

impl Matrix {
    /// The matrices of a trial, by size.
    #[must_use]
    pub fn all(scores: &[Score]) -> Vec<Self> {
        let of_size = |size| {
            let mut counts = BTreeMap::new();
            let scores = scores.iter().filter(|score| score.kind.has_one_name());
            for score in scores.filter(|score| score.size == Some(size)) {
                // For physics of the catalogue the words for it are the id.
                let id = score.truth.first().and_then(|id| Mechanism::from_id(id));
                if let Some(id) = id {
                    *counts.entry((id, score.first)).or_insert(0) += 1;
                }
            }
            Self { size, counts }
        };
        let all = SizeClass::ALL.into_iter().map(of_size);
        all.filter(|matrix| !matrix.counts.is_empty()).collect()
    }

    /// How often a mechanism was named so.
    fn count(&self, truth: Mechanism, named: Named) -> usize {
        self.counts.get(&(truth, named)).copied().unwrap_or(0)
    }
}

impl fmt::Display for Matrix {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let truths: BTreeSet<Mechanism> = self.counts.keys().map(|key| key.0).collect();
        let known = |named: Named| match named {
            Named::Mechanism(Mechanism::Unknown) | Named::None | Named::Failed => None,
            Named::Mechanism(mechanism) => Some(mechanism),
        };
        let named = self.counts.keys().filter_map(|key| known(key.1));
        let both: BTreeSet<Mechanism> = truths.iter().copied().chain(named).collect();
        let columns: Vec<Named> = (both.iter().map(|&one| Named::Mechanism(one)))
            .chain([
                Named::Mechanism(Mechanism::Unknown),
                Named::None,
                Named::Failed,
            ])
            .collect();
        let mut head = format!("{:<25}", "missing \\ named first");
        for at in 0..both.len() {
            let _ = write!(head, "{:>3}", at + 1);
        }
        writeln!(f, "{head}  unknown  none  failed")?;
        for (at, &truth) in both.iter().enumerate() {
            write!(f, "{:>2} {:<22}", at + 1, truth.id())?;
            for (column, &named) in columns.iter().enumerate() {
                let width = match column.checked_sub(both.len()) {
                    None => 3,
                    Some(0) => 9,
                    Some(1) => 6,
                    Some(_) => 8,
                };
                match self.count(truth, named) {
                    0 => write!(f, "{:>width$}", ".")?,
                    count => write!(f, "{count:>width$}")?,
                }
            }
            writeln!(f)?;
        }
        Ok(())
    }
}

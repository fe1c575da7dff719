//! A twin with a finding in it: it can be simulated, and should then explain the recording.

use super::basis::{Basis, change_of, channels};
use super::board::Board;
use super::disc::Pattern;
use super::estimate::Estimate;
use super::run::Recorded;
use crate::mechanism::Mechanism;
use crate::twin::{Channel, Errors, Twin};

/// A twin being mended, and what its disc lacks: errors of each edge, rad.
#[derive(Clone, Debug)]
pub struct Mended {
    /// The twin.
    pub twin: Twin,
    /// What is added to its disc's errors, for each edge of the recording; empty where nothing is.
    pub errors_rad: Vec<f64>,
    /// Edges a turn of the recording: of a wheel's tooth it may have one.
    pub edges: usize,
    /// Its edge classes.
    pub classes: usize,
}

/// Whether a finding goes into the list of a disc's errors, edge by edge.
fn is_listed(basis: Basis) -> bool {
    matches!(
        basis.mechanism(),
        Mechanism::LineError | Mechanism::WidthError | Mechanism::QuadratureError
    )
}

/// Channel of a number.
#[must_use]
pub fn channel(number: usize) -> Channel {
    [Channel::A, Channel::B, Channel::C][number.min(2)]
}

/// Amplitude and phase with which sin(x + phase) makes sizes of cos and sin.
#[must_use]
pub fn wave(sizes: &[f64]) -> (f64, f64) {
    match sizes {
        [cos, sin] => (cos.hypot(*sin), cos.atan2(*sin)),
        _ => (sizes[0], 0.0),
    }
}

impl Mended {
    /// Puts an estimate in; `recording` is this twin's, of so many.
    pub fn add(&mut self, estimate: &Estimate, recording: usize, recordings: usize) {
        let mut at = 0;
        for basis in &estimate.hypothesis.bases {
            let count = basis.count();
            let rest = estimate.sizes.len() - at;
            // Sizes of each recording's own, or one for all.
            let own = rest >= count * recordings
                && recordings > 1
                && estimate.hypothesis.bases.len() == 1;
            let from = if own { at + recording * count } else { at };
            let Some(sizes) = estimate.sizes.get(from..from + count) else {
                return;
            };
            self.add_basis(*basis, sizes);
            at += if own { count * recordings } else { count };
        }
    }

    /// Channels that its encoder has.
    #[must_use]
    pub fn channels(&self) -> usize {
        channels(i64::from(self.twin.encoder.edges_per_line()))
    }

    /// Puts what the disc lacks into the twin, on top of the errors that it had; the whole list, where there is one.
    pub fn list(&mut self, known: &[f64]) -> Option<Vec<f64>> {
        if self.errors_rad.is_empty() {
            return None;
        }
        let pairs = known.iter().zip(&self.errors_rad);
        let list: Vec<f64> = pairs.map(|(known, more)| known + more).collect();
        // Of a wheel recorded with one edge of each tooth the other goes along.
        let each = (self.twin.encoder.grid_edges() as usize / self.edges).max(1);
        self.twin.errors = Errors {
            list_rad: list.iter().flat_map(|e| vec![*e; each]).collect(),
            ..Errors::default()
        };
        Some(list)
    }

    fn add_basis(&mut self, basis: Basis, sizes: &[f64]) {
        (basis.mechanism().card().handling.mends)(self, basis, sizes);
    }

    /// Adds errors of the disc by angle, channel and whether the edge rises.
    pub fn add_disc(&mut self, error: impl Fn(f64, usize, bool) -> f64) {
        let (edges, classes) = (self.edges, self.classes);
        let mut all = std::mem::take(&mut self.errors_rad);
        all.resize(edges, 0.0);
        for (edge, sum) in all.iter_mut().enumerate() {
            let ahead = usize::from(classes == 6);
            let change = change_of((edge + ahead) % classes, classes as i64);
            let theta = edge as f64 * std::f64::consts::TAU / edges as f64;
            *sum += error(theta, change.channel, change.rises);
        }
        self.errors_rad = all;
    }
}

/// The twins of a rig with a pattern of the disc and estimates in them, and the lists of errors where the disc needs one; `given` is
/// the recordings against the twins as they are.
#[must_use]
pub fn twins(
    rig: &[Recorded],
    given: &Board,
    pattern: Option<&Pattern>,
    numbers: &[Estimate],
) -> (Vec<Twin>, Vec<Option<Vec<f64>>>) {
    let each = rig.iter().enumerate().map(|(number, one)| {
        let edges = one.track.edges as usize;
        let mut bases = numbers.iter().flat_map(|n| &n.hypothesis.bases);
        let errors_rad = match pattern {
            Some(pattern) => pattern.errors_rad.clone(),
            None if bases.any(|basis| is_listed(*basis)) => vec![0.0; edges],
            None => Vec::new(),
        };
        let mut mended = Mended {
            twin: one.twin.clone(),
            errors_rad,
            edges,
            classes: one.track.classes as usize,
        };
        for estimate in numbers {
            mended.add(estimate, number, rig.len());
        }
        let list = mended.list(&given.benches[number].seen.errors);
        (mended.twin, list)
    });
    each.unzip()
}

/// The recordings with other twins.
#[must_use]
pub fn with_twins(rig: &[Recorded], twins: &[Twin]) -> Vec<Recorded> {
    let each = rig.iter().zip(twins).map(|(one, twin)| Recorded {
        twin: twin.clone(),
        ..one.clone()
    });
    each.collect()
}

#[cfg(test)]
mod tests;

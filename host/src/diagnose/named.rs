//! Numbers of a finding by the names that a twin has for them, with intervals, and the twin with them in.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::DVector;

use super::basis::Basis;
use super::diagnosis::Parameter;
use super::estimate::Estimate;
use super::instants::Between;
use super::search::{Found, Searched};
use crate::mechanism::Quantity;

/// Standard errors to either side that hold 95 of 100.
const NORMAL_95: f64 = 1.959_964;

/// A number as a function of an estimate's sizes and searched numbers, in one row.
pub type Value = Box<dyn Fn(&[f64]) -> f64>;

/// Numbers by their names.
pub type Named = Vec<(String, Value)>;

/// Sizes and searched numbers in one row.
#[must_use]
pub fn row(estimate: &Estimate) -> Vec<f64> {
    // Searched numbers are counted from where they are.
    let still = estimate.searched.iter().map(|_| 0.0);
    estimate.sizes.iter().copied().chain(still).collect()
}

/// The parameters of an estimate.
#[must_use]
pub fn parameters(estimate: &Estimate) -> BTreeMap<String, Parameter> {
    let row = row(estimate);
    let card = estimate.hypothesis.mechanism.card();
    values(estimate)
        .into_iter()
        .map(|(name, value)| {
            let mut parameter = parameter(estimate, &row, card.unit(&name), &*value);
            if let Some((_, between)) = estimate.between.iter().find(|(of, _)| *of == name) {
                parameter.ci95 = Some(*between);
            }
            (name, parameter)
        })
        .collect()
}

fn values(estimate: &Estimate) -> Named {
    let card = estimate.hypothesis.mechanism.card();
    (card.handling.values)(&Numbers::of(estimate))
}

/// The first number of a fit that no rig has: which, and its value.
#[must_use]
pub fn implausible(estimate: &Estimate) -> Option<(&'static Quantity, f64)> {
    let row = row(estimate);
    let named = values(estimate);
    let numbers = named
        .iter()
        .map(|(name, value)| (name.as_str(), value(&row)));
    estimate.hypothesis.mechanism.card().implausible(numbers)
}

/// The number of a finding that no rig has, if one is.
#[must_use]
pub fn no_rigs(searched: &Searched, number: usize) -> Option<(&'static Quantity, f64)> {
    let columns = |found: &Found| found.columns.len();
    let before: usize = searched.found[..number].iter().map(columns).sum();
    let (from, count) = (
        searched.nuisances + before,
        columns(&searched.found[number]),
    );
    let model = &searched.model;
    let covariance = model.covariance.view((from, from), (count, count));
    implausible(&Estimate {
        hypothesis: searched.found[number].hypothesis.clone(),
        sizes: model.sizes.as_slice()[from..from + count].to_vec(),
        searched: Vec::new(),
        covariance: covariance.into_owned(),
        between: Between::default(),
    })
}

fn parameter(
    estimate: &Estimate,
    row: &[f64],
    unit: &str,
    value: &dyn Fn(&[f64]) -> f64,
) -> Parameter {
    let here = value(row);
    let count = row.len().min(estimate.covariance.nrows());
    let slope = DVector::from_fn(count, |i, _| {
        let step = 1e-3 * estimate.covariance[(i, i)].sqrt();
        let mut moved = row.to_vec();
        moved[i] += step;
        let change = value(&moved) - here;
        if step > 0.0 { change / step } else { 0.0 }
    });
    let square =
        (slope.transpose() * estimate.covariance.view((0, 0), (count, count)) * &slope)[(0, 0)];
    let error = NORMAL_95 * square.max(0.0).sqrt();
    Parameter {
        value: here,
        unit: unit.to_owned(),
        ci95: (error > 0.0 && error.is_finite()).then_some([here - error, here + error]),
    }
}

/// What a mechanism names the numbers of an estimate from.
#[derive(Clone, Copy, Debug)]
pub struct Numbers<'a> {
    estimate: &'a Estimate,
    strongest: usize,
}

impl<'a> Numbers<'a> {
    /// Of an estimate. Of recordings with sizes of their own the one that shows it best speaks.
    #[must_use]
    pub fn of(estimate: &'a Estimate) -> Self {
        let count = estimate.hypothesis.bases[0].count();
        let strongest = (0..estimate.sizes.len() / count.max(1))
            .max_by(|a, b| weight(estimate, *a).total_cmp(&weight(estimate, *b)))
            .unwrap_or(0)
            * count;
        Self {
            estimate,
            strongest,
        }
    }

    /// Its first pattern.
    #[must_use]
    pub fn basis(&self) -> Basis {
        self.estimate.hypothesis.bases[0]
    }

    /// Its patterns that have a size, each with its place in the row.
    pub fn bases(&self) -> impl Iterator<Item = (usize, Basis)> + '_ {
        let sized = self.estimate.sizes.len();
        let bases = self.estimate.hypothesis.bases.iter().copied();
        bases.enumerate().take(sized)
    }

    /// How many patterns it has.
    #[must_use]
    pub fn patterns(&self) -> usize {
        self.estimate.hypothesis.bases.len()
    }

    /// Place of the first size of the recording that shows it best.
    #[must_use]
    pub const fn strongest(&self) -> usize {
        self.strongest
    }

    /// The size at a place.
    #[must_use]
    pub fn size(at: usize) -> Value {
        Box::new(move |row| entry(row, at))
    }

    /// Amplitude of the cos and sin at a place.
    #[must_use]
    pub fn amplitude(at: usize) -> Value {
        Box::new(move |row| entry(row, at).hypot(entry(row, at + 1)))
    }

    /// Phase with which sin(x + phase) makes the cos and sin at a place, rad.
    #[must_use]
    pub fn phase(at: usize) -> Value {
        Box::new(move |row| {
            let phase = entry(row, at).atan2(entry(row, at + 1));
            phase.rem_euclid(TAU)
        })
    }

    /// A number that was searched for: which of them, and steps add to it.
    #[must_use]
    pub fn searched(&self, number: f64, which: usize) -> Value {
        self.moved(number, which, |number, by| number + by)
    }

    /// The same where steps are of its logarithm.
    #[must_use]
    pub fn scaled(&self, number: f64, which: usize) -> Value {
        self.moved(number, which, |number, by| number * by.exp())
    }

    /// The same where steps move it around the turn.
    #[must_use]
    pub fn turned(&self, number: f64, which: usize) -> Value {
        self.moved(number, which, |number, by| (number + by).rem_euclid(TAU))
    }

    fn moved(&self, number: f64, which: usize, by: fn(f64, f64) -> f64) -> Value {
        let at = self.estimate.sizes.len() + which;
        Box::new(move |row| by(number, entry(row, at)))
    }
}

/// An entry of a row; what a recording does not show has no size.
fn entry(row: &[f64], at: usize) -> f64 {
    row.get(at).copied().unwrap_or(0.0)
}

/// How clearly a recording's own size stands out.
fn weight(estimate: &Estimate, recording: usize) -> f64 {
    let count = estimate.hypothesis.bases[0].count();
    (0..count)
        .map(|i| {
            let at = recording * count + i;
            estimate.sizes[at].powi(2) / estimate.covariance[(at, at)].max(f64::MIN_POSITIVE)
        })
        .sum()
}

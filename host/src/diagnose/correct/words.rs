//! Numbers that corrections measure, and their words.

use std::collections::BTreeMap;

use crate::diagnose::diagnosis::{Parameter, Sized};
use crate::diagnose::model::{Board, Correction, Fit};
use crate::diagnose::name::{NINETY_FIVE, Number};
use crate::report::si;

/// A number that a correction has: its path, its value as declared and as measured.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Where it is in the twin.
    pub path: String,
    /// Its unit.
    pub unit: &'static str,
    /// As declared.
    pub declared: f64,
    /// As measured.
    pub number: Number,
}

/// Numbers of a group of corrections.
#[must_use]
pub fn measured(board: &Board, fit: &Fit, group: usize) -> Vec<Measured> {
    let terms = &fit.model.terms;
    let mut of_group: Vec<&Correction> = Vec::new();
    for term in terms.iter().filter(|term| term.group == group) {
        let own = board.correction(&term.effect).map(|(own, _)| own);
        of_group.extend(own.filter(|own| of_group.iter().all(|one| one.first != own.first)));
    }
    let of_one = |own: &Correction| {
        // By how much each value is off, and its column.
        let effects = own.effects();
        let each = effects.iter().map(|effect| {
            let term = terms.iter().position(|term| term.effect == *effect)?;
            let column = fit.of.iter().position(|of| *of == (term, 0))?;
            Some((terms[term].sizes[0], column))
        });
        let each = each.collect::<Option<Vec<(f64, usize)>>>()?;
        let values = own.declared.iter().zip(&each);
        let values: Vec<f64> = values.map(|(declared, (by, _))| declared + by).collect();
        let of = |a: usize, b: usize| match (each.get(a), each.get(b)) {
            (Some((_, a)), Some((_, b))) => fit.covariance[(*a, *b)],
            _ => 0.0,
        };
        let covariance = [[of(0, 0), of(0, 1)], [of(1, 0), of(1, 1)]];
        let errors = own.knob.errors(&values, &covariance);
        let numbers = own.knob.numbers(&values).into_iter().zip(errors);
        let declared = own.knob.numbers(&own.declared);
        let paths = own.knob.paths().into_iter().zip(declared);
        let measured = paths
            .zip(numbers)
            .map(|((path, declared), (value, error))| Measured {
                path: path.to_string(),
                unit: path.unit(),
                declared,
                number: Number {
                    name: path.name(),
                    value,
                    error: Some(error),
                },
            });
        Some(measured.collect::<Vec<_>>())
    };
    of_group.into_iter().filter_map(of_one).flatten().collect()
}

/// Corrections in words: "gear_mesh.torque_n_m: 4.00 mN m declared, 2.00 +- 0.01 mN m measured"; `spread` widens the intervals.
#[must_use]
pub fn text(corrections: &[Measured], spread: f64) -> String {
    let each = corrections.iter().map(|one| {
        let error = one.number.error.unwrap_or(0.0) * NINETY_FIVE * spread;
        format!(
            "{}: {} declared, {} +- {} measured",
            one.path,
            si(one.declared, one.unit),
            si(one.number.value, one.unit),
            si(error, one.unit)
        )
    });
    each.collect::<Vec<_>>().join("; ")
}

/// Numbers that some cells correct, as the twin declares them.
#[must_use]
pub fn declared(board: &Board, cells: &[Sized]) -> BTreeMap<String, f64> {
    let mut all = BTreeMap::new();
    for cell in cells {
        if let Some((own, 0)) = board.correction(&cell.effect) {
            let names = own.knob.paths().into_iter().map(|path| path.name());
            all.extend(names.zip(own.knob.numbers(&own.declared)));
        }
    }
    all
}

/// Numbers of corrections as a finding has them; `spread` widens the intervals.
#[must_use]
pub fn parameters(corrections: &[Measured], spread: f64) -> BTreeMap<String, Parameter> {
    let each = corrections.iter().map(|one| {
        let by = one.number.error.map(|error| NINETY_FIVE * spread * error);
        let parameter = Parameter {
            value: one.number.value,
            unit: one.unit.to_owned(),
            ci95: by.map(|by| [one.number.value - by, one.number.value + by]),
        };
        (one.number.name.clone(), parameter)
    });
    each.collect()
}

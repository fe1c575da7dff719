//! Numbers that corrections measure, and their words.

use std::collections::BTreeMap;

use crate::diagnose::diagnosis::Sized;
use crate::diagnose::model::{Board, Correction, Fit};
use crate::diagnose::name::{NINETY_FIVE, Number};
use crate::report::si_digits;

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
            Some((terms[term].sizes[0], fit.column(term, 0)?))
        });
        let each = each.collect::<Option<Vec<(f64, usize)>>>()?;
        let values = own.declared.iter().zip(&each);
        let values: Vec<f64> = values.map(|(declared, (by, _))| declared + by).collect();
        let columns = [0, 1].map(|at| each.get(at).map(|(_, column)| *column));
        let covariance = fit.covariance_of(columns);
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

/// A number with as many digits as its error leaves, and one more.
fn digits(value: f64, error: f64, unit: &str) -> String {
    const LEAST: f64 = 3.0;
    let sure = (value.abs() / error).log10().floor() + 2.0;
    // Where the error is nothing or more than the number.
    let count = if sure.is_finite() {
        sure.clamp(LEAST, 9.0)
    } else {
        LEAST
    };
    let unit = if unit == "1" { "" } else { unit };
    let (number, unit) = si_digits(value, unit, count as usize);
    format!("{number} {unit}").trim_end().to_owned()
}

/// Corrections in words: "gear_mesh.torque_n_m: 4.00 mN m declared, 2.00 +- 0.01 mN m measured".
pub fn text(corrections: &[Measured]) -> String {
    let each = corrections.iter().map(|one| {
        let error = one.number.error.unwrap_or(0.0) * NINETY_FIVE;
        format!(
            "{}: {} declared, {} +- {} measured",
            one.path,
            digits(one.declared, error, one.unit),
            digits(one.number.value, error, one.unit),
            digits(error, error, one.unit)
        )
    });
    each.collect::<Vec<_>>().join("; ")
}

/// Numbers that some cells correct, as the twin declares them.
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

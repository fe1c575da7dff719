//! Numbers of a finding by the names that a twin has for them, with intervals, and the twin with them in.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use nalgebra::DVector;

use super::basis::Basis;
use super::diagnosis::Parameter;
use super::estimate::Estimate;

/// Standard errors to either side that hold 95 of 100.
const NORMAL_95: f64 = 1.959_964;

/// A number as a function of an estimate's sizes and searched numbers.
type Value<'a> = Box<dyn Fn(&[f64]) -> f64 + 'a>;

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
    let named = values(estimate);
    named
        .into_iter()
        .map(|(name, unit, value)| (name, parameter(estimate, &row, unit, &*value)))
        .collect()
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

/// Amplitude of cos and sin at a place of a row, and the phase with which sin(x + phase) makes them.
fn wave<'a>(at: usize) -> (Value<'a>, Value<'a>) {
    (
        Box::new(move |row| row[at].hypot(row[at + 1])),
        Box::new(move |row| row[at].atan2(row[at + 1]).rem_euclid(TAU)),
    )
}

type Named<'a> = Vec<(String, &'static str, Value<'a>)>;

fn values(estimate: &Estimate) -> Named<'_> {
    let sizes = estimate.sizes.len();
    // Recordings with sizes of their own: the one that shows it best speaks.
    let basis = estimate.hypothesis.bases[0];
    let strongest = (0..sizes / basis.count().max(1))
        .max_by(|a, b| weight(estimate, *a).total_cmp(&weight(estimate, *b)))
        .unwrap_or(0)
        * basis.count();
    let name = |text: &str| text.to_owned();
    let fixed = |number: f64, at: usize, scale: fn(f64, f64) -> f64| -> Value<'_> {
        Box::new(move |row: &[f64]| scale(number, row.get(at).copied().unwrap_or(0.0)))
    };
    let add = |number: f64, by: f64| number + by;
    let grow = |number: f64, by: f64| number * by.exp();
    let only = |at: usize| -> Value<'_> { Box::new(move |row: &[f64]| row[at]) };
    match basis {
        Basis::Round { order } | Basis::Lagged { order } => {
            let (amplitude, phase) = wave(0);
            if order.fract() == 0.0 {
                // amplitude sin(order theta - phase)
                let back: Value<'_> = Box::new(move |row| (-phase(row)).rem_euclid(TAU));
                vec![
                    (name("amplitude_rad"), "rad", amplitude),
                    (name("phase_rad"), "rad", back),
                ]
            } else {
                vec![
                    (name("order"), "1", fixed(order, sizes, add)),
                    (name("runout_rad"), "rad", amplitude),
                    (name("phase_rad"), "rad", phase),
                ]
            }
        }
        Basis::TorqueOrder { order } => {
            let (amplitude, phase) = wave(0);
            let order: Value<'_> = if order.fract() == 0.0 {
                Box::new(move |_| order)
            } else {
                fixed(order, sizes, add)
            };
            vec![
                (name("order"), "1", order),
                (name("torque_n_m"), "N m", amplitude),
                (name("phase_rad"), "rad", phase),
            ]
        }
        Basis::TorqueTone { f_hz } => {
            let (amplitude, phase) = wave(strongest);
            vec![
                (name("f_hz"), "Hz", fixed(f_hz, sizes, add)),
                (name("torque_n_m"), "N m", amplitude),
                (name("phase_rad"), "rad", phase),
            ]
        }
        Basis::LevelTone { f_hz, .. } => {
            let (amplitude, phase) = wave(strongest);
            vec![
                (name("f_hz"), "Hz", fixed(f_hz, sizes, add)),
                (name("angle_rad"), "rad", amplitude),
                (name("phase_rad"), "rad", phase),
            ]
        }
        Basis::Width { .. } | Basis::Shift { .. } | Basis::RiseLate { .. } | Basis::Late { .. } => {
            of_classes(estimate)
        }
        Basis::LevelDrift { from_s, tau_s } => vec![
            (name("angle_rad"), "rad", only(strongest)),
            (name("from_s"), "s", fixed(from_s, sizes, add)),
            (name("tau_s"), "s", fixed(tau_s, sizes + 1, grow)),
        ],
        Basis::Bump {
            angle_rad,
            width_rad,
            ..
        } => vec![
            (
                name("angle_rad"),
                "rad",
                fixed(angle_rad, sizes, |a, by| (a + by).rem_euclid(TAU)),
            ),
            (name("width_rad"), "rad", fixed(width_rad, sizes + 1, grow)),
            (name("error_rad"), "rad", only(0)),
        ],
        Basis::Load { from_s, until_s } => {
            let mut all: Named<'_> = vec![(name("torque_n_m"), "N m", only(strongest))];
            if from_s.is_finite() {
                all.push((name("from_s"), "s", fixed(from_s, sizes, add)));
            }
            if until_s.is_finite() {
                all.push((name("until_s"), "s", fixed(until_s, sizes + 1, add)));
            }
            all
        }
        Basis::Drift => vec![(name("fraction_per_s"), "1/s", only(strongest))],
        Basis::Coulomb => vec![(name("coulomb_n_m"), "N m", only(0))],
        Basis::Viscous => vec![(name("viscous_n_m_s"), "N m s", only(0))],
        Basis::Drag => vec![(name("drag_n_m_s2"), "N m s^2", only(0))],
        Basis::Stribeck { rad_s } => vec![
            (name("stribeck_n_m"), "N m", only(0)),
            (name("stribeck_rad_s"), "rad/s", fixed(rad_s, sizes, grow)),
        ],
        Basis::Direction => vec![(name("angle_rad"), "rad", only(0))],
        Basis::Task {
            f_hz,
            busy_s,
            phase_s,
        } => vec![
            (name("task_hz"), "Hz", fixed(f_hz, sizes, add)),
            (name("busy_s"), "s", fixed(busy_s, sizes + 1, add)),
            (name("phase_s"), "s", fixed(phase_s, sizes + 2, add)),
        ],
    }
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

/// Widths, shifts and delays by channel.
fn of_classes(estimate: &Estimate) -> Named<'_> {
    const CHANNELS: [char; 3] = ['a', 'b', 'c'];
    let mut all: Named<'_> = Vec::new();
    for (at, basis) in estimate.hypothesis.bases.iter().enumerate() {
        if at >= estimate.sizes.len() {
            break;
        }
        let value = || -> Value<'_> { Box::new(move |row: &[f64]| row[at]) };
        match *basis {
            Basis::Width { channel: None } => {
                all.push(("width_rad".to_owned(), "rad", value()));
            }
            Basis::Width { channel: Some(c) } if at == 0 || !all.is_empty() => {
                if matches!(estimate.hypothesis.bases[0], Basis::Width { .. }) {
                    all.push((format!("width_{}_rad", CHANNELS[c]), "rad", value()));
                }
            }
            Basis::Shift { channel }
                if matches!(estimate.hypothesis.bases[0], Basis::Shift { .. }) =>
            {
                let name = if estimate.hypothesis.bases.len() == 1 {
                    "quadrature_rad".to_owned()
                } else {
                    format!("shift_{}_rad", CHANNELS[channel])
                };
                all.push((name, "rad", value()));
            }
            Basis::RiseLate { channel: None } => {
                all.push(("rise_less_fall_s".to_owned(), "s", value()));
            }
            Basis::RiseLate { channel: Some(c) } => {
                all.push((format!("{}.rise_less_fall_s", CHANNELS[c]), "s", value()));
            }
            Basis::Late { channel } => {
                all.push((format!("{}_less_a_s", CHANNELS[channel]), "s", value()));
            }
            _ => {}
        }
    }
    all
}

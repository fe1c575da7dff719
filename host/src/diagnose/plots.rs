//! What a report draws of a diagnosis.

use super::board::{Bench, Model};
use super::diagnosis::Finding;
use super::locate::{Along, Among, spectrum};
use super::settle::Settled;
use super::shown::{FindingPlot, Line, RecordingPlot, Shown};

/// Points of a curve.
const POINTS: usize = 360;

/// Curves.
#[must_use]
pub fn shown(settled: &Settled, findings: &[Finding]) -> Shown {
    let recordings = settled.given.benches.iter().enumerate();
    Shown {
        findings: findings
            .iter()
            .map(|finding| plot(settled, finding))
            .collect(),
        recordings: recordings
            .map(|(number, bench)| RecordingPlot {
                before: in_time(bench, &settled.before, number),
                after: in_time(bench, &settled.after, number),
                spectrum_before: in_orders(bench, &settled.before, number).0,
                spectrum_after: in_orders(bench, &settled.after, number).0,
                threshold: in_orders(bench, &settled.before, number).1,
            })
            .collect(),
    }
}

/// Mean of so many cells of x, in rows of x and y.
fn cells(points: impl Iterator<Item = (f64, f64)> + Clone) -> Line {
    let range = points
        .clone()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (x, _)| {
            (low.min(x), high.max(x))
        });
    let width = ((range.1 - range.0) / POINTS as f64).max(f64::MIN_POSITIVE);
    let mut sums = vec![(0.0, 0.0, 0.0); POINTS];
    for (x, y) in points {
        let cell = (((x - range.0) / width) as usize).min(POINTS - 1);
        let sum = &mut sums[cell];
        *sum = (sum.0 + x, sum.1 + y, sum.2 + 1.0);
    }
    let there = sums.into_iter().filter(|sum| sum.2 > 0.0);
    there.map(|(x, y, count)| (x / count, y / count)).collect()
}

/// How far edges come from where they were expected, urad.
fn rad(bench: &Bench, model: &Model, number: usize) -> Vec<f64> {
    let pairs = model.left[number].iter().zip(bench.deviations());
    pairs
        .map(|(white, deviation)| 1e6 * white * deviation.unwrap_or(0.0))
        .collect()
}

fn in_time(bench: &Bench, model: &Model, number: usize) -> Line {
    let rad = rad(bench, model, number);
    cells(bench.seen.times_s.iter().copied().zip(rad.iter().copied()))
}

fn in_orders(bench: &Bench, model: &Model, number: usize) -> (Line, f64) {
    let spectrum = spectrum(bench, &model.left[number], Among::All, Along::Turn);
    let threshold = spectrum.threshold(0.05);
    // The largest of neighbours, so that no line is lost.
    let width = spectrum.powers.len().div_ceil(4 * POINTS).max(1);
    let peaks = spectrum
        .powers
        .chunks(width)
        .enumerate()
        .map(|(at, chunk)| {
            let top = chunk.iter().copied().fold(0.0, f64::max);
            ((at * width) as f64 * spectrum.step, top)
        });
    (peaks.collect(), threshold)
}

/// The residual in the coordinate in which a finding shows.
fn plot(settled: &Settled, finding: &Finding) -> FindingPlot {
    let bench = &settled.given.benches[0];
    let (before, after) = (
        rad(bench, &settled.before, 0),
        rad(bench, &settled.after, 0),
    );
    let seen = &bench.seen;
    let (label, x): (String, Box<dyn Fn(usize) -> f64>) = match (
        finding.place.frequencies_hz.first(),
        finding.place.orders.first(),
        finding.place.times_s.is_empty(),
    ) {
        (Some(f_hz), _, _) if finding.place.orders.is_empty() => {
            let f_hz = *f_hz;
            (
                format!("phase at {f_hz:.4} Hz, degrees"),
                Box::new(move |at| 360.0 * (seen.times_s[at] * f_hz).rem_euclid(1.0)),
            )
        }
        (_, Some(order), _) if finding.place.orders.len() == 1 => {
            let order = *order;
            (
                format!("phase at order {order:.4}, degrees"),
                Box::new(move |at| (order * seen.theta(at)).to_degrees().rem_euclid(360.0)),
            )
        }
        (_, _, false) => ("time, s".to_owned(), Box::new(|at| seen.times_s[at])),
        _ => (
            "angle of the disc, degrees".to_owned(),
            Box::new(|at| seen.theta(at).to_degrees().rem_euclid(360.0)),
        ),
    };
    let names = settled.class_names();
    let on: Vec<bool> = (0..names.len())
        .map(|class| {
            finding.place.edge_classes.is_empty()
                || finding
                    .place
                    .edge_classes
                    .iter()
                    .any(|name| name == names[class])
        })
        .collect();
    let line = |values: &[f64]| {
        let there = (0..seen.len()).filter(|at| on[seen.class(*at).min(on.len() - 1)]);
        cells(there.map(|at| (x(at), values[at])))
    };
    FindingPlot {
        mechanism: finding.mechanism,
        x_label: label,
        y_label: "edges off their expected place, urad".to_owned(),
        before: line(&before),
        after: line(&after),
        model: Vec::new(),
    }
}

//! What a report draws of a diagnosis.

use super::basis::{Basis, Change, change_of};
use super::board::{Bench, Model};
use super::diagnosis::Finding;
use super::kalman::{ShaftNoise, Whitener};
use super::locate::{Along, Among, spectrum};
use super::motion::foretold::Open;
use super::run::Diagnosed;
use super::settle::Settled;
use super::shown::{FindingPlot, Line, RecordingPlot, Shown};
use crate::mechanism::Mechanism;

/// Points of a curve, and of one of spreads.
const POINTS: usize = 360;
const SPREADS: usize = 60;

/// Curves.
#[must_use]
pub fn shown(settled: &Settled, findings: &[(Finding, Option<usize>)]) -> Shown {
    let recordings = settled.given.benches.iter().enumerate();
    Shown {
        findings: findings
            .iter()
            .map(|(finding, number)| plot(settled, finding, *number))
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

/// Puts what the twins as given leave, without a speed loop or a task that they lack, into what is drawn and said of it.
pub fn without(diagnosed: &mut Diagnosed, open: &Open) {
    let (board, model) = (&open.board, &open.model);
    for (number, plot) in diagnosed.shown.recordings.iter_mut().enumerate() {
        let Some(bench) = board.benches.get(number) else {
            return;
        };
        plot.before = in_time(bench, model, number);
        (plot.spectrum_before, plot.threshold) = in_orders(bench, model, number);
    }
    let first = diagnosed
        .shown
        .recordings
        .first()
        .map(|plot| plot.before.clone());
    let findings = diagnosed.diagnosis.findings.iter_mut();
    for (finding, plot) in findings.zip(&mut diagnosed.shown.findings) {
        if finding.mechanism == open.mechanism {
            finding.evidence.held_out_rms_ratio = open.held_out_ratio;
            plot.before = first.clone().unwrap_or_default();
        }
    }
}

/// Draws a task along its period.
pub fn with_task(diagnosed: &mut Diagnosed, plot: FindingPlot) {
    let task = |finding: &&Finding| {
        finding.mechanism == plot.mechanism && finding.parameters.contains_key("task_hz")
    };
    let findings = &diagnosed.diagnosis.findings;
    let number = findings.iter().position(|finding| task(&finding));
    if let Some(drawn) = number.and_then(|number| diagnosed.shown.findings.get_mut(number)) {
        *drawn = plot;
    }
}

/// Mean of so many cells of x, in rows of x and y.
fn cells(points: impl Iterator<Item = (f64, f64)> + Clone, count: usize) -> Line {
    let range = points
        .clone()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (x, _)| {
            (low.min(x), high.max(x))
        });
    let width = ((range.1 - range.0) / count as f64).max(f64::MIN_POSITIVE);
    let mut sums = vec![(0.0, 0.0, 0.0); count];
    for (x, y) in points {
        let cell = (((x - range.0) / width) as usize).min(count - 1);
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
    let each = bench.seen.times_s.iter().copied().zip(rad.iter().copied());
    let there = each.enumerate().filter(|(at, _)| !bench.seen.follows(*at));
    cells(there.map(|(_, point)| point), POINTS)
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

/// Bins of a finding's plot.
const BINS: usize = 60;

/// A finding in its coordinate: what it makes, and how much of that the recording shows, bin by bin.
///
/// In each bin the finding's mark, as it passes the noise's filter, is fitted to what is left without it: a size of 1 is the finding as
/// it was found. So shaft wander, which is larger than most marks, is not in the way.
fn plot(settled: &Settled, finding: &Finding, number: Option<usize>) -> FindingPlot {
    let label = |text: String| FindingPlot {
        mechanism: finding.mechanism,
        x_label: text,
        y_label: "what it moves edges by, urad".to_owned(),
        before: Vec::new(),
        after: Vec::new(),
        model: Vec::new(),
    };
    let Some(mark) = number.and_then(|number| settled.marks.get(number)) else {
        return residual_plot(settled, finding);
    };
    let bench = &settled.given.benches[mark.bench];
    let seen = &bench.seen;
    let (text, x) = coordinate(bench, finding, mark.basis);
    let mut bins = [(0.0, 0.0, 0.0, 0.0, 0.0); BINS];
    let places: Vec<f64> = (0..seen.len()).map(x).collect();
    let range = match mark.basis {
        Basis::Bump {
            angle_rad,
            width_rad,
            ..
        } => {
            let (middle, half) = (angle_rad.to_degrees(), 6.0 * width_rad.to_degrees());
            (middle - half, middle + half)
        }
        _ => places
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(*x), high.max(*x))
            }),
    };
    let width = ((range.1 - range.0) / BINS as f64).max(f64::MIN_POSITIVE);
    for (at, &place) in places.iter().enumerate() {
        if !(range.0..=range.1).contains(&place) || mark.angles[at] == 0.0 {
            continue;
        }
        let bin = &mut bins[(((place - range.0) / width) as usize).min(BINS - 1)];
        let sign = sign_of(mark.basis, change_of(seen.class(at), seen.classes));
        let white = mark.white[at];
        bin.0 += white * (mark.left[at] + white);
        bin.1 += white * white;
        bin.2 += 1e6 * sign * mark.angles[at];
        bin.3 += 1.0;
        bin.4 += place;
    }
    let mut plot = label(text);
    for bin in bins.iter().filter(|bin| bin.3 > 0.0 && bin.1 > 0.0) {
        let (x, model, share) = (bin.4 / bin.3, bin.2 / bin.3, bin.0 / bin.1);
        plot.model.push((x, model));
        plot.before.push((x, share * model));
        plot.after.push((x, (share - 1.0) * model));
    }
    plot
}

/// Which way a kind of edge is drawn: falls up and rises down where they are moved against each other.
fn sign_of(basis: Basis, change: Change) -> f64 {
    match basis {
        Basis::LevelTone { .. } | Basis::LevelDrift { .. } if change.rises => -1.0,
        _ => 1.0,
    }
}

type Coordinate<'a> = Box<dyn Fn(usize) -> f64 + 'a>;

/// What a finding is drawn along.
fn coordinate<'a>(bench: &'a Bench, finding: &Finding, basis: Basis) -> (String, Coordinate<'a>) {
    let seen = &bench.seen;
    match basis {
        Basis::TorqueTone { f_hz } | Basis::LevelTone { f_hz, .. } => (
            format!("phase at {f_hz:.4} Hz, degrees"),
            Box::new(move |at| 360.0 * (seen.times_s[at] * f_hz).rem_euclid(1.0)),
        ),
        Basis::Round { order } | Basis::Lagged { order } | Basis::TorqueOrder { order }
            if order > 2.5 =>
        {
            (
                format!("phase at order {order:.4}, degrees"),
                Box::new(move |at| (order * seen.theta(at)).to_degrees().rem_euclid(360.0)),
            )
        }
        Basis::LevelDrift { .. }
        | Basis::Load { .. }
        | Basis::Drift
        | Basis::Direction
        | Basis::Coulomb
        | Basis::Viscous
        | Basis::Drag
        | Basis::Stribeck { .. } => ("time, s".to_owned(), Box::new(|at| seen.times_s[at])),
        _ => {
            let _ = finding;
            (
                "angle of the disc, degrees".to_owned(),
                Box::new(|at| seen.theta(at).to_degrees().rem_euclid(360.0)),
            )
        }
    }
}

/// Of a whole disc, the error of each edge; of what is no pattern, how far edges come from where they were expected, along time.
fn residual_plot(settled: &Settled, finding: &Finding) -> FindingPlot {
    if let (Mechanism::LineError, Some(pattern)) = (finding.mechanism, &settled.pattern) {
        let step = 360.0 / pattern.errors_rad.len() as f64;
        let each = pattern.errors_rad.iter().enumerate();
        return FindingPlot {
            mechanism: finding.mechanism,
            x_label: "angle of the disc, degrees".to_owned(),
            y_label: "error of each edge, urad".to_owned(),
            before: cells(
                each.map(|(k, error)| (k as f64 * step, 1e6 * error)),
                POINTS,
            ),
            after: Vec::new(),
            model: Vec::new(),
        };
    }
    let bench = &settled.given.benches[0];
    let stamps = [Mechanism::TimestampJitter, Mechanism::CaptureLatency];
    if let Some(declared) = bench
        .declared
        .filter(|_| stamps.contains(&finding.mechanism))
    {
        return spread_plot(settled, finding, declared);
    }
    let line = |model: &Model| in_time(bench, model, 0);
    FindingPlot {
        mechanism: finding.mechanism,
        x_label: "time, s".to_owned(),
        y_label: "edges off their expected place, urad".to_owned(),
        before: line(&settled.before),
        after: line(&settled.after),
        model: Vec::new(),
    }
}

/// Of noise of the stamps, which moves no edge to one side: how far edges spread, over what the twin's noise makes and over what that which
/// was found makes.
fn spread_plot(settled: &Settled, finding: &Finding, declared: ShaftNoise) -> FindingPlot {
    let bench = &settled.given.benches[0];
    let spread = |white: &[f64]| -> Line {
        let squares = white.iter().map(|white| white * white);
        let each = bench.seen.times_s.iter().copied().zip(squares);
        let means = cells(each, SPREADS);
        means.into_iter().map(|(x, y)| (x, y.sqrt())).collect()
    };
    let after = &settled.after.left[0];
    let mut before = settled.before.left[0].clone();
    bench.whitener().restore(&mut before);
    Whitener::new(&bench.seen.readings, declared).whiten(&mut before);
    FindingPlot {
        mechanism: finding.mechanism,
        x_label: "time, s".to_owned(),
        y_label: "spread of edges about their expected place, 1 is what the noise makes".to_owned(),
        before: spread(&before),
        // The mended twin's edges may be fewer.
        after: if after.len() == before.len() {
            spread(after)
        } else {
            Vec::new()
        },
        model: Vec::new(),
    }
}

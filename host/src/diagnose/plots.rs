//! What a report draws of a diagnosis.

use super::board::{Bench, Model};
use super::diagnosis::Finding;
use super::kalman::{ShaftNoise, Whitener};
use super::locate::{Along, Among, spectrum};
use super::mark_plot::{self, lines_each};
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
    let there: Vec<(f64, f64)> = there.map(|(_, point)| point).collect();
    let cells = there.chunks(lines_each(there.len(), bench.seen.classes, POINTS));
    let mean = |cell: &[(f64, f64)]| {
        let (x, y) = cell
            .iter()
            .fold((0.0, 0.0), |sum, point| (sum.0 + point.0, sum.1 + point.1));
        (x / cell.len() as f64, y / cell.len() as f64)
    };
    cells.map(mean).collect()
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

/// A finding in the coordinate where it shows; what is no pattern, along time.
fn plot(settled: &Settled, finding: &Finding, number: Option<usize>) -> FindingPlot {
    let mark = number.and_then(|number| settled.marks.get(number));
    match mark {
        Some(mark) => mark_plot::plot(&settled.given.benches[mark.bench], mark, finding.mechanism),
        None => residual_plot(settled, finding),
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
    // What has no name is in no twin: it is all that is left beside what has one.
    let (before, after) = match finding.mechanism {
        Mechanism::Unknown => (line(&settled.after), Vec::new()),
        _ => (line(&settled.before), line(&settled.after)),
    };
    FindingPlot {
        mechanism: finding.mechanism,
        x_label: "time, s".to_owned(),
        y_label: "edges off their expected place, urad".to_owned(),
        before,
        after,
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

//! Stamps noisier than the twin declares: white jitter, or a one-sided latency, which is skewed. Or less noisy than it declares.

use super::agreement::{self, LEFT};
use super::bench;
use super::course::Course;
use super::disc;
use super::filter::Noise;
use super::model::{Board, Fit};
use super::name::NINETY_FIVE;
use super::noise::{self, Free};
use super::record::PLACES;
use super::scan::{self, SURE};
use crate::diagnose::diagnosis::{Finding, Parameter, Place, RunnerUp};
use crate::mechanism::Mechanism;
use crate::report::si;

/// How many times as much as edges before foretell stamps have to differ by.
const MORE: f64 = 4.0;
/// Deviations from which on an error of a stamp is far out, and by which more of these have to be late than early for a latency.
const FAR: f64 = 2.5;

/// Jitter or latency on top of what all twins declare, or less of what they do; none where one says nothing of its noise.
pub fn find(board: &Board, fit: &Fit) -> Option<Finding> {
    let says = |bench: &bench::Bench| bench.twin.noise.is_some() || bench.twin.timer.jitter_s > 0.0;
    // Where something is left, or noise has levels, its size says nothing of the stamps.
    let level = |bench: &bench::Bench| bench.weights.iter().all(|weight| *weight == 1.0);
    let judged = board.pattern.is_none() && board.benches.iter().all(level);
    if !judged || !board.benches.iter().all(says) {
        return None;
    }
    // A latency is told by its tails, which are of the noise here.
    let plain = board.in_plain_noise();
    // How the torque pushes between edges bears on what is left for the stamps: what is said holds any way.
    let speeds: [fn(&Course) -> f64; 2] = [Course::top, Course::mean];
    let held = speeds.map(|speed| plain.in_held_noise(speed));
    let held = held.into_iter().flatten();
    let mut each: Vec<(Board, Fit, f64)> = held
        .chain([plain])
        .map(|board| board.at_its_noise(&fit.model))
        .collect();
    each.sort_by(|a, b| a.2.total_cmp(&b.2));
    let found: Option<Vec<Finding>> = each
        .iter()
        .map(|(board, fit, _)| told(board, fit))
        .collect();
    found?.into_iter().next()
}

/// The same in the noise of a board.
fn told(board: &Board, fit: &Fit) -> Option<Finding> {
    let left = if agreement::is_white(board, fit) {
        0.0
    } else {
        agreement::correlated(board, &disc::rests(board, &fit.model))
    };
    if left > LEFT {
        return None;
    }
    let first = board.benches.first()?;
    let tick2 = first.record.tick_s.powi(2) / 12.0;
    let late = first
        .twin
        .capture_latency
        .and_then(|latency| latency.mean_s)
        .unwrap_or(0.0);
    let declared2 = tick2 + first.twin.timer.jitter_s.powi(2) + late * late;
    let rest = board.rest(&fit.model);
    let rests = bench::rests(&board.benches, &rest);
    let fitted = |least_s: f64, start: Noise, torque: bool, stamp: bool| {
        let free = Free {
            torque,
            drift: false,
            stamp,
            ..board.free
        };
        noise::fit(&rests, least_s, start, free)
    };
    let with = |noise: Noise, stamp_s: f64| Noise { stamp_s, ..noise };
    let start = with(board.noise, declared2.sqrt());
    let (_, given) = fitted(tick2.sqrt(), start, true, false);
    let (best, free) = fitted(tick2.sqrt(), board.noise, true, true);
    let gain = given - free;
    let worth = scan::evidence(board, gain, 1);
    if worth < SURE {
        return None;
    }
    let added2 = best.stamp_s * best.stamp_s - declared2;
    // What is left may be as much of it. Of an unknown drive a small part of the innovations may be how its noise pushes between edges.
    let hidden = board.undriven && shown(board) * added2.abs() < LEFT;
    if added2.abs() < MORE * left * declared2 || hidden {
        return None;
    }
    // Curvature of the likelihood over the stamp's logarithm.
    let cost = |factor: f64| fitted(0.0, with(best, best.stamp_s * factor), false, false).1;
    let by: f64 = 0.02;
    let curve = (cost(1.0 + by) + cost(1.0 - by) - 2.0 * cost(1.0)) / (by * by);
    let relative = if curve > 0.0 {
        (2.0 / curve).sqrt()
    } else {
        0.1
    };
    let finding = |mechanism, text, name: &str, value, ends| {
        let mut finding = Finding::of(mechanism, text, gain);
        finding.evidence.delta_bic = worth;
        finding.place = Place::of_stamps();
        let parameter = Parameter::between(value, "s", ends);
        finding.parameters.insert(name.to_owned(), parameter);
        finding
    };
    let (jitter, latency) = (Mechanism::TimestampJitter, Mechanism::CaptureLatency);
    if added2 < 0.0 {
        // The larger part of what is declared is what there is less of.
        let jitter2 = first.twin.timer.jitter_s.powi(2);
        let (mechanism, table, name, declared, other2) = if late * late > jitter2 {
            (latency, "capture_latency", "mean_s", late, jitter2)
        } else {
            (jitter, "timer", "jitter_s", jitter2.sqrt(), late * late)
        };
        let value2 = (best.stamp_s.powi(2) - tick2 - other2).max(0.0);
        let by2 = 2.0 * NINETY_FIVE * relative * best.stamp_s.powi(2);
        let ends = [value2 - by2, value2 + by2].map(|end| end.max(0.0).sqrt());
        let [declared, value_s, from, to] =
            [declared, value2.sqrt(), ends[0], ends[1]].map(|time_s| si(time_s, "s"));
        let text =
            format!("{table}.{name}: {declared} declared, {value_s} measured, {from} to {to}");
        return Some(finding(mechanism, text, name, value2.sqrt(), ends));
    }
    let share = added2 / best.stamp_s.powi(2);
    let (seen, expected, late) = skewness(board, fit, best.stamp_s, share);
    // A few that are far out skew a sum of cubes, though as many may be early as late.
    let skewed = seen > 0.5 * expected && late > FAR;
    let apart = (2.0 * seen - expected).abs() * expected;
    let (of, other, name, value, text) = if skewed {
        let value = added2.sqrt();
        let text = format!(
            "every capture late by an exponential latency of mean {}: skewed, not only spread",
            si(value, "s")
        );
        (latency, jitter, "mean_s", value, text)
    } else {
        let value = (best.stamp_s.powi(2) - tick2).max(added2).sqrt();
        let [value_s, added] = [value, added2.sqrt()].map(|time_s| si(time_s, "s"));
        let text = format!("stamps spread by {value_s} RMS, {added} more than declared");
        (jitter, latency, "jitter_s", value, text)
    };
    let error = relative * best.stamp_s * best.stamp_s / value;
    let ends = [value - NINETY_FIVE * error, value + NINETY_FIVE * error];
    let mut found = finding(of, text, name, value, ends);
    found.confidence = 1.0 / (1.0 + (-0.5 * apart).exp());
    found.evidence.runner_up = Some(RunnerUp {
        mechanism: other,
        delta_bic: apart,
    });
    if apart < 6.0 {
        found.look_alikes.push(other);
    }
    Some(found)
}

/// Part of the variance of an innovation that errors of the stamps make, for unit variance of these, 1/s^2.
fn shown(board: &Board) -> f64 {
    let each = board.benches.iter().flat_map(|bench| {
        let each = bench.course.speed.iter().zip(&bench.scales);
        each.map(|(speed, scale)| (speed * scale).powi(2))
    });
    each.sum::<f64>() / board.edges() as f64
}

/// How skewed the errors of the stamps are, how much a latency that makes a share of their variance would skew them, and how many more of
/// those that are far out are late than early, in deviations of what normal noise shows. A late stamp has the grid behind the shaft. Errors are smoothed, R S^-1 y: an innovation has the errors of the edges before with the other sign.
fn skewness(board: &Board, fit: &Fit, stamp_s: f64, share: f64) -> (f64, f64, f64) {
    let rests = board.rest(&fit.model);
    let (mut seen, mut expected, mut square) = (0.0, 0.0, 0.0);
    let (mut late, mut far) = (0.0, 0.0_f64);
    for (bench, rest) in board.benches.iter().zip(&rests) {
        let count = rest.len();
        // What one stamp's error does to the others is worked out at some edges.
        let stride = count.div_ceil(PLACES);
        let size = |at: usize| bench.course.speed[at] * stamp_s;
        let scores = bench.score(&bench.white(rest));
        let samples: Vec<usize> = (stride / 2..count).step_by(stride).collect();
        let unit = |at: &usize| {
            let mut row = vec![0.0; count];
            row[*at] = size(*at);
            row
        };
        let rows = bench.white_rows(samples.iter().map(unit).collect());
        let answers = bench.score_rows(rows);
        for (at, answer) in samples.iter().zip(&answers) {
            let own = size(*at) * answer[*at];
            if own <= 0.0 {
                continue;
            }
            // Correlations of the smoothed errors with this one.
            let each = (0..count).map(|other| size(other) * answer[other] / own);
            let (cubes, spread) = each.fold((0.0, 0.0), |(cubes, spread), of| {
                let cube: f64 = of * of * of;
                (cubes + cube, spread + 6.0 * cube + 9.0 * of)
            });
            let shows = 2.0 * (share * own).powf(1.5) * cubes;
            let weight = shows / spread;
            let near = (at - stride / 2)..(at - stride / 2 + stride).min(count);
            for near in near {
                let early = size(near) * scores[near] / own.sqrt();
                if early.abs() > FAR {
                    late -= early.signum();
                    far += 1.0;
                }
                seen -= weight * early.powi(3);
                expected += weight * shows;
                square += weight * weight * spread;
            }
        }
    }
    let deviation = square.sqrt().max(f64::MIN_POSITIVE);
    (
        seen / deviation,
        expected / deviation,
        late / far.max(1.0).sqrt(),
    )
}

//! How well twins and recordings agree: innovations before and after, whether they are noise, and on turns held out.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::bench::Bench;
use super::diagnosis::Curve;
use super::disc;
use super::effect::Site;
use super::judge::{self, Parts};
use super::lsq::dot;
use super::model::{Board, Fit, Model};
use super::rig::Recorded;
use super::scan::SURE;
use crate::diagnose::diagnosis::{Fit as Agreement, HeldOut, RecordingFacts};
use crate::twin::{Drive, Noise};

/// Lags that whiteness is tested over.
const LAGS: usize = 24;
/// Points of a curve.
const POINTS: usize = 300;
/// How many times as dense as declared torque noise is more, and no step of a grid.
const MORE: f64 = 1.5;
/// Share of the variance of innovations that those before foretell, from which on something is left that is not noise of which a twin does
/// not say how it is, or how it pushes between edges.
pub const LEFT: f64 = 0.03;
/// Probability of whiteness below which something is left.
pub const NOT_WHITE: f64 = 1e-6;

/// How well twins and recordings agree before and after, as a whole and along each recording.
pub fn agreement(
    rig: &[Recorded],
    given: &Board,
    board: &Board,
    fit: &Fit,
) -> (Agreement, Vec<Curve>) {
    let before = as_given(given, board);
    let plain = before.fit(&of_drive(fit));
    let edges = board.edges() as f64;
    // White innovations count in deviations of the noise; a deviation is so many rad.
    let scales = board.benches.iter().flat_map(|bench| &bench.scales);
    let deviation = rms(scales.copied().filter(|scale| *scale > 0.0)).map(f64::recip);
    let scale = deviation.unwrap_or(0.0);
    let rest = [
        disc::rests(&before, &plain.model),
        disc::rests(board, &fit.model),
    ];
    let to_rad = |square: f64, count: f64| Some(scale * (square / count.max(1.0)).sqrt());
    let [mut none, mut early, late] = Parts::held_out(board, fit).judged(fit);
    let mut found = !fit.model.groups().is_empty();
    let held = judge::HELD_OUT * edges;
    if disc::other(board, fit).is_some() {
        found = true;
        none = held_out(&before, &rest[0]);
        early = held_out(board, &early_rests(board, fit));
    }
    let reducible = (found && none > late).then(|| {
        // As a root of squares above what the best leaves.
        1.0 - ((early - late).max(0.0) / (none - late)).sqrt().min(1.0)
    });
    let agreement = Agreement {
        rms_before_rad: to_rad(plain.rss, edges),
        rms_after_rad: to_rad(fit.rss.min(plain.rss), edges),
        floor_rad: deviation,
        whiteness_p_before: Some(whiteness(&before, &rest[0])),
        whiteness_p: Some(whiteness(board, &rest[1])),
        correlated_before: Some(correlated(&before, &rest[0])),
        correlated: Some(correlated(board, &rest[1])),
        held_out: HeldOut {
            rms_before_rad: to_rad(none, held),
            rms_after_rad: to_rad(if found { early.min(none) } else { none }, held),
            floor_rad: to_rad(held, held),
            reducible_removed: reducible,
        },
    };
    (agreement, curves(rig, board, &rest))
}

/// Edges of a recording that are held out.
fn held(bench: &Bench) -> std::ops::Range<usize> {
    let rows = bench.record.len();
    let from = (1.0 - judge::HELD_OUT) * rows as f64;
    from as usize..rows
}

/// Sum of squares of the innovations of edges that are held out.
fn held_out(board: &Board, rests: &[Vec<f64>]) -> f64 {
    let each = board.benches.iter().zip(rests);
    let squares = each.map(|(bench, rest)| {
        let white = &bench.white(rest)[held(bench)];
        dot(white, white)
    });
    squares.sum()
}

/// Residual angles beside a model and the disc's pattern, rad, both fitted on the edges that are not held out.
fn early_rests(board: &Board, fit: &Fit) -> Vec<Vec<f64>> {
    let mut early = board.clone();
    for bench in &mut early.benches {
        let held = held(bench);
        bench.tails[held].fill(0.0);
    }
    let model = early.fit(&fit.model).model;
    disc::rests(&early, &model)
}

/// Twins as given, in the noise that was found: so that only the model differs.
pub fn as_given(given: &Board, board: &Board) -> Board {
    let mut before = given.clone();
    // How an unknown drive holds the shaft is open like the noise.
    for (bench, now) in before.benches.iter_mut().zip(&board.benches) {
        bench.found.hold = now.found.hold;
    }
    let mut before = before.found_anew().unwrap_or(before);
    (before.free, before.levels, before.rounds) = (board.free, board.levels, board.rounds);
    before.set_noise(board.noise);
    for (bench, now) in before.benches.iter_mut().zip(&board.benches) {
        bench.bend(now.found.corners.clone());
        bench.weights.clone_from(&now.weights);
        bench.tails.clone_from(&now.tails);
    }
    before.pattern = before.pattern_given();
    before
}

/// What nobody knows of any rig but the disc, which counts as the twins have it.
fn of_drive(fit: &Fit) -> Model {
    let mut model = fit.model.nuisances();
    model
        .terms
        .retain(|term| !matches!(term.effect.site, Site::Disc(_)));
    model
}

fn rms(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| {
        (sum + value * value, count + 1.0)
    });
    (count > 0.0).then(|| (sum / count).sqrt())
}

/// Whether what a fit leaves may be noise.
#[must_use]
pub fn is_white(board: &Board, fit: &Fit) -> bool {
    whiteness(board, &disc::rests(board, &fit.model)) >= NOT_WHITE
}

/// Whether innovations are far out more often than normal noise lets them be, and not at one place alone.
#[must_use]
pub fn heavy_tails(fit: &Fit) -> bool {
    // Deviations that are far, the share of normal noise beyond them, and how many times as many are too many.
    const FAR: f64 = 3.5;
    const SHARE: f64 = 4.65e-4;
    const TIMES: f64 = 4.0;
    const LEAST: f64 = 12.0;
    const BLOCKS: usize = 20;
    let count = fit.left.len();
    let mut far = [0.0; BLOCKS];
    for (at, white) in fit.left.iter().enumerate() {
        if white.abs() > FAR {
            far[at * BLOCKS / count] += 1.0;
        }
    }
    let all: f64 = far.iter().sum();
    let most = far.iter().copied().fold(0.0, f64::max);
    all > TIMES * SHARE * count as f64 + LEAST && most < 0.5 * all
}

/// How many times as dense as all twins declare it the torque noise is, in words, where that is sure, and its evidence.
#[must_use]
pub fn more_noise(board: &Board, fit: &Fit) -> Option<(String, f64)> {
    let declared = |bench: &Bench| match bench.twin.noise {
        Some(Noise::White { psd_n2_m2_s, .. }) => {
            Some(psd_n2_m2_s / bench.twin.shaft.inertia_kg_m2.powi(2))
        }
        _ => None,
    };
    let each: Option<Vec<f64>> = board.benches.iter().map(declared).collect();
    let torque = each?.into_iter().fold(0.0, f64::max);
    if board.pattern.is_some() || board.undriven || torque <= 0.0 {
        return None;
    }
    let plain = board.in_plain_noise();
    let (found, _, least) = plain.at_its_noise(&fit.model);
    let times = found.noise.torque / torque;
    let mut as_declared = plain;
    as_declared.free.torque = false;
    as_declared.set_noise(super::filter::Noise {
        torque,
        ..found.noise
    });
    let worth = as_declared.at_its_noise(&fit.model).2 - least;
    (times > MORE && worth > SURE).then(|| {
        let text = format!("torque noise {times:.1} times as dense as the twin declares");
        (text, worth)
    })
}

/// Part of its speed by which a drive in open loop may give way to a load.
const HOLDS: f64 = 0.2;

/// Probability that noise alone leaves innovations that hang together so (G. M. Ljung, G. E. P. Box, Biometrika 65, 1978).
pub fn whiteness(board: &Board, rests: &[Vec<f64>]) -> f64 {
    let (sum, lags) = correlation(board, rests);
    ChiSquared::new(lags).map_or(1.0, |chi| chi.sf(sum))
}

/// Share of the variance of the innovations that those before foretell, less what noise would have of it.
pub fn correlated(board: &Board, rests: &[Vec<f64>]) -> f64 {
    let each = board.benches.iter().zip(rests).map(|(bench, rest)| {
        let (count, lags) = autocorrelation(bench, rest);
        count * foretold(&lags) - lags.len() as f64
    });
    (each.sum::<f64>() / board.edges() as f64).clamp(0.0, 1.0)
}

/// Share of the variance of a row that its last values foretell, by its autocorrelation from lag 1 on: each partial correlation takes its
/// part of what is left (N. Levinson, Journal of Mathematics and Physics 25, 1946).
fn foretold(lags: &[f64]) -> f64 {
    let (mut weights, mut left) = (Vec::<f64>::new(), 1.0);
    for (at, lag) in lags.iter().enumerate() {
        let known = weights.iter().zip(lags[..at].iter().rev());
        let known: f64 = known.map(|(weight, lag)| weight * lag).sum();
        let partial = (lag - known) / left;
        let mirrored: Vec<f64> = weights.iter().rev().copied().collect();
        let each = weights.iter_mut().zip(mirrored);
        each.for_each(|(weight, mirrored)| *weight -= partial * mirrored);
        weights.push(partial);
        left *= 1.0 - partial * partial;
    }
    1.0 - left
}

/// Sum of squares of the innovations' autocorrelations, each over its variance in noise, and over how many lags.
pub fn correlation(board: &Board, rests: &[Vec<f64>]) -> (f64, f64) {
    let (mut sum, mut of) = (0.0, 0.0);
    for (bench, rest) in board.benches.iter().zip(rests) {
        let (count, lags) = autocorrelation(bench, rest);
        for (lag, value) in (1..).zip(&lags) {
            sum += count * (count + 2.0) * value.powi(2) / (count - f64::from(lag));
        }
        of += lags.len() as f64;
    }
    (sum, of)
}

/// Innovations and their autocorrelation at each lag from 1 on; those that are far out count less.
fn autocorrelation(bench: &Bench, rest: &[f64]) -> (f64, Vec<f64>) {
    let mut white = bench.white(rest);
    let each = white.iter_mut();
    each.for_each(|white| *white = white.clamp(-4.0, 4.0));
    let square: f64 = white.iter().map(|white| white * white).sum();
    let lags = (1..=LAGS.min(white.len() / 4)).map(|lag| {
        let products = white.iter().zip(&white[lag..]).map(|(a, b)| a * b);
        products.sum::<f64>() / square
    });
    (white.len() as f64, lags.collect())
}

/// What was read of a recording.
#[must_use]
pub fn facts(one: &Recorded, bench: &Bench, board: &Board) -> RecordingFacts {
    let r_min = 60.0 / std::f64::consts::TAU;
    let (least, most) = bench
        .course
        .speed
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
            (a.min(*v), b.max(*v))
        });
    RecordingFacts {
        file: one.file.clone(),
        twin: one.twin.name.clone(),
        edges: bench.record.len() as u64,
        edges_recorded: one.edges.time_s.len() as u64,
        turns: bench.record.turns(),
        seconds: bench.record.seconds(),
        speed_r_min: [least * r_min, most * r_min],
        other_speed_r_min: other_speed(one, bench).map(|both| both.map(|speed| speed * r_min)),
        anchored: bench.record.anchored,
        start_rad: one.start_rad(),
        stamp_rms_s: Some(board.noise.stamp_s),
        disturbed_s: one.edges.events.iter().map(|event| event.time_s).collect(),
        left_out: one.edges.unused.clone(),
    }
}

/// Speed that a twin's drive keeps and the mean speed of its recording, rad/s, where they are not about the same.
fn other_speed(one: &Recorded, bench: &Bench) -> Option<[f64; 2]> {
    let declared = match one.twin.drive {
        Drive::Constant { r_min } | Drive::SpeedLoop { r_min, .. } => r_min,
        _ => return None,
    };
    let declared = declared * std::f64::consts::TAU / 60.0;
    let (angle, time_s) = (&bench.course.angle, &bench.course.time_s);
    let mut mean = (angle.last()? - angle.first()?) / (time_s.last()? - time_s.first()?);
    // One channel does not show which way it turns.
    if bench.record.classes <= 2 {
        mean = mean.copysign(declared);
    }
    ((mean - declared).abs() > HOLDS * declared.abs()).then_some([declared, mean])
}

/// RMS of the innovations in windows along each recording, of residual angles before and after.
fn curves(rig: &[Recorded], board: &Board, [before, after]: &[Vec<Vec<f64>>; 2]) -> Vec<Curve> {
    let pairs = rig.iter().zip(&board.benches).enumerate();
    pairs
        .map(|(at, (recorded, bench))| {
            let window = bench.record.len().div_ceil(POINTS).max(1);
            let along = |rest: &[f64]| -> Vec<f64> {
                let white = bench.white(rest);
                let scaled = white.iter().zip(&bench.scales);
                let rad: Vec<f64> = scaled
                    .map(|(white, scale)| if *scale > 0.0 { white / scale } else { 0.0 })
                    .collect();
                let windows = rad.chunks(window);
                windows
                    .filter_map(|some| rms(some.iter().copied()))
                    .collect()
            };
            Curve {
                file: recorded.file.clone(),
                time_s: bench
                    .record
                    .time_s
                    .iter()
                    .copied()
                    .step_by(window)
                    .collect(),
                before_rad: along(&before[at]),
                after_rad: along(&after[at]),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_before_foretell_as_much_as_their_process_says() {
        // First order: the last value foretells its square. Second order: x = a x1 + b x2 + e.
        for last in [0.05_f64, 0.9, -0.6] {
            let lags: Vec<f64> = (1..=LAGS as i32).map(|lag| last.powi(lag)).collect();
            assert!((foretold(&lags) - last * last).abs() < 1e-12);
        }
        let (a, b) = (1.2, -0.8);
        let mut lags = vec![a / (1.0 - b)];
        lags.push(a * lags[0] + b);
        while lags.len() < LAGS {
            let at = lags.len();
            lags.push(a * lags[at - 1] + b * lags[at - 2]);
        }
        let share = a * lags[0] + b * lags[1];
        assert!((foretold(&lags) - share).abs() < 1e-12, "{share}");
    }
}

//! A speed loop where the twin says an open-loop drive (equation in [`super::sampled`]).
//!
//! Both are held against the recordings by their likelihood, the noise fitted to each: the drive with its stiffness, and a loop with its
//! sampling rate found by [`super::scan`] and its gains by least squares. A loop must damp well and take effect through the disc's
//! errors; a tone or a mode looks like a spring that hardly damps.

use std::f64::consts::TAU;

use nalgebra::{Matrix2, Vector2};

use super::MotionFinding;
use super::sampled::Sampled;
use super::scan;
use crate::diagnose::board::{Bench, Board};
use crate::diagnose::kalman::{ShaftNoise, Whitener};
use crate::diagnose::noise_fit::{self, Free};
use crate::diagnose::prepare;
use crate::diagnose::run::Recorded;
use crate::diagnose::shaft::ShaftLaw;
use crate::mechanism::Mechanism;
use crate::twin::{Drive, Twin};

/// Bandwidths that a loop may have, Hz.
const BANDWIDTH_HZ: std::ops::RangeInclusive<f64> = 0.3..=200.0;
/// Edges that a first noise is taken from.
const NOISE_EDGES: usize = 8_000;
/// Evidence that is needed.
const EVIDENCE_LEAST: f64 = 60.0;
/// Evidence that is needed an edge: a loop moves all of them, while a pattern of the disc that the twin lacks fits some rate by chance.
const EVIDENCE_AN_EDGE: f64 = 0.02;
/// Parts of a recording whose scatter is looked at.
const PARTS: usize = 10;
/// Edges by which a rate beside shifts the last sample, and the share of the evidence that must go with it: what a tone or an
/// unknown pattern explains by chance, rates beside explain as well.
const BESIDE: f64 = 8.0;
const FINGERPRINT: f64 = 0.25;
/// White variance from which the noise that a twin declares does not explain a recording.
const VARIANCE: f64 = 1.15;

/// One recording as a loop would explain it.
struct Side<'a> {
    sampled: Sampled,
    bench: &'a Bench,
    noise: ShaftNoise,
}

/// The gains over all recordings.
struct Gains {
    sizes: [f64; 2],
    /// Standard errors.
    errors: [f64; 2],
    /// -2 log likelihood.
    cost: f64,
    edges: f64,
}

/// A speed loop that the twins of a rig lack.
#[must_use]
pub fn recognised(rig: &[Recorded], board: &Board) -> Option<MotionFinding> {
    let open =
        |one: &Recorded| matches!(one.twin.drive, Drive::Constant { .. }) && !one.track.reverses();
    if rig.is_empty() || !rig.iter().all(open) || !board.benches.iter().any(unexplained) {
        return None;
    }
    let mut sides: Vec<Side> = rig
        .iter()
        .zip(&board.benches)
        .map(|(one, bench)| side(one, bench))
        .collect();
    // The slowest has most samples of the loop, and most of what it does.
    let slowest = sides
        .iter()
        .min_by(|a, b| a.sampled.rate_hz.total_cmp(&b.sampled.rate_hz))?;
    let rate = scan::rate(&slowest.sampled, slowest.noise)?;
    let mut f_hz = rate.f_hz;
    sides.iter_mut().for_each(|side| side.sampled.centre(f_hz));
    let mut found = gains(&sides, f_hz)?;
    for _ in 0..2 {
        for side in &mut sides {
            side.noise = noise_of(side, f_hz, found.sizes);
        }
        (f_hz, found) = sharpened(&sides, f_hz)?;
    }
    let open: f64 = sides.iter().map(|side| open_cost(side, f_hz)).sum();
    let delta_bic = open - found.cost - 3.0 * found.edges.ln();
    let [kp, ki] = found.sizes;
    let error = |i: usize| found.errors[i];
    let damps = ki < kp * kp && ki > -2.0 * error(1);
    let known = kp > 25.0 * error(0) && BANDWIDTH_HZ.contains(&(kp / TAU));
    if delta_bic < EVIDENCE_LEAST.max(EVIDENCE_AN_EDGE * found.edges) || !damps || !known {
        return None;
    }
    let fingerprint = beside(&sides, f_hz, BESIDE) - found.cost;
    if fingerprint < FINGERPRINT * delta_bic {
        return None;
    }
    let f_error = rate_error(&sides, f_hz, found.cost);
    let inertia = board.benches[0].law.inertia;
    let ki = ki.max(0.0);
    let finding = MotionFinding {
        mechanism: Mechanism::ClosedLoop,
        parameters: vec![
            ("kp_n_m_s", kp * inertia, error(0) * inertia),
            ("ki_n_m", ki * inertia, error(1) * inertia),
            ("f_hz", f_hz, f_error),
        ],
        delta_bic,
        text: format!(
            "A speed loop of {:.1} Hz bandwidth, sampled at {:.1} Hz, drives the shaft and chases the encoder's own errors; rates \
             that take the intervals beside are worse by {fingerprint:.0} in -2 log likelihood.",
            kp / TAU,
            f_hz
        ),
        twins: rig
            .iter()
            .map(|one| with(&one.twin, f_hz, kp, ki))
            .collect(),
    };
    finding.plausible().then_some(finding)
}

/// Whether the noise that a twin declares leaves something.
fn unexplained(bench: &Bench) -> bool {
    let squares: f64 = bench.white.iter().map(|white| white * white).sum();
    bench.declared.is_none() || squares > VARIANCE * bench.white.len() as f64
}

fn with(twin: &Twin, f_hz: f64, kp: f64, ki: f64) -> Twin {
    let mut twin = twin.clone();
    let inertia = twin.shaft.inertia_kg_m2;
    if let Drive::Constant { r_min } = twin.drive {
        // The loop holds the speed, nothing else does.
        twin.shaft.stiffness_n_m_s = 0.0;
        twin.drive = Drive::SpeedLoop {
            r_min,
            f_hz,
            bandwidth_hz: None,
            kp_n_m_s: Some(kp * inertia),
            ki_n_m: Some(ki * inertia),
            timeout_s: None,
            limit_n_m: None,
        };
    }
    twin
}

fn side<'a>(one: &Recorded, bench: &'a Bench) -> Side<'a> {
    let mut loose = one.twin.clone();
    loose.shaft.stiffness_n_m_s = 0.0;
    loose.noise = None;
    let law = ShaftLaw::of(&loose);
    let free = Recorded {
        twin: loose,
        ..one.clone()
    };
    // The twin was run before; a board has come of it.
    let seen = prepare::seen(&free).unwrap_or_else(|_| bench.seen.clone());
    let sampled = Sampled::new(&seen, &law);
    let count = sampled.len().min(NOISE_EDGES);
    let edges: Vec<usize> = (0..count).collect();
    let readings = sampled.readings(&edges);
    let noise = noise_fit::fit(
        &readings,
        &sampled.angles[..count],
        bench.least_stamp_s,
        bench.noise,
        Free::Sizes,
    );
    Side {
        sampled,
        bench,
        noise,
    }
}

/// Columns of a side: both gains, then what a shift of the mean speed makes.
fn columns(side: &Side, edges: &[usize], f_hz: f64) -> [Vec<f64>; 4] {
    let ([kp, ki], [level, slope]) = (side.sampled.gains(edges, f_hz), side.sampled.steady(edges));
    [kp, ki, level, slope]
}

/// Gains by least squares over all sides, each with its own steady pushes.
fn gains(sides: &[Side], f_hz: f64) -> Option<Gains> {
    let mut parts = Vec::new();
    let (mut cost, mut edges) = (0.0, 0.0);
    for side in sides {
        let all = side.sampled.edges_for(f_hz, 1);
        let whitener = side.sampled.whitener(&all, side.noise);
        let mut columns = columns(side, &all, f_hz);
        columns
            .iter_mut()
            .for_each(|column| whitener.whiten(column));
        let mut left = side.sampled.angles_at(&all);
        whitener.whiten(&mut left);
        cost += dot(&left, &left) + whitener.log_variance();
        edges += all.len() as f64;
        let [kp, ki, level, slope] = &columns;
        // The steady pushes taken out.
        let unit = |row: &[f64]| {
            let size = dot(row, row).sqrt();
            row.iter().map(|value| value / size).collect::<Vec<f64>>()
        };
        let level = unit(level);
        let share = dot(slope, &level);
        let slope = unit(
            &slope
                .iter()
                .zip(&level)
                .map(|(s, l)| s - share * l)
                .collect::<Vec<_>>(),
        );
        cost -= dot(&left, &level).powi(2) + dot(&left, &slope).powi(2);
        let clear = |row: &[f64]| {
            let (a, b) = (dot(row, &level), dot(row, &slope));
            let steady = level.iter().zip(&slope);
            row.iter()
                .zip(steady)
                .map(|(value, (l, s))| value - a * l - b * s)
                .collect::<Vec<f64>>()
        };
        let (kp, ki, left) = (clear(kp), clear(ki), clear(&left));
        let part = left.len().div_ceil(PARTS);
        for ((kp, ki), left) in kp.chunks(part).zip(ki.chunks(part)).zip(left.chunks(part)) {
            let across = dot(kp, ki);
            parts.push((
                Matrix2::new(dot(kp, kp), across, across, dot(ki, ki)),
                Vector2::new(dot(kp, left), dot(ki, left)),
            ));
        }
    }
    let gram: Matrix2<f64> = parts.iter().map(|part| part.0).sum();
    let right: Vector2<f64> = parts.iter().map(|part| part.1).sum();
    let inverse = gram.try_inverse()?;
    let sizes = inverse * right;
    cost -= right.dot(&sizes);
    // Between parts the gains may scatter more than the noise says: a sample at the very time of an edge goes either way.
    let scatter: Matrix2<f64> = parts
        .iter()
        .map(|(gram, right)| {
            let off = right - gram * sizes;
            off * off.transpose()
        })
        .sum();
    let count = parts.len() as f64;
    let between = inverse * scatter * inverse * (count / (count - 2.0));
    Some(Gains {
        sizes: [sizes[0], sizes[1]],
        errors: [0, 1].map(|i| inverse[(i, i)].max(between[(i, i)]).sqrt()),
        cost,
        edges,
    })
}

/// The noise once the loop is taken off.
fn noise_of(side: &Side, f_hz: f64, sizes: [f64; 2]) -> ShaftNoise {
    let all = side.sampled.edges_for(f_hz, 1);
    let readings = side.sampled.readings(&all);
    let columns = columns(side, &all, f_hz);
    let mut angles = side.sampled.angles_at(&all);
    for (column, size) in columns.iter().zip(sizes) {
        angles
            .iter_mut()
            .zip(column)
            .for_each(|(angle, value)| *angle -= size * value);
    }
    // The steady pushes as the filter sees them.
    let whitener = Whitener::new(&readings, side.noise);
    let mut white = columns.clone();
    white.iter_mut().for_each(|column| whitener.whiten(column));
    let mut left = angles.clone();
    whitener.whiten(&mut left);
    let at = |i: usize, j: usize| dot(&white[2 + i], &white[2 + j]);
    let both = Matrix2::new(at(0, 0), at(0, 1), at(1, 0), at(1, 1));
    let right = Vector2::new(dot(&white[2], &left), dot(&white[3], &left));
    if let Some(steady) = both.try_inverse().map(|inverse| inverse * right) {
        for (column, size) in columns[2..].iter().zip(steady.iter()) {
            angles
                .iter_mut()
                .zip(column)
                .for_each(|(angle, value)| *angle -= size * value);
        }
    }
    noise_fit::fit(
        &readings,
        &angles,
        side.bench.least_stamp_s,
        side.noise,
        Free::Sizes,
    )
}

/// -2 log likelihood of the twin's own drive over the same edges, the noise fitted.
fn open_cost(side: &Side, f_hz: f64) -> f64 {
    let from = side.sampled.edges_for(f_hz, 1)[0];
    let seen = &side.bench.seen;
    let noise = side.bench.noise_of(&seen.angles);
    let whitener = Whitener::new(&seen.readings[from..], noise);
    let mut white = seen.angles[from..].to_vec();
    whitener.whiten(&mut white);
    dot(&white, &white) + whitener.log_variance()
}

/// The best rate near one, to a small part of what shifts the last sample by an edge.
fn sharpened(sides: &[Side], f_hz: f64) -> Option<(f64, Gains)> {
    let edges = sides
        .iter()
        .map(|side| side.sampled.edges_since_zero())
        .fold(0.0, f64::max);
    let mut best = (f_hz, gains(sides, f_hz)?);
    let mut step = 0.2 / edges;
    while step > 2e-3 / edges {
        let around = [1.0 - step, 1.0 + step].map(|factor| best.0 * factor);
        let tried = around
            .into_iter()
            .filter_map(|f_hz| Some((f_hz, gains(sides, f_hz)?)));
        match tried.min_by(|a, b| a.1.cost.total_cmp(&b.1.cost)) {
            Some(better) if better.1.cost < best.1.cost => best = better,
            _ => step *= 0.5,
        }
    }
    Some(best)
}

/// Least -2 log likelihood of the rates that shift the last sample by so many edges.
fn beside(sides: &[Side], f_hz: f64, shift: f64) -> f64 {
    let edges = sides
        .iter()
        .map(|side| side.sampled.edges_since_zero())
        .fold(0.0, f64::max);
    let costs = [-1.0, 1.0].map(|way| gains(sides, f_hz * (1.0 + way * shift / edges)));
    let each = costs.map(|gains| gains.map_or(f64::INFINITY, |gains| gains.cost));
    each[0].min(each[1])
}

/// Standard error of the rate: half of what makes the likelihood fall to a 95 % interval's edge.
fn rate_error(sides: &[Side], f_hz: f64, cost: f64) -> f64 {
    // Stamps and steps of the search are no finer than some hundredths of an edge at the end.
    let edges = sides
        .iter()
        .map(|side| side.sampled.edges_since_zero())
        .fold(0.0, f64::max);
    let mut shift = 0.04;
    while shift < 0.3 * edges && beside(sides, f_hz, shift) - cost < 4.0 {
        shift *= 2.0;
    }
    0.5 * shift / edges * f_hz
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

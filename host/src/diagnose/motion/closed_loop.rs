//! A speed loop where the twin says an open-loop drive (equation in [`super::sampled`]).
//!
//! Both are held against the recordings by their likelihood, the noise fitted to each: the drive with its stiffness, and a loop with its
//! sampling rate found by [`super::scan`] and its gains by least squares. A loop must damp well and take effect through the disc's
//! errors; a tone or a mode looks like a spring that hardly damps.

use std::f64::consts::TAU;

use super::MotionFinding;
use super::gains::{Gains, Side, dot, gains, noise_of};
use super::sampled::Sampled;
use super::scan;
use crate::diagnose::board::{Bench, Board};
use crate::diagnose::kalman::Whitener;
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
/// Edges by which a rate beside shifts the last sample, and the share of the evidence that must go with it: what a tone or an
/// unknown pattern explains by chance, rates beside explain as well.
const BESIDE: f64 = 8.0;
const FINGERPRINT: f64 = 0.25;
/// White variance from which the noise that a twin declares does not explain a recording.
const VARIANCE: f64 = 1.15;

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

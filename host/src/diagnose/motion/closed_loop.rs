//! A speed loop where the twin says an open-loop drive (equation in [`super::sampled`]).
//!
//! Both are held against the recordings by their likelihood, the noise fitted to each: the drive with its stiffness, and a loop with its
//! sampling rate found by [`super::scan`] and its gains by least squares. A loop must damp well and take effect through the disc's
//! errors; a tone or a mode looks like a spring that hardly damps.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::MotionFinding;
use super::decided::decided;
use super::gains::{Side, gains, noise_of};
use super::sampled::Sampled;
use super::scan;
use super::sharp::{beside, polished, rate_error, sharpened};
use crate::diagnose::board::{Bench, Board};
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
/// Standard errors by which the gain is off zero: before and after samples that fall on an edge are decided.
const KNOWN_FIRST: f64 = 8.0;
const KNOWN: f64 = 25.0;
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
        .par_iter()
        .zip(&board.benches)
        .map(|(one, bench)| side(one, bench))
        .collect();
    // The slowest has most samples of the loop, and most of what it does.
    let slowest = sides
        .iter()
        .min_by(|a, b| a.sampled.rate_hz.total_cmp(&b.sampled.rate_hz))?;
    let rate = scan::rate(&slowest.sampled, slowest.noise)?;
    let mut f_hz = rate.f_hz;
    sides
        .par_iter_mut()
        .for_each(|side| side.sampled.centre(f_hz));
    let mut found = gains(&sides, f_hz)?;
    for _ in 0..2 {
        sides
            .par_iter_mut()
            .for_each(|side| side.noise = noise_of(side, f_hz, found.sizes));
        (f_hz, found) = sharpened(&sides, f_hz)?;
    }
    f_hz = polished(&sides, f_hz, found.sizes);
    let [kp, ki] = found.sizes;
    if kp < KNOWN_FIRST * found.errors[0] {
        return None;
    }
    let fingerprint = beside(&sides, f_hz, BESIDE) - found.cost;
    let put = |twin: &Twin, [kp, ki]: [f64; 2]| with(twin, f_hz, kp, ki.max(0.0));
    let decided = decided(rig, &sides, f_hz, [kp, ki], &put)?;
    let [kp, ki] = decided.sizes;
    let [kp_error, ki_error] = decided.errors;
    let each: Vec<f64> = sides
        .par_iter()
        .zip(&decided.benches)
        .map(|(side, looped)| gained(side.bench, looped))
        .collect();
    let delta_bic =
        each.into_iter().sum::<f64>() - (3.0 + decided.turned as f64) * found.edges.ln();
    let damps = ki < kp * kp && ki > -2.0 * ki_error;
    let known = kp > KNOWN * kp_error && BANDWIDTH_HZ.contains(&(kp / TAU));
    if delta_bic < EVIDENCE_LEAST.max(EVIDENCE_AN_EDGE * found.edges) || !damps || !known {
        return None;
    }
    if fingerprint < FINGERPRINT * delta_bic {
        return None;
    }
    let f_error = rate_error(&sides, f_hz, [kp, ki]);
    let inertia = board.benches[0].law.inertia;
    let ki = ki.max(0.0);
    let finding = MotionFinding {
        mechanism: Mechanism::ClosedLoop,
        parameters: vec![
            ("kp_n_m_s", kp * inertia, kp_error * inertia),
            ("ki_n_m", ki * inertia, ki_error * inertia),
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

/// By how much a loop in the twin makes a recording more likely, in -2 log likelihood, the noise fitted to both.
fn gained(open: &Bench, looped: &Bench) -> f64 {
    // The loop's residual begins once it has sampled; what both have is compared.
    let edges = open.seen.len().min(looped.seen.len());
    let cost = |bench: &Bench| {
        let noise = bench.noise_of(&bench.seen.angles);
        let from = bench.seen.len() - edges;
        noise_fit::cost(
            &bench.seen.readings[from..],
            &bench.seen.angles[from..],
            noise,
        )
    };
    let (open, looped) = rayon::join(|| cost(open), || cost(looped));
    open - looped
}

//! From recordings and twins to what is searched.

use std::f64::consts::TAU;

use rayon::prelude::*;

use super::board::{Bench, Board, Products};
use super::goes;
use super::kalman::ShaftNoise;
use super::looped::TIED_JITTER_S;
use super::one_channel::turned;
use super::run::{DiagnoseError, Recorded};
use super::seen::Seen;
use super::shaft::ShaftLaw;
use super::ties;
use super::track::Track;
use crate::sim::NOISE_STEPS;
use crate::twin::{Drive, Noise, Twin, TwinError};

/// Edges that a recording needs, and turns.
const EDGES_LEAST: usize = 200;
const TURNS_LEAST: f64 = 3.0;
/// Times what ties were looked for with that stamps are worse from which on they are looked for anew.
const WORSE: f64 = 1.2;

/// Compares all recordings with their twins.
///
/// # Errors
/// [`DiagnoseError`] where a twin can't be run or there is nothing to compare.
pub fn board(rig: &[Recorded]) -> Result<Board, DiagnoseError> {
    // The error is that of the first recording that has one, whichever comes first.
    let benches: Vec<Result<Bench, DiagnoseError>> = rig.par_iter().map(bench).collect();
    let benches: Result<Vec<Bench>, DiagnoseError> = benches.into_iter().collect();
    let tied = rig
        .iter()
        .all(|one| one.track.anchored || one.start_rad().is_some());
    Ok(Board {
        benches: benches?,
        tied,
        clear: std::sync::OnceLock::new(),
        products: Products::default(),
    })
}

/// The residual of one recording.
///
/// # Errors
/// As [`board`].
pub fn seen(one: &Recorded) -> Result<Seen, DiagnoseError> {
    Ok(seen_of(whole(one)?, one)?)
}

/// Its edges, each with its place also where one channel hides which way the shaft went.
fn whole(one: &Recorded) -> Result<Track, DiagnoseError> {
    turned(one.track.clone(), &one.twin).map_err(|why| DiagnoseError::OtherMotion {
        file: one.file.clone(),
        twin: one.twin.name.clone(),
        why: why.to_string(),
    })
}

fn seen_of(mut track: Track, one: &Recorded) -> Result<Seen, TwinError> {
    if !track.anchored && !track.placed {
        track.starts_at(one.twin.shaft.initial_angle_rad);
    }
    Seen::of(&track, one.plan, &one.twin)
}

/// One recording with the noise that its twin declares, else one found.
///
/// # Errors
/// As [`board`].
pub fn bench(one: &Recorded) -> Result<Bench, DiagnoseError> {
    let turns = one.track.turns();
    let edges: usize = one.track.stretches.iter().map(|s| s.marks.len()).sum();
    if edges < EDGES_LEAST || turns < TURNS_LEAST {
        return Err(DiagnoseError::TooShort {
            file: one.file.clone(),
            edges,
            turns,
        });
    }
    if let Some(why) = goes::other(&one.track, &one.twin) {
        return Err(DiagnoseError::OtherRig {
            file: one.file.clone(),
            twin: one.twin.name.clone(),
            why,
        });
    }
    let seen = seen(one)?;
    if 2 * seen.len() < edges {
        return Err(DiagnoseError::OtherMotion {
            file: one.file.clone(),
            twin: one.twin.name.clone(),
            why: format!("{} of {edges} edges are where it goes", seen.len()),
        });
    }
    let mut bench = compared(one, seen);
    if let Some(turned) = &one.track.turned {
        ties::put_right(&mut bench, turned);
        return Ok(with_torques(bench, one));
    }
    let jitter_s = one.twin.timer.jitter_s.max(TIED_JITTER_S);
    if let Some(stamp_s) = ties::settle(&mut bench).filter(|stamp_s| *stamp_s > WORSE * jitter_s) {
        // Stamps that are worse than thought leave more samples in doubt.
        let mut doubted = one.clone();
        doubted.twin.timer.jitter_s = stamp_s;
        bench = compared(one, self::seen(&doubted)?);
        ties::settle(&mut bench);
    }
    Ok(with_torques(bench, one))
}

/// The same with the torques that its twin declares.
fn with_torques(mut bench: Bench, one: &Recorded) -> Bench {
    let ripples = one.twin.ripple.iter().chain(&one.twin.gear_mesh);
    bench.torques = ripples
        .filter_map(|ripple| ripple.torque_n_m.map(|torque| (ripple.order, torque)))
        .collect();
    bench
}

/// A residual with the noise that its twin declares, else one found.
fn compared(one: &Recorded, seen: Seen) -> Bench {
    let least_stamp_s = one.track.tick_s / 12_f64.sqrt();
    let law = ShaftLaw::of(&one.twin);
    let declared = declared(&one.twin, &law, least_stamp_s);
    let free_speed = matches!(
        one.twin.drive,
        Drive::Constant { .. } | Drive::SpeedLoop { .. }
    );
    let hold_s = hold_s(&one.twin, &law);
    Bench::new(seen, law, declared, least_stamp_s, free_speed, hold_s)
}

/// The noise that a twin declares; none where it says nothing of torque noise.
fn declared(twin: &Twin, law: &ShaftLaw, least_stamp_s: f64) -> Option<ShaftNoise> {
    let acceleration = match twin.noise? {
        Noise::White { psd_n2_m2_s, .. } => psd_n2_m2_s / (law.inertia * law.inertia),
        Noise::SpeedWander { rms_fraction, .. } => {
            let speed = twin.drive.nominal_rad_s();
            2.0 * law.damping(0.0, speed) * (rms_fraction * speed).powi(2)
        }
    };
    Some(ShaftNoise {
        acceleration,
        stamp_s: least_stamp_s.hypot(stamps_s(twin)),
        drift: 0.0,
        forgets_per_s: 0.0,
        hold_s: hold_s(twin, law),
        load: law.load,
    })
}

/// RMS error of a stamp that a twin declares, s: its jitter, and the scatter of a latency, which is as large as its mean.
#[must_use]
pub fn stamps_s(twin: &Twin) -> f64 {
    let late_s = twin.capture_latency.and_then(|latency| latency.mean_s);
    twin.timer.jitter_s.hypot(late_s.unwrap_or(0.0))
}

/// Time for which a twin holds each value of its torque noise, s, as the simulator does: one interval at the nominal speed, where it
/// does not say; 0 where nothing turns.
fn hold_s(twin: &Twin, law: &ShaftLaw) -> f64 {
    let nominal = twin.drive.nominal_rad_s().abs();
    let interval_s = TAU / (twin.encoder.grid_edges() as f64 * nominal);
    let hold_s = match twin.noise {
        Some(Noise::White { hold_s, .. }) => hold_s.unwrap_or(interval_s),
        Some(Noise::SpeedWander { hold_s, .. }) => {
            let coarsest = 1.0 / (NOISE_STEPS * law.damping(0.0, nominal));
            hold_s.unwrap_or(interval_s.min(coarsest))
        }
        None => interval_s,
    };
    if hold_s.is_finite() { hold_s } else { 0.0 }
}

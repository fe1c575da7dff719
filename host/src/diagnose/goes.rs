//! Whether a twin's shaft can go as a recording's does: a torque in a wrong unit would hold it, and a drive of another speed is another
//! rig's.

use std::f64::consts::TAU;

use super::delays::Delays;
use super::shaft::ShaftLaw;
use super::track::{Mark, Track};
use super::turning::speeds;
use crate::twin::{Drive, Twin};

/// Times its speed by which a shaft that never turns round may swing, as the law is linear.
const SWINGS: f64 = 3.0;
/// Times a drive's speed that a recording's may be, or the other way round.
const APART: f64 = 1.5;

/// Share of edges that a delay may put before the one before them: noise does at a few.
const DISORDERED: f64 = 0.1;

/// Why it can't; none where it can.
#[must_use]
pub fn other(track: &Track, twin: &Twin) -> Option<String> {
    let disordered = Delays::of(twin, track.classes).disordered(track);
    if disordered > DISORDERED {
        return Some(format!(
            "with its edge_delay and channel_skew {:.0} % of the edges would have come before the one before them; correct the \
             delays' unit",
            100.0 * disordered
        ));
    }
    if track.reverses() || twin.drive.reverses() {
        return None;
    }
    let marks = track.directed();
    let speeds = speeds(&marks, track);
    other_speed(&marks, track, twin).or_else(|| too_strong(&speeds, twin))
}

/// A drive that holds one speed, of another size or in the other direction.
fn other_speed(marks: &[(Mark, i64)], track: &Track, twin: &Twin) -> Option<String> {
    const R_MIN: f64 = 60.0;
    let (Drive::Constant { r_min } | Drive::SpeedLoop { r_min, .. }) = twin.drive else {
        return None;
    };
    let ((first, _), (last, _)) = (marks.first()?, marks.last()?);
    let turns = (last.place - first.place) as f64 / track.edges as f64;
    let there = R_MIN * turns / (last.time_s - first.time_s);
    // One channel alone does not say which way it goes.
    let ratio = if track.classes == 2 || track.classes == 1 {
        (there / r_min).abs()
    } else {
        there / r_min
    };
    let alike = (1.0 / APART..=APART).contains(&ratio);
    (!alike && there.is_finite()).then(|| {
        format!(
            "its drive goes at {r_min:.4} r/min, the recording's shaft at {there:.4} r/min; correct the drive's speed, or exchange \
             the encoder's channels if it turned the same way"
        )
    })
}

/// A torque that would stop or turn round the shaft at the recording's highest speed.
fn too_strong(speeds: &[Option<f64>], twin: &Twin) -> Option<String> {
    let top = speeds.iter().flatten().map(|speed| speed.abs());
    let top = top.fold(0.0, f64::max);
    let law = ShaftLaw::of(twin);
    let damping = law.damping(0.0, top);
    let ripples = twin
        .ripple
        .iter()
        .map(|one| ("ripple", one.order, one.torque_n_m));
    let meshes = twin
        .gear_mesh
        .iter()
        .map(|one| ("gear_mesh", one.order, one.torque_n_m));
    let bearings = twin
        .bearing
        .iter()
        .map(|one| ("bearing", one.order, one.torque_n_m));
    let turned = ripples.chain(meshes).chain(bearings);
    let turned = turned.map(|(section, order, torque)| (section, order * top, torque));
    let timed = twin.torque_tone.iter();
    let timed = timed.map(|one| ("torque_tone", TAU * one.f_hz, one.torque_n_m));
    let mut all = turned.chain(timed);
    all.find_map(|(section, turning, torque_n_m)| {
        let torque = torque_n_m?.abs();
        let swing = torque / (law.inertia * turning.hypot(damping));
        (top > 0.0 && swing > SWINGS * top).then(|| {
            format!(
                "a {section} of {torque} N m swings {:e} kg m^2 by {:.0} times the speed, and the recording's shaft never turns \
                 round; correct the torque's unit or the inertia's",
                law.inertia,
                swing / top
            )
        })
    })
}

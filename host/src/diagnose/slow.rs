//! Where a ripple that the twin declares sends the shaft to and fro, and a small swing about the twin's course says nothing.

use std::f64::consts::TAU;

use super::shaft::ShaftLaw;
use super::turning::Course;
use crate::twin::{Drive, Twin};

/// Speed below which the twin's ripple shapes the course itself, rad/s: a small swing about it says nothing there. A drive that turns
/// the shaft round against more than the ripple never lets it.
#[must_use]
pub fn too_slow(twin: &Twin, law: &ShaftLaw, course: &Course) -> f64 {
    /// How much more energy the shaft is to have than a ripple can take.
    const OVER: f64 = 25.0;
    /// How much stronger than the drive ripple is to be to hold the shaft for a while.
    const HOLDS: f64 = 4.0;
    /// Part of the top speed that is never too slow.
    const PART: f64 = 0.3;
    let slows = match twin.drive {
        Drive::Ramp {
            from_r_min,
            to_r_min,
            over_s,
        } => (to_r_min - from_r_min).abs() * (TAU / 60.0) / over_s,
        Drive::RunDown { .. } => twin.friction_n_m(0.0).abs() / law.inertia,
        _ => return 0.0,
    };
    let ripples: Vec<(f64, f64)> = twin
        .ripple
        .iter()
        .chain(&twin.gear_mesh)
        .filter_map(|ripple| Some((ripple.order, ripple.torque_n_m?.abs() / law.inertia)))
        .collect();
    if ripples.iter().map(|(_, push)| push).sum::<f64>() < HOLDS * slows {
        return 0.0;
    }
    let thrown: f64 = ripples.iter().map(|(order, push)| push / order).sum();
    let speeds = course.iter().flatten().map(|(_, speed, _)| speed.abs());
    let top = speeds.fold(0.0, f64::max);
    (OVER * thrown).sqrt().min(PART * top)
}

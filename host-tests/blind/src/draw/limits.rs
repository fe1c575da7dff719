//! Sizes that a real rig can have: edges stay in order and the shaft keeps turning.

use std::f64::consts::TAU;

use super::effects::{run_s, slowest};
use crate::effect::{Carrier, Effect, Site};
use crate::rig::{Order, Rig};

/// Whether an effect is no larger than a rig can have.
#[must_use]
pub fn plausible(effect: &Effect, rigs: &[Rig]) -> bool {
    let rig = &rigs[0];
    let step = rig.encoder.step_rad();
    let slow = slowest(rigs);
    let top = rigs
        .iter()
        .fold(0.0, |most: f64, rig| most.max(rig.profile.top()));
    let swing = |o: &Order| o.torque_n_m / (rig.inertia * o.order * slow * slow) < 0.2;
    let sweep = |f_hz: f64, torque: f64| torque / (rig.inertia * TAU * f_hz * slow) < 0.2;
    let size = effect.size();
    match effect {
        Effect::Eccentricity { .. } | Effect::DiscTilt { .. } | Effect::Whirl { .. } => size < 0.05,
        Effect::BearingRunout { order, .. } => size * order < 0.1,
        Effect::LocalDefect { .. } => size < 0.4 * step,
        Effect::LineError { .. } => size < 0.04 * step,
        Effect::WidthError { .. }
        | Effect::QuadratureError { .. }
        | Effect::ThresholdRipple { .. }
        | Effect::ThresholdDrift { .. }
        | Effect::Telegraph { .. } => size < 0.2 * step,
        Effect::EdgeDelay { .. } | Effect::ChannelSkew { .. } => size * top < 0.2 * step,
        Effect::TorqueRipple(o) | Effect::GearMesh(o) | Effect::BearingTorque(o) => swing(o),
        Effect::TorqueTone { f_hz, .. } | Effect::Chirp { f_hz, .. } => sweep(*f_hz, size),
        Effect::OrderChirp { order, .. } | Effect::ModulatedOrder { order, .. } => {
            sweep(order * slow / TAU, size)
        }
        Effect::LoadStep { .. } => size < 0.2 * slow * rig.inertia * rig.damping(true),
        Effect::SpeedDrift { .. } => size * run_s(rig) < 0.3,
        Effect::Friction {
            coulomb_n_m,
            viscous_n_m_s,
            drag_n_m_s2,
            stribeck_n_m,
            ..
        } => {
            let torque = coulomb_n_m + viscous_n_m_s * top + drag_n_m_s2 * top * top + stribeck_n_m;
            torque < 0.3 * rig.viscous * top
        }
        Effect::TorsionalResonance { .. } => size < 0.6,
        Effect::TimestampJitter { .. } | Effect::CaptureLatency { .. } => size * top < 0.08 * step,
        Effect::BurstNoise { .. } => size < 0.1 * step,
        Effect::CaptureTask {
            task_hz, busy_s, ..
        } => busy_s * top < 0.5 * step && busy_s * task_hz < 0.5,
        Effect::Cell(cell) => match (cell.site, cell.carrier) {
            (Site::Torque, Carrier::Jumps | Carrier::Steady) => {
                size < 0.2 * slow * rig.inertia * rig.damping(true)
            }
            (Site::Torque, _) => size / (rig.inertia * cell.quickest(slow, 0.0) * slow) < 0.2,
            (Site::Disc, Carrier::Order { order, .. }) => size * order < 0.1,
            (Site::Disc | Site::Level, _) => size < 0.2 * step,
            (Site::Stamp, _) => size * top < 0.2 * step,
        },
        // No coupling is as loose as a tenth of a rad, however coarse the encoder.
        Effect::Hysteresis { .. } | Effect::Backlash { .. } => size < (3.0 * step).min(0.1),
        Effect::Creep { .. } => size < 0.5 * step,
        Effect::LostEdges { .. }
        | Effect::ExtraEdges { .. }
        | Effect::IndexSlip { .. }
        | Effect::StickSlip { .. }
        | Effect::ClosedLoop { .. } => true,
    }
}

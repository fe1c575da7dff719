//! Springs: between drive and shaft, between two masses.

use serde::{Deserialize, Serialize};

/// `stick_slip`: an open-loop drive pulls the shaft through a spring whose far end turns at the profile's speed w*: its torque is
/// stiffness_n_m_rad times the stretch, and `shaft.stiffness_n_m_s` (w* - w) beside it. Nothing else balances friction. Where friction falls
/// with speed (Stribeck) faster than viscous friction and drive damp, this ends in a limit cycle.
///
/// At time 0 the shaft slides at w*, the spring holding friction, if that is stable; else it sticks at the point of breaking away.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StickSlip {
    /// Stiffness of the spring, above 0.
    pub stiffness_n_m_rad: f64,
}

/// `torsional_resonance`: a share of the inertia is behind a spring with a damper; encoder, drive, friction, ripples and loads are on the
/// near side. Sizes given by the speed swing they make are those of a stiff shaft. With the share s, the spring has K = (2 pi f)^2 s (1 - s) J and the damper 2 damping_ratio (2 pi f) s (1 - s) J.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorsionalResonance {
    /// Frequency of the free, undamped shaft, 1 mHz to 1 MHz.
    pub f_hz: f64,
    /// Damping over critical damping, 0 to 1.
    #[serde(default)]
    pub damping_ratio: f64,
    /// Share of `shaft.inertia_kg_m2` on the far side, above 0 and below 1.
    pub inertia_share: f64,
    /// White torque noise on the far side: its two-sided density.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load_psd_n2_m2_s: Option<f64>,
    /// Step of that noise's grid; a 50th of the period of `f_hz` where left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load_hold_s: Option<f64>,
}

//! A plain rig for tests: even disc, no noise, nothing but inertia.

use std::f64::consts::TAU;

use crate::encoder::Encoder;
use crate::rig::{NoiseShape, Profile, Rig, Told};

/// 100 lines with index at a constant 10 rad/s, five turns.
pub fn plain() -> Rig {
    let encoder = Encoder::Quadrature {
        lines: 100,
        index: true,
    };
    Rig {
        encoder,
        disc_rad: vec![0.0; encoder.edges()],
        disc_known: true,
        inertia: 2e-4,
        viscous: 0.0,
        coulomb: 0.0,
        stiffness: 0.0,
        start_rad: 0.001,
        ripples: Vec::new(),
        noise_psd: 0.0,
        jitter_s: 0.0,
        noise_known: true,
        noise_shape: NoiseShape::White,
        told: Told::Whole,
        clock_hz: 84_000_000,
        profile: Profile::Constant { speed: 10.0 },
        turns: 5.0,
        longest_s: 10.0 * TAU,
    }
}

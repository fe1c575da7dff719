//! What must be known of a drive's speed loop to work out what it did.

use std::f64::consts::TAU;

use crate::twin::{Gains, SpeedLoop, Twin};

/// A sampled PI speed loop that sees the grid step over the last interval, and the shaft that it drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopModel {
    /// Speed asked for, rad/s; negative for reverse.
    pub target_rad_s: f64,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Time of a sample, s, counted from tick 0 of the recording; whole sample times make no difference.
    pub phase_s: f64,
    /// Gains over inertia.
    pub gains: Gains,
    /// Most acceleration the drive gives either way, rad/s^2.
    pub limit: f64,
    /// The measured speed is zero when no edge came for so long, s.
    pub timeout_s: f64,
    /// Viscous friction over inertia, 1/s.
    pub viscous: f64,
    /// Acceleration that the integrator holds at the start, rad/s^2: that of friction at the speed asked for. It matters only where the
    /// limit is reached.
    pub start: f64,
    /// Moment of inertia, kg m^2: turns accelerations into torques.
    pub inertia_kg_m2: f64,
}

impl LoopModel {
    /// The loop of a twin; none where its drive is open loop.
    #[must_use]
    pub fn of(twin: &Twin) -> Option<Self> {
        let SpeedLoop {
            target_rad_s,
            rate_hz,
            gains,
            limit,
            timeout_s,
            start,
        } = twin.speed_loop()?;
        let inertia_kg_m2 = twin.shaft.inertia_or_one();
        Some(Self {
            target_rad_s,
            rate_hz,
            phase_s: 0.0,
            gains,
            limit,
            timeout_s,
            viscous: twin.shaft.viscous_n_m_s / inertia_kg_m2,
            start,
            inertia_kg_m2,
        })
    }

    /// The frequency at which the loop's gain falls through 1, Hz: kp / 2 pi, below which it holds the measured speed.
    #[must_use]
    pub fn crossover_hz(&self) -> f64 {
        self.gains.kp / TAU
    }
}

//! Random numbers, one stream for each purpose, so that a change of one does not shift another.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// What a stream is for; the number is the ChaCha stream's and part of "same seed, same bytes".
#[derive(Clone, Copy, Debug)]
pub(super) enum Purpose {
    LinePosition = 1,
    StartSpeed = 2,
    Torque = 3,
    Jitter = 4,
    LostEdge = 5,
    Glitch = 6,
    Latency = 7,
    LoadTorque = 8,
}

/// One stream.
#[derive(Clone, Debug)]
pub(super) struct Stream {
    rng: ChaCha8Rng,
    spare: Option<f64>,
}

impl Stream {
    pub(super) fn new(seed: u64, purpose: Purpose) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(purpose as u64);
        Self { rng, spare: None }
    }

    /// Uniform from 0 up to, not including, 1.
    pub(super) fn unit(&mut self) -> f64 {
        self.rng.random()
    }

    /// Standard normal, by Box and Muller with `libm`: a ziggurat would call the platform's `ln` and `exp`, whose last bit differs.
    pub(super) fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        // 1 - u is never 0, so the logarithm is finite.
        let radius = (-2.0 * libm::log(1.0 - self.unit())).sqrt();
        let (sin, cos) = libm::sincos(TAU * self.unit());
        self.spare = Some(radius * sin);
        radius * cos
    }
}

//! Torques at fixed frequencies, as Taylor series in time.

use super::taylor::Series;

/// An acceleration amplitude sin(turning t + phase).
#[derive(Clone, Copy, Debug)]
pub(super) struct Tone {
    /// 2 pi f, rad/s.
    pub(super) turning: f64,
    pub(super) phase_rad: f64,
    /// Amplitude, rad/s^2.
    pub(super) amplitude: f64,
}

impl Tone {
    /// Adds its series around a time.
    pub(super) fn add_to(&self, force: &mut Series, now_s: f64) {
        let (sin, cos) = libm::sincos(self.turning * now_s + self.phase_rad);
        let (mut sine, mut cosine) = (self.amplitude * sin, self.amplitude * cos);
        for (k, term) in force.iter_mut().enumerate() {
            *term += sine;
            let over = self.turning / (k as f64 + 1.0);
            (sine, cosine) = (over * cosine, -over * sine);
        }
    }
}

//! Two masses and a spring: what a share of the inertia behind a spring does to the answer to torque.
//!
//! With the share s of the inertia J on the far side, k = (2 pi f0)^2 s (1 - s) J and c = 2 zeta (2 pi f0) s (1 - s) J, the near
//! side, where encoder and drive are, answers a torque with the dynamic stiffness
//! Z / J = i w b - (1 - s) w^2 - s w^2 K / (K - s w^2), K = (k + i w c) / J, against Z0 / J = i w b - w^2 of a stiff shaft
//! (Den Hartog, Mechanical Vibrations, 1956, ch. 3). Torque noise has its spectrum multiplied by |Z0 / Z|^2: 1 far below the mode,
//! a dip where the far side swings against a near side at rest, at f0 sqrt(1 - s), a peak at f0, and 1 / (1 - s)^2 far above. Noise on
//! the far side comes through K / (K - s w^2): the same peak, no dip, and less and less above.

use std::f64::consts::TAU;

use nalgebra::Complex;

/// A torsional mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoMass {
    /// Frequency of the free, undamped mode f0, Hz.
    pub f_hz: f64,
    /// Damping ratio zeta.
    pub damping_ratio: f64,
    /// Share s of the inertia on the far side.
    pub inertia_share: f64,
    /// Density of torque noise on the far side over that on the near side.
    pub load: f64,
}

impl TwoMass {
    /// By what the spectrum of the near side's angle is multiplied at a frequency; `damping` is b, 1/s, of the whole inertia.
    #[must_use]
    pub fn gain(&self, f_hz: f64, damping: f64) -> f64 {
        let (w, mode) = (TAU * f_hz, TAU * self.f_hz);
        let far = self.inertia_share;
        let reduced = far * (1.0 - far);
        let spring = Complex::new(
            mode * mode * reduced,
            2.0 * self.damping_ratio * mode * reduced * w,
        );
        let across = spring - far * w * w;
        let both =
            Complex::new(-(1.0 - far) * w * w, w * damping) * across - spring * (far * w * w);
        let stiff = w * w * (w * w + damping * damping);
        stiff * (across.norm_sqr() + self.load * spring.norm_sqr()) / both.norm_sqr()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dips_peaks_and_levels_are_where_the_masses_put_them() {
        let mode = TwoMass {
            f_hz: 40.0,
            damping_ratio: 1e-3,
            inertia_share: 0.36,
            load: 0.0,
        };
        assert!((mode.gain(0.1, 0.0) - 1.0).abs() < 1e-3);
        assert!((mode.gain(1e4, 0.0) * 0.64 * 0.64 - 1.0).abs() < 1e-3);
        let at = |f: f64| mode.gain(f, 0.0);
        assert!(at(32.0) < 1e-3 && at(32.0) < at(31.9) && at(32.0) < at(32.1));
        assert!(at(40.0) > 1e3 && at(40.0) > at(39.9) && at(40.0) > at(40.1));
        let both = TwoMass { load: 2.0, ..mode };
        let far = |f: f64| 0.5 * (both.gain(f, 0.0) - at(f));
        assert!((far(0.1) - 1.0).abs() < 1e-3);
        // At the mode the masses swing against each other, each as far as the other is heavy.
        let ratio: f64 = 0.64 / 0.36;
        assert!((far(40.0) / at(40.0) / ratio.powi(2) - 1.0).abs() < 1e-2);
        assert!(far(32.0) > 1.0 && far(1e3) < 1e-4);
    }
}

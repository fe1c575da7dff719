//! Torque noise and errors of stamps, as a rig has them.

use std::f64::consts::TAU;

use crate::random::Dice;
use crate::rig::{NoiseShape, Rig};

/// The noise of one run.
pub(super) struct Noise {
    torque: Dice,
    jitter: Dice,
    /// What a shape that is not white and normal needs on top, so that the others draw what they always drew.
    more: Dice,
    shape: NoiseShape,
    sigma: f64,
    /// Time for which a value is held, s.
    pub(super) hold_s: f64,
    /// Values held so far.
    pub(super) held: u64,
    /// Slow part, of variance 1.
    slow: f64,
}

impl Noise {
    pub(super) fn new(rig: &Rig, seed: u64) -> Self {
        let hold_s = rig.hold_s();
        let mut more = Dice::new(seed, 6);
        Self {
            torque: Dice::new(seed, 2),
            jitter: Dice::new(seed, 3),
            slow: more.normal(),
            more,
            shape: rig.noise_shape,
            sigma: (rig.noise_psd / hold_s).sqrt(),
            hold_s,
            held: 0,
        }
    }

    /// The next value of the torque at a speed, N m.
    pub(super) fn torque_n_m(&mut self, speed: f64) -> f64 {
        let white = self.sigma * self.torque.normal();
        match self.shape {
            NoiseShape::White | NoiseShape::StudentStamps => white,
            NoiseShape::BySpeed { at_rad_s } => white * (speed / at_rad_s).powi(2),
            NoiseShape::TwoSlopes { corner_hz, excess } => {
                let kept = libm::exp(-TAU * corner_hz * self.hold_s);
                self.slow = kept * self.slow + (1.0 - kept * kept).sqrt() * self.more.normal();
                // Far below the corner a first-order process of variance 1 has (1 + kept) / (1 - kept) times the density of white values.
                let gain = (excess * (1.0 - kept) / (1.0 + kept)).sqrt();
                white + self.sigma * gain * self.slow
            }
        }
    }

    /// The next error of a stamp, of RMS 1.
    pub(super) fn stamp(&mut self) -> f64 {
        let normal = self.jitter.normal();
        match self.shape {
            NoiseShape::StudentStamps => {
                // t is normal over the root of the mean of three squares; its variance is 3.
                let squares: f64 = (0..3).map(|_| self.more.normal().powi(2)).sum();
                normal / squares.sqrt()
            }
            _ => normal,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::plain;

    const COUNT: usize = 200_000;

    fn noise(shape: NoiseShape) -> Noise {
        let rig = Rig {
            noise_psd: 1e-8,
            noise_shape: shape,
            ..plain()
        };
        Noise::new(&rig, 3)
    }

    #[test]
    fn student_stamps_have_tails_that_normal_ones_have_not() {
        let beyond = |shape| {
            let mut noise = noise(shape);
            let far = (0..COUNT).filter(|_| noise.stamp().abs() > 5.0);
            far.count() as f64 / COUNT as f64
        };
        assert_eq!(beyond(NoiseShape::White), 0.0);
        // P(|t| > 5 sqrt(3)) with 3 degrees of freedom is 0.00324.
        let share = beyond(NoiseShape::StudentStamps);
        assert!((0.0027..0.0038).contains(&share), "{share}");
    }

    #[test]
    fn two_slopes_have_their_excess_below_the_corner() {
        let excess = 30.0;
        let density = |shape: NoiseShape, block: usize| {
            let mut noise = noise(shape);
            let blocks = COUNT / block;
            let sums = (0..blocks).map(|_| (0..block).map(|_| noise.torque_n_m(10.0)).sum::<f64>());
            sums.map(|sum| sum * sum).sum::<f64>() / (blocks * block) as f64
        };
        let hold_s = noise(NoiseShape::White).hold_s;
        let corner_hz = 0.05 / (TAU * hold_s);
        let two = NoiseShape::TwoSlopes { corner_hz, excess };
        let slow = density(two, 1000) / density(NoiseShape::White, 1000);
        assert!((slow / (1.0 + excess) - 1.0).abs() < 0.3, "{slow}");
        let quick = density(two, 1) / density(NoiseShape::White, 1);
        assert!(quick < 2.0, "{quick}");
    }

    #[test]
    fn noise_by_speed_goes_with_its_square() {
        let shape = NoiseShape::BySpeed { at_rad_s: 10.0 };
        let (mut slow, mut fast) = (noise(shape), noise(shape));
        let share = slow.torque_n_m(5.0) / fast.torque_n_m(10.0);
        assert!((share - 0.25).abs() < 1e-12, "{share}");
    }
}

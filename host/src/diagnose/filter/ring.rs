//! A mode of the machine that noise keeps ringing: a structure, a coupling or a drive that swings about its course.

use super::State::{Angle, Speed, Swing, Swings};
use crate::diagnose::square::Square;

/// A damped swing that white noise keeps up: q" + damping q' + rate^2 q = noise. It is part of the angle that edges show (S. H. Crandall,
/// W. D. Mark, Random Vibration in Mechanical Systems, 1963).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ring {
    /// Density of that noise, (rad/s^2)^2 s; 0 where nothing rings.
    pub density: f64,
    /// Its circular frequency undamped, rad/s.
    pub rate: f64,
    /// By how much it is damped, 1/s: less than half of what ends the swing.
    pub damping: f64,
    /// Correlation of that noise with the torque noise of the whole: 1 where one torque on the near side makes both, -1 on the far side.
    pub shared: f64,
}

/// Covariance of angle and speed of a swing: of the angle, of both, of the speed; and of angle and speed of the whole with either.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spread {
    own: [f64; 3],
    with: [[f64; 2]; 2],
}

/// Phase over a step, rad, below which the noise of a step counts as if nothing swung.
const SHORT: f64 = 1e-2;

impl Ring {
    /// Covariance of a swing that has always been kept up.
    pub fn at_rest(&self) -> Spread {
        let speed = self.density / (2.0 * self.damping);
        Spread {
            own: [speed / (self.rate * self.rate), 0.0, speed],
            ..Spread::default()
        }
    }

    /// Puts into a transition how it goes on over a time. The covariance that its noise adds over that, where the torque noise of the whole
    /// has a density and makes up a share of the time.
    pub fn over<const N: usize>(
        &self,
        h: f64,
        way: &mut Square<N>,
        torque: f64,
        share: f64,
    ) -> Spread {
        let half = 0.5 * self.damping;
        let swung = (self.rate * self.rate - half * half).max(0.0).sqrt();
        let (sin, cos) = (swung * h).sin_cos();
        let stays = (-half * h).exp();
        let sin = if swung > 0.0 { sin / swung } else { h };
        let qq = stays * (cos + half * sin);
        let qu = stays * sin;
        let uq = -self.rate * self.rate * qu;
        let uu = stays * (cos - half * sin);
        // Angle and speed are those of the whole: what the swing had of them goes another way.
        let (reach, kept) = (way[(Angle, Speed)], way[(Speed, Speed)]);
        way[(Angle, Swing)] = qq - 1.0;
        way[(Angle, Swings)] = qu - reach;
        way[(Speed, Swing)] = uq;
        way[(Speed, Swings)] = uu - kept;
        way[(Swing, Swing)] = qq;
        way[(Swing, Swings)] = qu;
        way[(Swings, Swing)] = uq;
        way[(Swings, Swings)] = uu;
        let with = share * self.shared * (self.density * torque).sqrt();
        if self.rate * h < SHORT {
            let speed = self.density * h;
            return Spread {
                own: [speed * h * h / 3.0, speed * h / 2.0, speed],
                with: [[h * h / 3.0, h / 2.0], [h / 2.0, 1.0]]
                    .map(|row| row.map(|of| with * h * of)),
            };
        }
        let [angle, _, speed] = self.at_rest().own;
        // Integrals of what a push does to the swing, and of that times the time since.
        let square = self.rate * self.rate;
        let once = (1.0 - qq) / square;
        let twice = (qu - h * uu - self.damping * (h * qu - once)) / square;
        Spread {
            own: [
                angle - qq * qq * angle - qu * qu * speed,
                -qq * uq * angle - qu * uu * speed,
                speed - uq * uq * angle - uu * uu * speed,
            ],
            with: [[twice, h * qu - once], [once, qu]].map(|row| row.map(|of| with * of)),
        }
    }
}

/// Adds the covariance of a swing to that of a state, whose angle and speed it is part of.
pub fn add<const N: usize>(p: &mut Square<N>, spread: Spread) {
    // Each with its place among angle and speed, and whether the whole is in it.
    let parts = [
        (Angle, 0, true),
        (Speed, 1, true),
        (Swing, 0, false),
        (Swings, 1, false),
    ];
    for (row, one, whole) in parts {
        for (column, other, also) in parts {
            let there = if whole { spread.with[one][other] } else { 0.0 };
            let back = if also { spread.with[other][one] } else { 0.0 };
            p[(row, column)] += spread.own[one + other] + there + back;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::filter::{DRIFTING, Filter, Noise, State, Whitens};
    use crate::diagnose::plant::free;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const RING: Ring = Ring {
        density: 3.0,
        rate: 700.0,
        damping: 30.0,
        shared: 0.7,
    };
    /// Density of the torque noise.
    const TORQUE: f64 = 2.0;

    #[test]
    fn two_steps_are_one_of_both() {
        let steps = [4e-3, 1e-3, 5e-3];
        let whole = |h: f64| {
            let leap = free::<{ State::Swings.and_before() }>(h);
            let mut way = leap.way;
            let mut p = Square::default();
            p.add(TORQUE, &leap.torque);
            add(&mut p, RING.over(h, &mut way, TORQUE, 1.0));
            (way, p)
        };
        let [(first, one), (second, other), (both, all)] = steps.map(whole);
        let way = crate::diagnose::square::product(&second, &first);
        let mut p = crate::diagnose::square::through(&second, &one);
        p.add(1.0, &other);
        for row in [Angle, Speed, Swing, Swings] {
            for column in [Angle, Speed, Swing, Swings] {
                let unit = RING.rate.powi(row as i32 % 2 - column as i32 % 2);
                assert!((way[(row, column)] - both[(row, column)]).abs() < 1e-9 * unit);
                let size = (all[(row, row)] * all[(column, column)]).sqrt();
                assert!((p[(row, column)] - all[(row, column)]).abs() < 1e-6 * size);
            }
        }
    }

    #[test]
    fn what_rings_is_white_beside_it_and_nothing_else() {
        let mut dice = ChaCha8Rng::seed_from_u64(5);
        // Nearly normal: a sum of as many as have a variance of 1.
        let mut normal = || (0..12).map(|_| dice.random::<f64>()).sum::<f64>() - 6.0;
        let (h, part) = (1e-3, 1e-5_f64);
        let ([mut q, mut u], [mut angle, mut speed]) = ([0.0; 2], [0.0; 2]);
        let angles: Vec<f64> = (0..20_000)
            .map(|_| {
                for _ in 0..100 {
                    let one = part.sqrt() * normal();
                    let other = part.sqrt() * normal();
                    let own = RING.shared * one + (1.0 - RING.shared.powi(2)).sqrt() * other;
                    u += RING.density.sqrt() * own
                        - part * (RING.damping * u + RING.rate.powi(2) * q);
                    q += part * u;
                    speed += TORQUE.sqrt() * one;
                    angle += part * speed;
                }
                angle + q + 1e-5 * normal()
            })
            .collect();
        let leaps = vec![free::<DRIFTING>(h); angles.len()];
        let lag = |ring: Ring| {
            let noise = Noise {
                torque: TORQUE,
                angle_rad: 1e-5,
                ring,
                ..Noise::default()
            };
            let mut white = angles.clone();
            Filter::<{ State::Swings.and_before() }>::new(&leaps, &noise).whiten(&mut white);
            let white = &white[100..];
            let square: f64 = white.iter().map(|one| one * one).sum();
            let next: f64 = white.iter().zip(&white[1..]).map(|(a, b)| a * b).sum();
            (square / white.len() as f64, next / square)
        };
        let (square, next) = lag(RING);
        assert!((square - 1.0).abs() < 0.03, "{square}");
        assert!(next.abs() < 0.025, "{next}");
        let (square, next) = lag(Ring {
            rate: 500.0,
            ..RING
        });
        assert!(
            (square - 1.0).abs() > 0.1 || next.abs() > 0.1,
            "{square} {next}"
        );
    }
}

//! One recording as the ideal estimator sees it: nominal motion, what is not known of it, and how it answers to locked torque.

use std::f64::consts::TAU;

use super::shaft::Shaft;

/// Gauss-Legendre nodes and weights on 0..1.
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_5),
    (0.230_765_344_947_158_5, 0.239_314_335_249_683_2),
    (0.5, 0.284_444_444_444_444_4),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_2),
    (0.953_089_922_969_332, 0.118_463_442_528_094_5),
];

/// A recording from its first edge 0 on, at time 0.
#[derive(Clone, Copy, Debug)]
pub struct Pass {
    /// Shaft and torque noise.
    pub shaft: Shaft,
    /// Speed at time 0, rad/s.
    pub from_rad_s: f64,
    /// Acceleration, rad/s^2; 0 for one speed.
    pub rate: f64,
    /// Whole turns learned from.
    pub turns: usize,
    /// RMS of a time stamp's error, s.
    pub stamp_s: f64,
}

impl Pass {
    /// Time at which the nominal motion has come to an angle, s.
    #[must_use]
    pub fn time(&self, angle: f64) -> f64 {
        // The root of from t + rate t^2 / 2 in the form that also holds at rate 0.
        let w = self.from_rad_s;
        2.0 * angle / (w + (w * w + 2.0 * self.rate * angle).sqrt())
    }

    /// Nominal speed at a time, rad/s.
    #[must_use]
    pub fn speed(&self, time: f64) -> f64 {
        self.from_rad_s + self.rate * time
    }

    /// Times of `points` places a turn, s.
    #[must_use]
    pub fn times(&self, points: usize) -> Vec<f64> {
        (0..points * self.turns)
            .map(|i| self.time(TAU * i as f64 / points as f64))
            .collect()
    }

    /// What the nominal motion may be off by: start angle, speed, acceleration where there is one, and a start speed of its own where
    /// the shaft has not settled.
    #[must_use]
    pub fn trends(&self, times: &[f64]) -> Vec<Vec<f64>> {
        let of = |f: &dyn Fn(f64) -> f64| times.iter().map(|&t| f(t)).collect();
        let mut trends = vec![of(&|_| 1.0), of(&|t| t)];
        if self.rate != 0.0 {
            trends.push(of(&|t| t * t));
        }
        if !self.shaft.settled {
            trends.push(of(&|t| (-self.shaft.damping * t).exp()));
        }
        trends
    }

    /// Angle that the torques cos(n theta) and sin(n theta), each of one unit of acceleration, make at these times.
    #[must_use]
    pub fn ripple(&self, order: usize, times: &[f64]) -> [Vec<f64>; 2] {
        let n = order as f64;
        let angle = |t: f64| n * (self.from_rad_s * t + 0.5 * self.rate * t * t);
        if self.rate == 0.0 {
            let (re, im) = self.shaft.response(n * self.from_rad_s);
            let pair = times.iter().map(|&t| {
                let (sin, cos) = angle(t).sin_cos();
                (re * cos - im * sin, re * sin + im * cos)
            });
            let (cos, sin) = pair.unzip();
            return [cos, sin];
        }
        // Settled at the start, then step by step; a step is at most half a cycle.
        let d = self.shaft.damping;
        let w = n * self.from_rad_s;
        let size = w * w + d * d;
        let mut speed = [d / size, -w / size];
        let mut at = [0.0; 2];
        let mut before = 0.0;
        let mut out = [
            Vec::with_capacity(times.len()),
            Vec::with_capacity(times.len()),
        ];
        for &time in times {
            let step = time - before;
            let whole = self.shaft.transition(step);
            let mut pushes = [[0.0; 2]; 2];
            for (node, weight) in GAUSS {
                let (sin, cos) = angle(before + node * step).sin_cos();
                let left = -d * (1.0 - node) * step;
                let (to_speed, to_angle) = (left.exp(), -left.exp_m1() / d);
                for (push, torque) in pushes.iter_mut().zip([cos, sin]) {
                    push[0] += weight * step * to_angle * torque;
                    push[1] += weight * step * to_speed * torque;
                }
            }
            for part in 0..2 {
                at[part] += whole.angle * speed[part] + pushes[part][0];
                speed[part] = whole.speed * speed[part] + pushes[part][1];
                out[part].push(at[part]);
            }
            before = time;
        }
        out
    }
}

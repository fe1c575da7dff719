//! A shaft that a spring pulls on and on, as an extended Kalman filter sees it edge by edge.
//!
//! J u'' = K (w t - u) - F_s exp(-(u' / v_s)^2) - b u' + J c with torque noise, u the way and t the time since the first edge, and c what
//! the spring's first stretch and Coulomb friction make together. Source:
//! A. H. Jazwinski, Stochastic Processes and Filtering Theory, 1970, section 8.3.

use super::slip::Wave;

/// What the law may have free: logarithms of spring, drop of friction and the speed over which it drops, push c, speed of the spring's
/// far end, logarithm of the damping, and how far ahead of the first edge it starts and how fast.
pub const NUMBERS: usize = 8;

/// Steps from edge to edge at the most: a law that needs more is none.
const STEPS_MOST: f64 = 20.0;

/// The law of a sliding shaft; torques over the inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlideLaw {
    /// Spring, 1/s^2.
    pub spring: f64,
    /// Drop of friction, rad/s^2.
    pub drop: f64,
    /// Speed over which it drops, rad/s.
    pub over_rad_s: f64,
    /// What pushes at the first edge, without friction that falls, rad/s^2.
    pub push: f64,
    /// Speed of the spring's far end, rad/s.
    pub pull_rad_s: f64,
    /// Damping, 1/s.
    pub damping: f64,
    /// Angle and speed at the first edge's time, rad and rad/s.
    pub start: [f64; 2],
}

/// Edges of a slide from its first.
#[derive(Clone, Debug)]
pub struct Slide {
    /// Times, s.
    pub times_s: Vec<f64>,
    /// True angles, rad, growing along the motion.
    pub ways: Vec<f64>,
    /// Torques locked to the shaft, with the phase at the first edge.
    pub waves: Vec<Wave>,
}

impl Slide {
    /// With fewer edges: all of the first ones, in which it breaks away, and every so many after them.
    #[must_use]
    pub fn thinned(&self, edges: usize) -> Self {
        let begins = edges / 4;
        let rest = self.ways.len().saturating_sub(begins);
        let each = rest.div_ceil(edges - begins).max(1);
        let kept = |row: &[f64]| {
            let (begin, rest) = row.split_at(begins.min(row.len()));
            let later = rest.iter().step_by(each);
            begin.iter().chain(later).copied().collect()
        };
        Self {
            times_s: kept(&self.times_s),
            ways: kept(&self.ways),
            waves: self.waves.clone(),
        }
    }
}

/// Noise of a slide.
#[derive(Clone, Copy, Debug)]
pub struct SlideNoise {
    /// Density of the acceleration noise, (rad/s^2)^2 s.
    pub acceleration: f64,
    /// RMS error of a stamp, s.
    pub stamp_s: f64,
    /// RMS error of an edge's angle, rad.
    pub angle_rad: f64,
}

impl SlideLaw {
    /// From its numbers.
    #[must_use]
    pub fn of(at: &[f64; NUMBERS]) -> Self {
        Self {
            spring: at[0].exp(),
            drop: at[1].exp(),
            over_rad_s: at[2].exp(),
            push: at[3],
            pull_rad_s: at[4],
            damping: at[5].exp(),
            start: [at[6], at[7]],
        }
    }

    /// Acceleration at a time, way and speed, and how it changes with way and speed.
    fn push(&self, waves: &[Wave], time_s: f64, [way, speed]: [f64; 2]) -> (f64, f64, f64) {
        let over = speed / self.over_rad_s;
        let held = self.drop * (-over * over).exp();
        let mut push = self.push + self.spring * (self.pull_rad_s * time_s - way)
            - held
            - self.damping * speed;
        let mut by_way = -self.spring;
        for wave in waves {
            let (sin, cos) = (wave.order * way + wave.phase_rad).sin_cos();
            push += wave.push * sin;
            by_way += wave.push * wave.order * cos;
        }
        let by_speed = 2.0 * held * over / self.over_rad_s - self.damping;
        (push, by_way, by_speed)
    }

    /// Angle and speed a while later, by the middle of the way, and what of them stays of angle and speed before.
    fn went(
        &self,
        waves: &[Wave],
        time_s: f64,
        state: [f64; 2],
        after_s: f64,
    ) -> ([f64; 2], [[f64; 2]; 2]) {
        let (first, ..) = self.push(waves, time_s, state);
        let half = [
            state[0] + 0.5 * after_s * (state[1] + 0.25 * after_s * first),
            state[1] + 0.5 * after_s * first,
        ];
        let (push, by_way, by_speed) = self.push(waves, time_s + 0.5 * after_s, half);
        let on = [
            state[0] + after_s * (state[1] + 0.5 * after_s * push),
            state[1] + after_s * push,
        ];
        let h = after_s;
        let stays = [
            [1.0 + 0.5 * h * h * by_way, h + 0.5 * h * h * by_speed],
            [
                h * by_way + 0.5 * h * h * by_speed * by_way,
                1.0 + h * by_speed + 0.5 * h * h * (by_way + by_speed * by_speed),
            ],
        ];
        (on, stays)
    }

    /// Innovations of a slide, white with this noise, and the sum of the logarithms of their variances; none where it is lost.
    #[must_use]
    pub fn white(&self, slide: &Slide, noise: SlideNoise) -> Option<(Vec<f64>, f64)> {
        // As fast as the law or the filter changes.
        let step_s = 0.1 / (self.spring.sqrt() + self.damping + self.drop / self.over_rad_s);
        let mut state = self.start;
        // Angle, angle with speed, speed.
        let mut spread = [0.0; 3];
        let mut now = slide.times_s[0];
        let mut white = Vec::with_capacity(slide.ways.len());
        let mut scale = 0.0;
        for (&time, &way) in slide.times_s.iter().zip(&slide.ways) {
            let steps = ((time - now) / step_s).ceil().clamp(1.0, STEPS_MOST);
            let h = (time - now) / steps;
            for i in 0..steps as usize {
                let (on, stays) = self.went(&slide.waves, now + h * i as f64, state, h);
                state = on;
                spread = spreads(spread, stays, noise.acceleration, h);
            }
            now = time;
            let stamp = noise.stamp_s * state[1];
            let own = stamp * stamp + noise.angle_rad * noise.angle_rad + 1e-24;
            let variance = spread[0] + own;
            let off = way - state[0];
            let gain = [spread[0] / variance, spread[1] / variance];
            state = [state[0] + gain[0] * off, state[1] + gain[1] * off];
            spread = [
                spread[0] * own / variance,
                spread[1] * own / variance,
                spread[2] - gain[1] * spread[1],
            ];
            white.push(off / variance.sqrt());
            scale += variance.ln();
        }
        let there = state.iter().all(|value| value.is_finite()) && scale.is_finite();
        there.then_some((white, scale))
    }
}

/// Covariance after a step.
fn spreads(
    [aa, av, vv]: [f64; 3],
    [[a, b], [c, d]]: [[f64; 2]; 2],
    noise: f64,
    h: f64,
) -> [f64; 3] {
    [
        a * a * aa + 2.0 * a * b * av + b * b * vv + noise * h * h * h / 3.0,
        a * c * aa + (a * d + b * c) * av + b * d * vv + noise * h * h / 2.0,
        c * c * aa + 2.0 * c * d * av + d * d * vv + noise * h,
    ]
}

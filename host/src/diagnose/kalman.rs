//! The noise of a turning shaft, and what is left of a residual once it is taken out.
//!
//! The shaft's speed forgets at a rate and is pushed by white torque, its mean speed drifts slowly, and every time stamp has an
//! error of its own. In angle (rad) and speed (rad/s), from edge to edge: dv = -b v dt + white(q), dy = (v + m) dt,
//! dm = white(d), and a residual shows y + w j with w the speed and j the stamp's error. The innovations of the Kalman filter
//! are white and of known variance, whatever the speed does and wherever edges are missing; a pattern that goes through the same
//! filter can be held against them by plain least squares.

/// Size of the noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShaftNoise {
    /// Rate at which the speed forgets, 1/s.
    pub forgets_per_s: f64,
    /// Density of the acceleration noise, (rad/s^2)^2 s.
    pub acceleration: f64,
    /// Density of the mean speed's drift, (rad/s)^2/s.
    pub drift: f64,
    /// RMS error of a time stamp, s.
    pub stamp_s: f64,
}

/// One edge as the filter sees it.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// Time since the edge before, s.
    pub after_s: f64,
    /// Speed here, rad/s.
    pub speed: f64,
}

/// The filter's gains along a row of edges, which depend on times only: so one run serves every pattern.
#[derive(Clone, Debug)]
pub struct Whitener {
    steps: Vec<Gain>,
}

#[derive(Clone, Copy, Debug)]
struct Gain {
    /// From speed to angle, and how much of the speed stays.
    reach: f64,
    stays: f64,
    after_s: f64,
    gain: [f64; 3],
    /// 1 / standard deviation of the innovation.
    scale: f64,
}

type Square = [[f64; 3]; 3];

impl Whitener {
    /// For these edges; the first ones only set the filter.
    #[must_use]
    pub fn new(readings: &[Reading], noise: ShaftNoise) -> Self {
        // The first angle and both speeds are not known.
        let speed = readings.first().map_or(1.0, |reading| reading.speed.abs());
        let mut p: Square = [
            [1e6, 0.0, 0.0],
            [0.0, noise.acceleration / (2.0 * noise.forgets_per_s), 0.0],
            [0.0, 0.0, speed * speed],
        ];
        let steps = readings
            .iter()
            .map(|reading| {
                let gain = transition(*reading, noise);
                p = predicted(&p, gain, *reading, noise);
                let stamp = noise.stamp_s * reading.speed;
                let variance = p[0][0] + stamp * stamp;
                let k = [p[0][0] / variance, p[1][0] / variance, p[2][0] / variance];
                for i in 0..3 {
                    for j in 0..=i {
                        p[i][j] -= k[i] * k[j] * variance;
                        p[j][i] = p[i][j];
                    }
                }
                Gain {
                    gain: k,
                    scale: variance.sqrt().recip(),
                    ..gain
                }
            })
            .collect();
        Self { steps }
    }

    /// Whitens a row of angles, one an edge, in place: what comes out has unit variance if it is this noise. The first three set
    /// the filter and come out as zero.
    pub fn whiten(&self, angles: &mut [f64]) {
        let mut state = [0.0; 3];
        for (at, (angle, step)) in angles.iter_mut().zip(&self.steps).enumerate() {
            state = [
                state[0] + step.reach * state[1] + step.after_s * state[2],
                step.stays * state[1],
                state[2],
            ];
            let innovation = *angle - state[0];
            for (value, gain) in state.iter_mut().zip(step.gain) {
                *value += gain * innovation;
            }
            *angle = if at < SETTLES {
                0.0
            } else {
                innovation * step.scale
            };
        }
    }

    /// Sum of the logarithms of the innovations' variances.
    #[must_use]
    pub fn log_variance(&self) -> f64 {
        let logs = self.steps.iter().skip(SETTLES).map(|step| step.scale.ln());
        -2.0 * logs.sum::<f64>()
    }
}

/// Edges that set the filter.
pub const SETTLES: usize = 3;

fn transition(reading: Reading, noise: ShaftNoise) -> Gain {
    let forgotten = -noise.forgets_per_s * reading.after_s;
    let stays = forgotten.exp();
    Gain {
        reach: -forgotten.exp_m1() / noise.forgets_per_s,
        stays,
        after_s: reading.after_s,
        gain: [0.0; 3],
        scale: 0.0,
    }
}

/// Covariance at the next edge.
fn predicted(p: &Square, step: Gain, reading: Reading, noise: ShaftNoise) -> Square {
    let f: Square = [
        [1.0, step.reach, step.after_s],
        [0.0, step.stays, 0.0],
        [0.0, 0.0, 1.0],
    ];
    let mut out = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            for (k, row) in p.iter().enumerate() {
                for (l, cell) in row.iter().enumerate() {
                    out[i][j] += f[i][k] * cell * f[j][l];
                }
            }
        }
    }
    // Edges are dense against the forgetting, so the noise of a step is that of free motion, damped half way.
    let (t, half) = (
        reading.after_s,
        (-0.5 * noise.forgets_per_s * reading.after_s).exp(),
    );
    let q = noise.acceleration * half * half;
    out[0][0] += q * t * t * t / 3.0 + noise.drift * t * t * t / 3.0;
    out[0][1] += q * t * t / 2.0;
    out[1][0] += q * t * t / 2.0;
    out[1][1] += q * t;
    out[0][2] += noise.drift * t * t / 2.0;
    out[2][0] += noise.drift * t * t / 2.0;
    out[2][2] += noise.drift * t;
    out
}

/// The noise that makes a residual most likely; `readings` and `angles` may be a part of a recording.
#[must_use]
pub fn fit(readings: &[Reading], angles: &[f64], tick_s: f64, start: ShaftNoise) -> ShaftNoise {
    let of = |logs: &[f64; 4]| ShaftNoise {
        forgets_per_s: logs[0].exp(),
        acceleration: logs[1].exp(),
        drift: logs[2].exp(),
        // A tick is uniform: its RMS error is what no stamp is below.
        stamp_s: (logs[3].exp().powi(2) + tick_s * tick_s / 12.0).sqrt(),
    };
    let cost = |logs: &[f64; 4]| {
        let whitener = Whitener::new(readings, of(logs));
        let mut white = angles.to_vec();
        whitener.whiten(&mut white);
        // Innovations far out are events, not noise: they count as if they were at four standard deviations.
        let squares: f64 = white.iter().map(|w| robust(*w)).sum();
        squares + whitener.log_variance()
    };
    let first = [
        start.forgets_per_s.ln(),
        start.acceleration.ln(),
        start.drift.ln(),
        start.stamp_s.ln(),
    ];
    of(&simplex(cost, first, 1.0))
}

fn robust(white: f64) -> f64 {
    const FAR: f64 = 4.0;
    let size = white.abs();
    if size < FAR {
        size * size
    } else {
        FAR * (2.0 * size - FAR)
    }
}

/// Lowest place of a smooth cost: Nelder and Mead's simplex (Computer Journal 7, 1965).
fn simplex<const D: usize>(
    cost: impl Fn(&[f64; D]) -> f64,
    start: [f64; D],
    step: f64,
) -> [f64; D] {
    let mut corners: Vec<([f64; D], f64)> = (0..=D)
        .map(|corner| {
            let mut at = start;
            if corner > 0 {
                at[corner - 1] += step;
            }
            (at, cost(&at))
        })
        .collect();
    for _ in 0..60 * D {
        corners.sort_by(|a, b| a.1.total_cmp(&b.1));
        if corners[D].1 - corners[0].1 < 0.05 {
            break;
        }
        let worst = corners[D];
        let middle: [f64; D] = std::array::from_fn(|i| {
            corners[..D].iter().map(|corner| corner.0[i]).sum::<f64>() / D as f64
        });
        let along = |share: f64| -> ([f64; D], f64) {
            let at = std::array::from_fn(|i| middle[i] + share * (worst.0[i] - middle[i]));
            (at, cost(&at))
        };
        let reflected = along(-1.0);
        let better = if reflected.1 < corners[0].1 {
            let further = along(-2.0);
            if further.1 < reflected.1 {
                further
            } else {
                reflected
            }
        } else if reflected.1 < corners[D - 1].1 {
            reflected
        } else {
            let nearer = along(if reflected.1 < worst.1 { -0.5 } else { 0.5 });
            if nearer.1 < worst.1.min(reflected.1) {
                nearer
            } else {
                let best = corners[0].0;
                for corner in &mut corners[1..] {
                    corner.0 = std::array::from_fn(|i| 0.5 * (best[i] + corner.0[i]));
                    corner.1 = cost(&corner.0);
                }
                continue;
            }
        };
        corners[D] = better;
    }
    corners.sort_by(|a, b| a.1.total_cmp(&b.1));
    corners[0].0
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    const TICK_S: f64 = 1e-9;

    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        let (a, b): (f64, f64) = (rng.random(), rng.random());
        (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }

    /// A shaft made step by step, and its stamps.
    fn shaft(noise: ShaftNoise, edges: usize, seed: u64) -> (Vec<Reading>, Vec<f64>) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let reading = Reading {
            after_s: 2e-4,
            speed: 3.0,
        };
        let fine = 8;
        let dt = reading.after_s / f64::from(fine);
        let (mut y, mut v, mut m) = (0.0, 0.0, 0.01);
        let angles = (0..edges)
            .map(|_| {
                for _ in 0..fine {
                    y += (v + m) * dt;
                    v += -noise.forgets_per_s * v * dt
                        + (noise.acceleration * dt).sqrt() * normal(&mut rng);
                    m += (noise.drift * dt).sqrt() * normal(&mut rng);
                }
                y + noise.stamp_s * reading.speed * normal(&mut rng)
            })
            .collect();
        (vec![reading; edges], angles)
    }

    const NOISE: ShaftNoise = ShaftNoise {
        forgets_per_s: 6.0,
        acceleration: 1e-4,
        drift: 1e-8,
        stamp_s: 2e-6,
    };

    #[test]
    fn innovations_of_the_true_noise_are_white_and_of_unit_variance() {
        let (readings, mut white) = shaft(NOISE, 40_000, 1);
        Whitener::new(&readings, NOISE).whiten(&mut white);
        let white = &white[SETTLES..];
        let n = white.len() as f64;
        let variance = white.iter().map(|w| w * w).sum::<f64>() / n;
        assert!(
            (variance - 1.0).abs() < 4.0 * (2.0 / n).sqrt(),
            "{variance}"
        );
        for lag in [1, 2, 5, 50, 1000] {
            let both = white.iter().zip(&white[lag..]);
            let correlation = both.map(|(a, b)| a * b).sum::<f64>() / n;
            assert!(correlation.abs() < 4.0 / n.sqrt(), "{lag}: {correlation}");
        }
    }

    #[test]
    fn the_noise_is_found_from_far_off() {
        let (readings, angles) = shaft(NOISE, 30_000, 2);
        let start = ShaftNoise {
            forgets_per_s: 1.0,
            acceleration: 1e-2,
            drift: 1e-6,
            stamp_s: 1e-7,
        };
        let found = fit(&readings, &angles, TICK_S, start);
        assert!(
            (found.acceleration / NOISE.acceleration).ln().abs() < 0.1,
            "{found:?}"
        );
        assert!(
            (found.stamp_s / NOISE.stamp_s).ln().abs() < 0.05,
            "{found:?}"
        );
        assert!(
            (found.forgets_per_s / NOISE.forgets_per_s).ln().abs() < 0.7,
            "{found:?}"
        );
    }
}

//! The true noise of edge angles as a state space, and the filter that makes it white.
//!
//! The speed wanders as dv = -d v dt + s x dt + dW with density q, the angle x is its integral, and every edge adds a white angle
//! error of its own; s is the slope of a torque that hangs on the angle. A Kalman filter with a diffuse start turns the angles of the edges into innovations; divided by their standard
//! deviation they are white with variance 1. The filter is linear in the angles, so it whitens a signal as it whitens noise.

/// Noise of one recording.
#[derive(Clone, Debug)]
pub struct Whitener {
    steps: Vec<Update>,
}

#[derive(Clone, Copy, Debug)]
struct Update {
    /// What angle and speed at the edge before make of angle and speed at this one.
    step: [[f64; 2]; 2],
    gain: [f64; 2],
    /// Standard deviation of the innovation, rad.
    deviation: f64,
}

/// Noise up to one edge.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// Time since the edge before, s.
    pub since_s: f64,
    /// Damping of the speed, 1/s.
    pub damping: f64,
    /// Change of the acceleration with the angle, 1/s^2: negative where a torque holds the shaft as a spring does.
    pub slope: f64,
    /// Variance of the edge's own angle error, rad^2.
    pub own_rad2: f64,
}

impl Whitener {
    /// The filter for edges, with a density of the acceleration in (rad/s^2)^2 s.
    #[must_use]
    pub fn new(edges: &[Edge], density: f64) -> Self {
        // The start is diffuse: as large as any angle and speed may be.
        let (mut angle, mut cross, mut speed) = (1e2, 0.0, 1e6);
        let steps = edges
            .iter()
            .map(|edge| {
                let (step, grown) = between(edge, density);
                let [[aa, av], [va, vv]] = step;
                let a = aa * aa * angle + 2.0 * aa * av * cross + av * av * speed + grown[0];
                let c = va * (aa * angle + av * cross) + vv * (aa * cross + av * speed) + grown[1];
                let s = va * va * angle + 2.0 * va * vv * cross + vv * vv * speed + grown[2];
                let total = a + edge.own_rad2;
                let gain = [a / total, c / total];
                angle = a * (edge.own_rad2 / total);
                cross = c * (edge.own_rad2 / total);
                speed = s - c * gain[1];
                Update {
                    step,
                    gain,
                    deviation: total.sqrt(),
                }
            })
            .collect();
        Self { steps }
    }

    /// The signal as white noise sees it.
    #[must_use]
    pub fn apply(&self, signal: &[f64]) -> Vec<f64> {
        let (mut angle, mut speed) = (0.0, 0.0);
        let each = self.steps.iter().zip(signal).map(|(step, value)| {
            let [[aa, av], [va, vv]] = step.step;
            let expected = aa * angle + av * speed;
            let innovation = value - expected;
            speed = va * angle + vv * speed + step.gain[1] * innovation;
            angle = expected + step.gain[0] * innovation;
            innovation / step.deviation
        });
        each.collect()
    }

    /// The transposed filter, for normal equations.
    #[must_use]
    pub fn transposed(&self, white: &[f64]) -> Vec<f64> {
        let (mut angle, mut speed) = (0.0, 0.0);
        let mut signal = vec![0.0; white.len()];
        for (at, step) in self.steps.iter().enumerate().rev() {
            let innovation =
                white[at] / step.deviation + step.gain[0] * angle + step.gain[1] * speed;
            signal[at] = innovation;
            let expected = angle - innovation;
            let [[aa, av], [va, vv]] = step.step;
            (angle, speed) = (aa * expected + va * speed, vv * speed + av * expected);
        }
        signal
    }

    /// Standard deviations of the innovations, rad.
    pub fn deviations(&self) -> impl Iterator<Item = f64> + '_ {
        self.steps.iter().map(|step| step.deviation)
    }
}

/// What the time until an edge makes of angle and speed, and what the noise adds.
fn between(edge: &Edge, density: f64) -> ([[f64; 2]; 2], [f64; 3]) {
    let (damping, slope) = (edge.damping, edge.slope);
    if slope == 0.0 {
        let h = edge.since_s;
        let x = damping * h;
        let (reach, decay) = if x < 1e-3 {
            (h * (1.0 - 0.5 * x), 1.0 - x + 0.5 * x * x)
        } else {
            (-libm::expm1(-x) / damping, libm::exp(-x))
        };
        return ([[1.0, reach], [0.0, decay]], grown(density, damping, h));
    }
    // A series over a part of the time that is short, doubled until it is whole.
    let quick = edge.since_s * (damping + slope.abs().sqrt());
    let doublings = (quick / 1e-3).log2().ceil().clamp(0.0, 60.0);
    let h = edge.since_s * (-doublings).exp2();
    let (x, y) = (damping * h, slope * h * h);
    let bend = 1.0 - 0.5 * x + (x * x + y) / 6.0;
    let mut step = [
        [1.0 + 0.5 * y * (1.0 - x / 3.0), h * bend],
        [slope * h * bend, 1.0 - x + 0.5 * (x * x + y)],
    ];
    let mut sum = grown(density, damping, h);
    for _ in 0..doublings as u32 {
        let [[aa, av], [va, vv]] = step;
        let [a, c, s] = sum;
        sum = [
            a + aa * aa * a + 2.0 * aa * av * c + av * av * s,
            c + va * (aa * a + av * c) + vv * (aa * c + av * s),
            s + va * va * a + 2.0 * va * vv * c + vv * vv * s,
        ];
        step = [
            [aa * aa + av * va, aa * av + av * vv],
            [va * aa + vv * va, va * av + vv * vv],
        ];
    }
    (step, sum)
}

/// What the noise adds over a time: variance of the angle, covariance, variance of the speed.
fn grown(density: f64, damping: f64, h: f64) -> [f64; 3] {
    let x = damping * h;
    if x < 1e-2 {
        // The closed form cancels; three terms of its series do not.
        return [
            density * h * h * h / 3.0 * (1.0 - 0.75 * x + 0.35 * x * x),
            density * h * h / 2.0 * (1.0 - x + 7.0 / 12.0 * x * x),
            density * h * (1.0 - x + 2.0 / 3.0 * x * x),
        ];
    }
    let once = -libm::expm1(-x);
    let twice = -libm::expm1(-2.0 * x);
    let d = damping;
    [
        density / (d * d) * (h - 2.0 * once / d + twice / (2.0 * d)),
        density * once * once / (2.0 * d * d),
        density * twice / (2.0 * d),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Dice;

    fn edges(count: usize) -> Vec<Edge> {
        let edge = |k: usize| Edge {
            since_s: 1e-3 * (1.0 + 0.3 * (k as f64 * 0.1).sin()),
            damping: 3.0,
            slope: 0.0,
            own_rad2: 1e-10,
        };
        (0..count).map(edge).collect()
    }

    #[test]
    fn noise_of_the_model_comes_out_white_with_variance_one() {
        for slope in [0.0, -1e4] {
            let (mut edges, density) = (edges(40_000), 1e-4);
            edges.iter_mut().for_each(|edge| edge.slope = slope);
            let mut dice = Dice::new(5, 0);
            let (mut angle, mut speed) = (0.0, 0.0);
            let fine = 20;
            let seen: Vec<f64> = edges
                .iter()
                .map(|edge| {
                    let h = edge.since_s / f64::from(fine);
                    for _ in 0..fine {
                        let pull = slope * angle - edge.damping * speed;
                        speed += pull * h + (density * h).sqrt() * dice.normal();
                        angle += speed * h;
                    }
                    angle + edge.own_rad2.sqrt() * dice.normal()
                })
                .collect();
            let white = Whitener::new(&edges, density).apply(&seen);
            let white = &white[100..];
            let count = white.len() as f64;
            let variance = white.iter().map(|w| w * w).sum::<f64>() / count;
            let next = white.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / count;
            // Three and a half standard errors of a variance of 40,000 values.
            assert!((variance - 1.0).abs() < 0.025, "{slope}: {variance}");
            assert!(next.abs() < 0.0175, "{slope}: {next}");
        }
    }

    #[test]
    fn a_torque_that_hangs_on_the_angle_holds_as_a_spring_or_throws_over() {
        let (h, density) = (0.02, 2.0);
        let over = |slope: f64| {
            let edge = Edge {
                since_s: h,
                damping: 0.0,
                slope,
                own_rad2: 1e-10,
            };
            between(&edge, density)
        };
        let w = 80.0_f64;
        let (swing, held) = over(-w * w);
        let (thrown, fled) = over(w * w);
        let x = w * h;
        // The last is the integral of the square of the answer to a push: 1/2 q (h -+ sin(2 w h) / (2 w)) / w^2.
        for (found, expected) in [
            (swing[0][0], x.cos()),
            (swing[0][1], x.sin() / w),
            (swing[1][0], -x.sin() * w),
            (swing[1][1], x.cos()),
            (thrown[0][0], x.cosh()),
            (thrown[1][0], x.sinh() * w),
            (
                held[0],
                0.5 * density * (h - (2.0 * x).sin() / (2.0 * w)) / (w * w),
            ),
            (
                fled[0],
                0.5 * density * ((2.0 * x).sinh() / (2.0 * w) - h) / (w * w),
            ),
            (fled[1], 0.5 * density * (x.sinh() / w).powi(2)),
            (held[2], 0.5 * density * (h + (2.0 * x).sin() / (2.0 * w))),
        ] {
            assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
        }
    }

    #[test]
    fn transposed_is_the_transpose() {
        let mut edges = edges(300);
        edges[150].slope = -3e5;
        let whitener = Whitener::new(&edges, 1e-4);
        let mut dice = Dice::new(6, 0);
        let mut draw = || (0..300).map(|_| dice.normal()).collect::<Vec<f64>>();
        let (x, y) = (draw(), draw());
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (left, right) = (
            dot(&whitener.apply(&x), &y),
            dot(&x, &whitener.transposed(&y)),
        );
        assert!((left - right).abs() < 1e-8 * left.abs(), "{left} {right}");
    }

    #[test]
    fn closed_form_and_series_of_the_growth_meet() {
        let (above, below) = (
            grown(2.0, 3.0, 0.0100001 / 3.0),
            grown(2.0, 3.0, 0.0099999 / 3.0),
        );
        for (a, b) in above.iter().zip(below) {
            assert!((a / b - 1.0).abs() < 1e-4, "{a} {b}");
        }
    }
}

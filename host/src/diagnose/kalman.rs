//! The filter that makes the noise of a turning shaft white.
//!
//! Torque noise pushes the shaft (see [`super::shaft`]), its mean speed may drift, and every time stamp has an error of its own:
//! dy = (v + m) dt, dv = -b v dt + white(q), dm = white(d), and an edge shows y + w j with w the speed and j the stamp's
//! error. The innovations of the Kalman filter are white and of known variance, whatever the speed does and wherever edges are
//! missing; a pattern that goes through the same filter can be held against them by plain least squares.

use super::hold::Way;
use super::shaft::Leap;

/// Size of the noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShaftNoise {
    /// Density of the acceleration noise, (rad/s^2)^2 s.
    pub acceleration: f64,
    /// RMS error of a time stamp, s.
    pub stamp_s: f64,
    /// Density of the mean speed's drift, (rad/s)^2/s; 0 where the twin says what holds the speed.
    pub drift: f64,
    /// Damping on top of the twin's, 1/s: what a twin does not say.
    pub forgets_per_s: f64,
    /// Time for which a torque is held, on a grid from time 0, s; 0 where it is white. Where it is held, nothing drifts.
    pub hold_s: f64,
}

/// One edge as the filter sees it.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// From the edge before.
    pub leap: Leap,
    /// Speed here, rad/s, either way.
    pub speed: f64,
    /// When it came, s.
    pub at_s: f64,
    /// Whether the angle does not go on from the edge before: the count was disturbed.
    pub fresh: bool,
    /// Whether nothing is known of angle and speed: edges before it were left out.
    pub anew: bool,
    /// Variance of a jolt of the speed that nobody knows, (rad/s)^2.
    pub jolt: f64,
    /// RMS error of the stamp on top of the noise, s, where it is known to say little.
    pub doubt_s: f64,
}

/// The filter's gains along a row of edges, which depend on times only: so one run serves every pattern.
#[derive(Clone, Debug, Default)]
pub struct Whitener {
    steps: Vec<Gain>,
}

#[derive(Clone, Copy, Debug)]
struct Gain {
    way: Way,
    gain: [f64; 3],
    /// 1 / standard deviation of the innovation; 0 where the edge only sets the filter.
    scale: f64,
    /// Whether the angle starts anew.
    fresh: bool,
    /// Whether all does.
    anew: bool,
}

/// Edges after a fresh start that only set the filter.
pub const SETTLES: usize = 2;

impl Whitener {
    /// For these edges.
    #[must_use]
    pub fn new(readings: &[Reading], noise: ShaftNoise) -> Self {
        let speed = readings.iter().map(|r| r.speed).fold(0.0, f64::max);
        let unknown_speed = 0.01 * speed * speed;
        // Upper triangle of the covariance: yy, yv, ym, vv, vm, mm.
        let mut start = [1e2, 0.0, 0.0, unknown_speed, 0.0, 0.0];
        if noise.hold_s > 0.0 {
            start[5] = noise.acceleration / noise.hold_s;
        } else if noise.drift > 0.0 {
            start[5] = unknown_speed;
        }
        let mut p = start;
        let mut settling = 0;
        let steps = readings
            .iter()
            .enumerate()
            .map(|(at, reading)| {
                let leap = Leap {
                    damping: reading.leap.damping + noise.forgets_per_s,
                    ..reading.leap
                };
                let (way, spread) = Way::of(leap, reading.at_s, noise, p);
                if at == 0 || reading.anew {
                    p = start;
                    if at > 0 {
                        // A shaft that was held goes at any speed.
                        p[3] = speed * speed;
                    }
                    settling = SETTLES;
                } else if reading.fresh {
                    (p[0], p[1], p[2]) = (1e2, 0.0, 0.0);
                    settling = 1;
                } else {
                    p = spread;
                    p[3] += reading.jolt;
                    p[1] += reading.jolt * way.reach;
                    p[0] += reading.jolt * way.reach * way.reach;
                }
                let stamp = noise.stamp_s * reading.speed;
                let doubt = reading.doubt_s * reading.speed;
                let own = stamp * stamp + doubt * doubt + 1e-30;
                let variance = p[0] + own;
                let inverse = 1.0 / variance;
                let gain = [p[0] * inverse, p[1] * inverse, p[2] * inverse];
                p = [
                    p[0] * own * inverse,
                    p[1] * own * inverse,
                    p[2] * own * inverse,
                    p[3] - gain[1] * p[1],
                    p[4] - gain[1] * p[2],
                    p[5] - gain[2] * p[2],
                ];
                let scale = if settling > 0 {
                    settling -= 1;
                    0.0
                } else {
                    inverse.sqrt()
                };
                Gain {
                    way,
                    gain,
                    scale,
                    fresh: reading.fresh,
                    anew: at == 0 || reading.anew,
                }
            })
            .collect();
        Self { steps }
    }

    /// Whitens a row of angles, one an edge, in place: what comes out has unit variance if it is this noise; edges that only set
    /// the filter come out as zero.
    pub fn whiten(&self, angles: &mut [f64]) {
        self.whiten_from(0, angles);
    }

    /// Whitens a row of angles that begins at an edge, nothing before, in place.
    pub fn whiten_from(&self, first: usize, angles: &mut [f64]) {
        let mut state = [0.0; 3];
        for (angle, step) in angles.iter_mut().zip(&self.steps[first..]) {
            *angle = step.white(&mut state, *angle);
        }
    }

    /// Whitens two rows, one an edge, in place: together they take hardly longer than one.
    pub fn whiten_both(&self, one: &mut [f64], other: &mut [f64]) {
        let (mut first, mut second) = ([0.0; 3], [0.0; 3]);
        for ((one, other), step) in one.iter_mut().zip(other).zip(&self.steps) {
            *one = step.white(&mut first, *one);
            *other = step.white(&mut second, *other);
        }
    }

    /// The transposed filter, in place, for normal equations.
    pub fn transposed(&self, white: &mut [f64]) {
        let [mut y, mut v, mut m] = [0.0; 3];
        for (value, step) in white.iter_mut().zip(&self.steps).rev() {
            let innovation =
                *value * step.scale + step.gain[0] * y + step.gain[1] * v + step.gain[2] * m;
            *value = innovation;
            if step.anew {
                (y, v, m) = (0.0, 0.0, 0.0);
                continue;
            }
            let expected = if step.fresh { 0.0 } else { y - innovation };
            (y, v, m) = step.way.back(expected, v, m);
        }
    }

    /// Undoes [`Self::whiten`], in place: angles that give these numbers, less where the shaft began and how fast, which are lost.
    pub fn restore(&self, white: &mut [f64]) {
        let [mut y, mut v, mut m] = [0.0; 3];
        for (value, step) in white.iter_mut().zip(&self.steps) {
            (y, v, m) = step.way.on(y, v, m);
            if step.anew {
                (y, v, m) = (0.0, 0.0, 0.0);
            } else if step.fresh {
                y = 0.0;
            }
            let innovation = if step.scale > 0.0 {
                *value / step.scale
            } else {
                0.0
            };
            *value = y + innovation;
            y += step.gain[0] * innovation;
            v += step.gain[1] * innovation;
            m += step.gain[2] * innovation;
        }
    }

    /// Diagonal of the inverse of the angles' covariance, 1/rad^2: how well each angle is known from all others and itself. An
    /// angle less what the others let expect is its entry of the filter, transposed and plain, applied to all, over this.
    #[must_use]
    pub fn precisions(&self) -> Vec<f64> {
        // Upper triangle of the covariance of the transposed filter's state: yy, yv, ym, vv, vm, mm.
        let mut n = [0.0; 6];
        let mut precisions: Vec<f64> = self
            .steps
            .iter()
            .rev()
            .map(|step| narrower(&mut n, step))
            .collect();
        precisions.reverse();
        precisions
    }

    /// Standard deviation of the innovation of every edge, rad; none where it only sets the filter.
    pub fn deviations(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        let each = self.steps.iter();
        each.map(|step| (step.scale > 0.0).then(|| step.scale.recip()))
    }

    /// Sum of the logarithms of the innovations' variances.
    #[must_use]
    pub fn log_variance(&self) -> f64 {
        let there = self.steps.iter().filter(|step| step.scale > 0.0);
        -2.0 * there.map(|step| step.scale.ln()).sum::<f64>()
    }
}

impl Gain {
    /// Takes an angle into a state of angle, speed and third; the innovation, white.
    #[inline(always)]
    fn white(&self, state: &mut [f64; 3], angle: f64) -> f64 {
        let [y, v, m] = *state;
        let (mut y, mut v, mut m) = self.way.on(y, v, m);
        if self.anew {
            (y, v, m) = (0.0, 0.0, 0.0);
        } else if self.fresh {
            y = 0.0;
        }
        let innovation = angle - y;
        *state = [
            y + self.gain[0] * innovation,
            v + self.gain[1] * innovation,
            m + self.gain[2] * innovation,
        ];
        innovation * self.scale
    }
}

/// Precision of an angle, and the transposed filter's covariance one edge before: de Jong's recursion (Biometrika 76, 1989).
fn narrower(n: &mut [f64; 6], step: &Gain) -> f64 {
    let [yy, yv, ym, vv, vm, mm] = *n;
    let [g, h, k] = step.gain;
    let s2 = step.scale * step.scale;
    let (ny, nv, nm) = (
        yy * g + yv * h + ym * k,
        yv * g + vv * h + vm * k,
        ym * g + vm * h + mm * k,
    );
    let precision = s2 + g * ny + h * nv + k * nm;
    if step.anew {
        *n = [0.0; 6];
        return precision;
    }
    // What the angle says itself is taken off the angle's part.
    let (mut yy, mut yv, mut ym) = (yy - 2.0 * ny + precision, yv - nv, ym - nm);
    if step.fresh {
        (yy, yv, ym) = (0.0, 0.0, 0.0);
    }
    let Way {
        reach: b,
        stays: d,
        angle: c,
        speed: e,
        keeps: k,
    } = step.way;
    let (cy, cv, cm) = (
        c * yy + e * yv + k * ym,
        c * yv + e * vv + k * vm,
        c * ym + e * vm + k * mm,
    );
    *n = [
        yy,
        b * yy + d * yv,
        cy,
        b * b * yy + 2.0 * b * d * yv + d * d * vv,
        b * cy + d * cv,
        c * cy + e * cv + k * cm,
    ];
    precision
}

//! The filter of a shaft whose state has so many numbers.

use super::hold::{ANGLE, Covariance, SPEED, THIRD, Way, way};
use super::kalman::{Reading, SETTLES, ShaftNoise};
use super::shaft::Leap;

/// Its gains along a row of edges.
#[derive(Clone, Debug)]
pub struct Filter<W, const N: usize> {
    steps: Vec<Gain<W, N>>,
}

impl<W, const N: usize> Default for Filter<W, N> {
    fn default() -> Self {
        Self { steps: Vec::new() }
    }
}

#[derive(Clone, Copy, Debug)]
struct Gain<W, const N: usize> {
    way: W,
    gain: [f64; N],
    /// 1 / standard deviation of the innovation; 0 where the edge only sets the filter.
    scale: f64,
    /// Whether the angle starts anew.
    fresh: bool,
    /// Whether all does.
    anew: bool,
}

impl<W: Way<N>, const N: usize> Filter<W, N> {
    /// For these edges.
    #[must_use]
    pub fn new(readings: &[Reading], noise: ShaftNoise) -> Self {
        let speed = readings.iter().map(|r| r.speed).fold(0.0, f64::max);
        let unknown_speed = 0.01 * speed * speed;
        let mut start = [[0.0; N]; N];
        start[ANGLE][ANGLE] = 1e2;
        start[SPEED][SPEED] = unknown_speed;
        if noise.hold_s > 0.0 {
            start[THIRD][THIRD] = noise.acceleration / noise.hold_s;
        } else if noise.drift > 0.0 {
            start[THIRD][THIRD] = unknown_speed;
        }
        if let Some(first) = readings.first() {
            W::begin(&mut start, first.leap, unknown_speed);
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
                let (way, spread) = way::<W, N>(leap, reading.at_s, noise, &p);
                if at == 0 || reading.anew {
                    p = start;
                    if at > 0 {
                        // A shaft that was held goes at any speed.
                        p[SPEED][SPEED] = speed * speed;
                    }
                    settling = SETTLES;
                } else if reading.fresh {
                    p[ANGLE] = [0.0; N];
                    p.iter_mut().for_each(|row| row[ANGLE] = 0.0);
                    p[ANGLE][ANGLE] = 1e2;
                    settling = 1;
                } else {
                    p = spread;
                    let reach = way.reach();
                    p[SPEED][SPEED] += reading.jolt;
                    p[ANGLE][SPEED] += reading.jolt * reach;
                    p[SPEED][ANGLE] = p[ANGLE][SPEED];
                    p[ANGLE][ANGLE] += reading.jolt * reach * reach;
                }
                let stamp = noise.stamp_s * reading.speed;
                let doubt = reading.doubt_s * reading.speed;
                let own = stamp * stamp + doubt * doubt + 1e-30;
                let inverse = 1.0 / (p[ANGLE][ANGLE] + own);
                let gain = p[ANGLE].map(|of| of * inverse);
                p = narrowed(&p, &gain, own);
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

    /// Whitens a row of angles that begins at an edge, nothing before, in place.
    pub fn whiten_from(&self, first: usize, angles: &mut [f64]) {
        let mut state = [0.0; N];
        for (angle, step) in angles.iter_mut().zip(&self.steps[first..]) {
            *angle = step.white(&mut state, *angle);
        }
    }

    /// Whitens two rows, one an edge, in place.
    pub fn whiten_both(&self, one: &mut [f64], other: &mut [f64]) {
        let (mut first, mut second) = ([0.0; N], [0.0; N]);
        for ((one, other), step) in one.iter_mut().zip(other).zip(&self.steps) {
            *one = step.white(&mut first, *one);
            *other = step.white(&mut second, *other);
        }
    }

    /// The transposed filter, in place.
    pub fn transposed(&self, white: &mut [f64]) {
        let mut state = [0.0; N];
        for (value, step) in white.iter_mut().zip(&self.steps).rev() {
            let taken = step.gain.iter().zip(&state);
            let innovation = *value * step.scale + taken.map(|(g, x)| g * x).sum::<f64>();
            *value = innovation;
            if step.anew {
                state = [0.0; N];
                continue;
            }
            state[ANGLE] = if step.fresh {
                0.0
            } else {
                state[ANGLE] - innovation
            };
            state = step.way.back(state);
        }
    }

    /// Undoes the filter, in place.
    pub fn restore(&self, white: &mut [f64]) {
        let mut state = [0.0; N];
        for (value, step) in white.iter_mut().zip(&self.steps) {
            state = step.begins(step.way.on(state));
            let innovation = if step.scale > 0.0 {
                *value / step.scale
            } else {
                0.0
            };
            *value = state[ANGLE] + innovation;
            step.take(&mut state, innovation);
        }
    }

    /// Diagonal of the inverse of the angles' covariance, 1/rad^2.
    #[must_use]
    pub fn precisions(&self) -> Vec<f64> {
        // Covariance of the transposed filter's state.
        let mut n = [[0.0; N]; N];
        let mut precisions: Vec<f64> = self
            .steps
            .iter()
            .rev()
            .map(|step| step.narrower(&mut n))
            .collect();
        precisions.reverse();
        precisions
    }

    /// 1 / standard deviation of each edge's innovation; 0 where it only sets the filter.
    pub fn scales(&self) -> impl Iterator<Item = f64> + '_ {
        self.steps.iter().map(|step| step.scale)
    }
}

/// A covariance once the angle was seen.
fn narrowed<const N: usize>(p: &Covariance<N>, gain: &[f64; N], own: f64) -> Covariance<N> {
    let mut after = *p;
    for row in 0..N {
        for column in row..N {
            after[row][column] = if row == ANGLE {
                own * gain[column]
            } else {
                p[row][column] - gain[row] * p[ANGLE][column]
            };
            after[column][row] = after[row][column];
        }
    }
    after
}

impl<W: Way<N>, const N: usize> Gain<W, N> {
    /// What is expected where state or angle start anew.
    #[inline(always)]
    fn begins(&self, mut state: [f64; N]) -> [f64; N] {
        if self.anew {
            state = [0.0; N];
        } else if self.fresh {
            state[ANGLE] = 0.0;
        }
        state
    }

    #[inline(always)]
    fn take(&self, state: &mut [f64; N], innovation: f64) {
        for (state, gain) in state.iter_mut().zip(&self.gain) {
            *state += gain * innovation;
        }
    }

    /// Takes an angle into a state; the innovation, white.
    #[inline(always)]
    fn white(&self, state: &mut [f64; N], angle: f64) -> f64 {
        *state = self.begins(self.way.on(*state));
        let innovation = angle - state[ANGLE];
        self.take(state, innovation);
        innovation * self.scale
    }

    /// Precision of an angle, and the transposed filter's covariance one edge before: de Jong's recursion (Biometrika 76, 1989).
    fn narrower(&self, n: &mut Covariance<N>) -> f64 {
        let dot = |row: &[f64; N]| row.iter().zip(&self.gain).map(|(n, g)| n * g).sum::<f64>();
        let with = n.map(|row| dot(&row));
        let precision = self.scale * self.scale + dot(&with);
        if self.anew {
            *n = [[0.0; N]; N];
            return precision;
        }
        // What the angle says itself is taken off the angle's part.
        let mut after = *n;
        for (at, with) in with.iter().enumerate() {
            after[ANGLE][at] -= with;
            after[at][ANGLE] -= with;
        }
        after[ANGLE][ANGLE] += precision;
        if self.fresh {
            after[ANGLE] = [0.0; N];
            after.iter_mut().for_each(|row| row[ANGLE] = 0.0);
        }
        *n = self.way.spread_back(&after);
        precision
    }
}

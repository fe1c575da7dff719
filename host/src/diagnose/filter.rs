//! The Kalman filter of a shaft whose course is free: innovations, likelihood, and the same filter for any regressor.
//!
//! State: angle, speed, a slow drift of the acceleration, the torque that is held over the present step of a noise grid, and, where the
//! twin or the noise has a mode, angle and speed of the swing. An edge shows the angle at its time with the error of its stamp. The gains
//! depend on times and noise alone, so one run serves every regressor (R. E. Kalman, Trans. ASME 82, 1960; likelihood by F. C. Schweppe, IEEE
//! Trans. Information Theory 11, 1965).

mod pull;
mod ring;

use std::array::from_fn;
use std::f64::consts::TAU;
use std::fmt::Debug;

use nalgebra::DMatrix;

use State::{Angle, Drift, Held, Speed, Swing, Swings};

pub use pull::Pull;
pub use ring::Ring;

use super::square::{Square, back, identity, through, times};

/// Numbers of a state, in their order. A shaft that has none of the last ones has a shorter state.
#[derive(Clone, Copy, Debug)]
pub enum State {
    /// Angle.
    Angle,
    /// Speed of the near side; where a drive keeps a speed of its own, what noise adds to it.
    Speed,
    /// Acceleration of a slow drift.
    Drift,
    /// Acceleration held over a step of the noise grid; where the drive is unknown, the speed that it keeps, which nothing damps.
    Held,
    /// Angle of the swing against the common motion.
    Swing,
    /// Its speed.
    Swings,
}

impl State {
    /// Numbers of a state of which it is the last.
    pub const fn and_before(self) -> usize {
        self as usize + 1
    }
}

/// A state of angle, speed and drift.
pub const DRIFTING: usize = State::Drift.and_before();

/// Sizes of the noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// Density of the acceleration noise, (rad/s^2)^2 s.
    pub torque: f64,
    /// RMS error of a stamp, s.
    pub stamp_s: f64,
    /// Density of the drift of the acceleration, (rad/s^3)^2 s.
    pub drift: f64,
    /// How fast a drift fades, 1/s: 0 where it goes wherever it likes.
    pub fade: f64,
    /// RMS error of an edge's angle that is none of the others, rad.
    pub angle_rad: f64,
    /// Part of the speed that torques which nobody has found yet leave open near a standstill of an unknown drive.
    pub unseen: f64,
    /// A mode of the machine that noise keeps ringing.
    pub ring: Ring,
}

/// From one edge to the next: what stays of the state, and what noise of unit size adds.
#[derive(Clone, Debug, Default)]
pub struct Leap<const N: usize> {
    /// Transition.
    pub way: Square<N>,
    /// Covariance for unit torque noise.
    pub torque: Square<N>,
    /// Covariance for unit drift.
    pub drift: Square<N>,
    /// Covariance of a noise whose size is declared.
    pub load: Option<Box<Square<N>>>,
    /// RMS change of angle, rad, and speed, rad/s, that the course within the interval leaves open.
    pub jolt: [f64; 2],
    /// The same of the speed alone, for unit of what is unseen, rad/s.
    pub unseen: f64,
    /// Speed at the edge, rad/s.
    pub speed: f64,
    /// Time since the edge before, s.
    pub h: f64,
    /// RMS error of this stamp beside the others', s.
    pub doubt_s: f64,
    /// Density of the drift, (rad/s^3)^2 s, and variance of the speed, (rad/s)^2, on top, where a drive that nobody declared has a corner.
    pub corner: [f64; 2],
    /// Whether a drive keeps a speed of its own.
    pub kept: bool,
}

impl<const N: usize> Leap<N> {
    /// The speed that a drive changes.
    const fn driven(&self) -> State {
        if self.kept { Held } else { Speed }
    }

    /// The transition where the drift fades, and what scales its covariance (G. E. Uhlenbeck, L. S. Ornstein, Physical Review 36, 1930).
    fn fading(&self, noise: &Noise) -> (Square<N>, f64) {
        let mut way = self.way;
        let faded = noise.fade * way[(Angle, Speed)];
        if N < DRIFTING || noise.drift <= 0.0 || faded <= 0.0 {
            return (way, noise.drift);
        }
        let mean = -(-faded).exp_m1() / faded;
        for row in [Angle, Speed] {
            way[(row, Drift)] *= mean;
        }
        way[(Drift, Drift)] = (-faded).exp();
        (way, noise.drift * -(-2.0 * faded).exp_m1() / (2.0 * faded))
    }
}

impl Leap<{ Held.and_before() }> {
    /// Whether a held torque pushes, or the drive keeps a speed.
    pub fn is_held(&self) -> bool {
        [Angle, Speed].map(|row| self.way[(row, Held)]) != [0.0; 2]
    }
}

#[derive(Clone, Debug)]
struct Gain<const N: usize> {
    way: Square<N>,
    /// The speed that a drive changes.
    driven: State,
    gain: [f64; N],
    /// 1 / deviation of the innovation; 0 where the edge only sets the filter.
    scale: f64,
}

/// Rows of angles that run side by side: a step waits for the one before it, so that some rows cost hardly more than one.
pub const SIDE_BY_SIDE: usize = 4;

impl<const N: usize> Gain<N> {
    /// Angles of some rows become innovations over their deviations, and the states before them those after.
    #[inline(always)]
    fn whiten<const L: usize>(&self, state: &mut [[f64; L]; N], angles: &mut [f64; L]) {
        *state = times(&self.way, state);
        for (angle, state) in angles.iter_mut().zip(state[Angle as usize]) {
            *angle -= state;
        }
        for (state, gain) in state.iter_mut().zip(&self.gain) {
            for (state, innovation) in state.iter_mut().zip(&*angles) {
                *state += gain * innovation;
            }
        }
        angles.iter_mut().for_each(|angle| *angle *= self.scale);
    }

    /// The transposed of [`Self::whiten`].
    #[inline(always)]
    fn transposed<const L: usize>(&self, state: &mut [[f64; L]; N], values: &mut [f64; L]) {
        let mut taken = [0.0; L];
        for (gain, state) in self.gain.iter().zip(&*state) {
            for (taken, of) in taken.iter_mut().zip(state) {
                *taken += gain * of;
            }
        }
        for (value, taken) in values.iter_mut().zip(taken) {
            *value = *value * self.scale + taken;
        }
        for (state, innovation) in state[Angle as usize].iter_mut().zip(&*values) {
            *state -= innovation;
        }
        *state = back(&self.way, state);
    }
}

/// Goes over rows of angles that run side by side, from a state on to the one at their end.
fn whiten<const N: usize, const L: usize>(
    steps: &[Gain<N>],
    mut state: [[f64; L]; N],
    angles: &mut [[f64; L]],
) -> [[f64; L]; N] {
    for (angles, step) in angles.iter_mut().zip(steps) {
        step.whiten(&mut state, angles);
    }
    state
}

/// The transposed of [`whiten`].
fn transposed<const N: usize, const L: usize>(
    steps: &[Gain<N>],
    mut state: [[f64; L]; N],
    white: &mut [[f64; L]],
) -> [[f64; L]; N] {
    for (values, step) in white.iter_mut().zip(steps).rev() {
        step.transposed(&mut state, values);
    }
    state
}

/// Edges of rows that are put side by side at a time, as near memory holds them.
const PART: usize = 256;

/// Goes over rows of the same length some at a time, side by side.
fn side_by_side<const N: usize>(steps: &[Gain<N>], rows: &mut [Vec<f64>], back: bool) {
    for rows in rows.chunks_mut(SIDE_BY_SIDE) {
        if let [row] = rows {
            let (row, state) = (row.as_chunks_mut().0, [[0.0]; N]);
            _ = match back {
                true => transposed(steps, state, row),
                false => whiten(steps, state, row),
            };
            continue;
        }
        let (mut state, mut all) = ([[0.0; SIDE_BY_SIDE]; N], [[0.0; SIDE_BY_SIDE]; PART]);
        let parts = steps.len().div_ceil(PART);
        for part in 0..parts {
            let from = PART * if back { parts - 1 - part } else { part };
            let steps = &steps[from..steps.len().min(from + PART)];
            let all = &mut all[..steps.len()];
            for (lane, row) in rows.iter().enumerate() {
                let each = all.iter_mut().zip(&row[from..]);
                each.for_each(|(all, of)| all[lane] = *of);
            }
            state = match back {
                true => transposed(steps, state, all),
                false => whiten(steps, state, all),
            };
            for (lane, row) in rows.iter_mut().enumerate() {
                let each = row[from..].iter_mut().zip(&*all);
                each.for_each(|(of, all)| *of = all[lane]);
            }
        }
    }
}

/// Gains along a row of edges.
#[derive(Clone, Debug)]
pub struct Filter<const N: usize> {
    gains: Vec<Gain<N>>,
}

/// Part of the greatest speed by which torques may have a shaft off the speed that its drive keeps, or its far side swing, to begin with.
const SWAY: f64 = 0.1;

impl<const N: usize> Filter<N> {
    /// The gains for a noise, of leaps: their first states, or them and more.
    pub fn new<const M: usize>(leaps: &[Leap<M>], noise: &Noise) -> Self {
        let top = leaps
            .iter()
            .map(|leap| leap.speed.abs())
            .fold(0.0, f64::max);
        let span: f64 = leaps.iter().map(|leap| leap.way[(Angle, Speed)]).sum();
        let mut p = Square::<N>::default();
        // It may be anywhere.
        p[(Angle, Angle)] = TAU * TAU;
        p[(Speed, Speed)] = top * top;
        if N >= DRIFTING && noise.drift > 0.0 {
            // As fast as any speed of the recording in a hundredth of it.
            let most = (100.0 * top / span.max(f64::MIN_POSITIVE)).powi(2);
            // One that fades is no torque that was always there; a drive with corners may begin in a ramp.
            let faded = span.min(0.5 / noise.fade);
            let ramps = leaps.iter().any(|leap| leap.corner != [0.0; 2]);
            p[(Drift, Drift)] = if noise.fade > 0.0 && !ramps {
                most.min(noise.drift * faded)
            } else {
                most
            };
        }
        if N >= Held.and_before() && leaps.iter().any(|leap| leap.kept) {
            p[(Held, Held)] = top * top;
            p[(Speed, Speed)] = SWAY * SWAY * top * top;
        }
        if N >= Swings.and_before() {
            p[(Swings, Swings)] = SWAY * SWAY * top * top;
            p[(Swing, Swing)] = 1e-6;
        }
        let rings = N >= Swings.and_before() && noise.ring.density > 0.0;
        if rings {
            p[(Swing, Swing)] = 0.0;
            p[(Swings, Swings)] = 0.0;
            ring::add(&mut p, noise.ring.at_rest());
        }
        let gains = leaps.iter().enumerate().map(|(at, leap)| {
            let (way, drift_size) = leap.fading(noise);
            let mut way = way.resized();
            // What damps the whole within a step has less in common with the swing; far less keeps their covariance one.
            let share = (leap.torque[(Speed, Speed)] / leap.h.max(f64::MIN_POSITIVE)).powi(4);
            let ring = rings.then(|| noise.ring.over(leap.h, &mut way, noise.torque, share));
            if at > 0 {
                p = through(&way, &p);
                if let Some(ring) = ring {
                    ring::add(&mut p, ring);
                }
                p.add(noise.torque, &leap.torque);
                let [drift, kick] = leap.corner;
                p.add(drift_size + drift, &leap.drift);
                let kicks = [
                    (leap.driven(), kick),
                    (Speed, (noise.unseen * leap.unseen).powi(2)),
                ];
                for (speed, kick) in kicks {
                    let half_s = 0.5 * leap.way[(Angle, speed)];
                    p[(Angle, Angle)] += half_s * half_s * kick;
                    p[(Angle, speed)] += half_s * kick;
                    p[(speed, Angle)] += half_s * kick;
                    p[(speed, speed)] += kick;
                }
                if let Some(load) = &leap.load {
                    p.add(1.0, load);
                }
                let [angle, speed] = leap.jolt;
                p[(Angle, Angle)] += angle * angle;
                p[(Angle, Speed)] += angle * speed;
                p[(Speed, Angle)] += angle * speed;
                p[(Speed, Speed)] += speed * speed;
            }
            let own = leap.speed.powi(2) * (noise.stamp_s.powi(2) + leap.doubt_s.powi(2))
                + noise.angle_rad.powi(2)
                + 1e-30;
            let inverse = 1.0 / (p[(Angle, Angle)] + own);
            let row = p.0[Angle as usize];
            let gain = row.map(|of| of * inverse);
            for at in 0..N {
                for other in at..N {
                    p.0[at][other] = if at == Angle as usize {
                        own * gain[other]
                    } else {
                        p.0[at][other] - gain[at] * row[other]
                    };
                    p.0[other][at] = p.0[at][other];
                }
            }
            // Edges that only set the filter, as many with a drift as without: likelihoods of both are compared.
            let scale = if at < DRIFTING { 0.0 } else { inverse.sqrt() };
            let driven = leap.driven();
            Gain {
                way,
                driven,
                gain,
                scale,
            }
        });
        Self {
            gains: gains.collect(),
        }
    }

    /// The last edges as a turn that repeats without end.
    pub fn around(&self, edges: usize) -> Around<N> {
        let steps = self.gains[self.gains.len() - edges..].to_vec();
        // What a turn makes of each number of a state alone.
        let (Square(mut ahead), Square(mut behind)) = (identity(), identity());
        for step in &steps {
            step.whiten(&mut ahead, &mut [0.0; N]);
        }
        for step in steps.iter().rev() {
            step.transposed(&mut behind, &mut [0.0; N]);
        }
        let fades = |end: [[f64; N]; N]| {
            let own = DMatrix::<f64>::identity(N, N);
            let open = own - DMatrix::from_fn(N, N, |row, column| end[row][column]);
            // A state that never fades begins as nothing.
            open.try_inverse().map_or_else(Square::default, |start| {
                Square(from_fn(|row| from_fn(|column| start[(row, column)])))
            })
        };
        Around {
            start: fades(ahead),
            end: fades(behind),
            steps,
        }
    }
}

/// A filter of whatever number of states.
pub trait Whitens: Debug + Send + Sync {
    /// Innovations of a row of angles over their deviations, in place; 0 where an edge only sets the filter.
    fn whiten(&self, angles: &mut [f64]) {
        self.whiten_from(0, angles);
    }

    /// The same of a row that begins at an edge, nothing before.
    fn whiten_from(&self, first: usize, angles: &mut [f64]);

    /// The same of some rows.
    fn whiten_rows(&self, rows: &mut [Vec<f64>]);

    /// Angles that have these innovations: the inverse of [`Self::whiten`], in place.
    fn colour(&self, white: &mut [f64]);

    /// The transposed of [`Self::whiten`], in place.
    fn transposed(&self, white: &mut [f64]);

    /// The same of some rows.
    fn transposed_rows(&self, rows: &mut [Vec<f64>]);

    /// 1 / deviation of each innovation, 1/rad; 0 where an edge only sets the filter.
    fn scales(&self) -> Vec<f64>;

    /// How weighed innovations pull at jumps within the interval before each edge; not at all where there is no drift.
    fn pulls(&self, innovations: &[f64], weights: &[f64]) -> Vec<Pull>;
}

impl<const N: usize> Whitens for Filter<N> {
    fn whiten_from(&self, first: usize, angles: &mut [f64]) {
        whiten(&self.gains[first..], [[0.0]; N], angles.as_chunks_mut().0);
    }

    fn whiten_rows(&self, rows: &mut [Vec<f64>]) {
        side_by_side(&self.gains, rows, false);
    }

    fn colour(&self, white: &mut [f64]) {
        let mut state = [[0.0]; N];
        for (value, step) in white.iter_mut().zip(&self.gains) {
            state = times(&step.way, &state);
            let innovation = if step.scale > 0.0 {
                *value / step.scale
            } else {
                0.0
            };
            *value = innovation + state[Angle as usize][0];
            for ([state], gain) in state.iter_mut().zip(&step.gain) {
                *state += gain * innovation;
            }
        }
    }

    fn transposed(&self, white: &mut [f64]) {
        transposed(&self.gains, [[0.0]; N], white.as_chunks_mut().0);
    }

    fn transposed_rows(&self, rows: &mut [Vec<f64>]) {
        side_by_side(&self.gains, rows, true);
    }

    fn scales(&self) -> Vec<f64> {
        self.gains.iter().map(|step| step.scale).collect()
    }

    fn pulls(&self, innovations: &[f64], weights: &[f64]) -> Vec<Pull> {
        pull::pulls(&self.gains, innovations, weights)
    }
}

/// A filter of a turn that repeats without end: the state that it begins in is the one in which it ends.
#[derive(Clone, Debug)]
pub struct Around<const N: usize> {
    steps: Vec<Gain<N>>,
    /// The state to begin in, of that in which a turn ends that begins in none; forward and back.
    start: Square<N>,
    end: Square<N>,
}

impl<const N: usize> Around<N> {
    /// Innovations of a turn of angles over their deviations, in place.
    pub fn whiten(&self, angles: &mut [f64]) {
        let ends = whiten(&self.steps, [[0.0]; N], angles.to_vec().as_chunks_mut().0);
        let begins = times(&self.start, &ends);
        whiten(&self.steps, begins, angles.as_chunks_mut().0);
    }

    /// The transposed of [`Self::whiten`], in place.
    pub fn transposed(&self, white: &mut [f64]) {
        let ends = transposed(&self.steps, [[0.0]; N], white.to_vec().as_chunks_mut().0);
        let begins = times(&self.end, &ends);
        transposed(&self.steps, begins, white.as_chunks_mut().0);
    }
}

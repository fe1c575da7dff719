//! The shaft's law of motion about its course: what a torque does to the angle at each edge, and how noise spreads between edges.
//!
//! J dw/dt = drive + torques - friction, linear about the course: a small acceleration f makes dy/dt = v, dv/dt = -b v + f, with b the
//! slope of all friction and of the drive at the course's own speed. Torques are evaluated at the angles and times that the edges
//! give, so any size of them is exact to first order in the stamps' errors.

use std::f64::consts::TAU;

use super::course::Course;
use super::filter::{
    self, ANGLE, DRIFT, DRIFTING, HELD, KEPT, Leap, PLAIN, SPEED, STATES, STIFF, SWING, SWINGS,
    Square,
};
use crate::effect::Carrier;
pub use crate::effect::Here;
use crate::twin::{Drive, Noise as TwinNoise, Twin};

/// A share of the inertia behind a spring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// Square of the free frequency, 1/s^2.
    pub square: f64,
    /// Damping of the swing, 1/s.
    pub damping: f64,
    /// Inertia of the far side over that of the near one.
    pub ratio: f64,
    /// Density of the noise of the far side's torque over the square of the inertia, (rad/s^2)^2 s.
    pub load: f64,
}

/// Friction and drive of a twin, over its inertia.
#[derive(Clone, Debug, PartialEq)]
pub struct Law {
    /// Inertia, kg m^2.
    pub inertia: f64,
    /// Viscous friction, 1/s.
    pub viscous: f64,
    /// What an open-loop drive adds while it is on, 1/s.
    pub stiffness: f64,
    /// Coulomb friction, rad/s^2.
    pub coulomb: f64,
    /// Drag, 1/rad.
    pub drag: f64,
    /// Stribeck friction, rad/s^2.
    pub stribeck: f64,
    /// Its speed, rad/s.
    pub stribeck_rad_s: f64,
    /// When the drive goes off, s.
    pub off_s: f64,
    /// Second mass.
    pub mode: Option<Mode>,
    /// Time for which torque noise is held, s; 0 where it is white.
    pub hold_s: f64,
    /// Whether nobody knows what drives it.
    pub undriven: bool,
}

impl Law {
    /// Of a twin.
    #[must_use]
    pub fn of(twin: &Twin) -> Self {
        let shaft = &twin.shaft;
        let inertia = shaft.inertia_or_one();
        let viscous = shaft.viscous_n_m_s / inertia;
        let nominal = twin.drive.nominal_rad_s().abs();
        let held = match twin.noise {
            Some(TwinNoise::SpeedWander {
                correlation_rad: Some(correlation),
                ..
            }) => nominal / correlation,
            _ => viscous + shaft.stiffness_n_m_s / inertia,
        };
        if twin.drive == Drive::Unknown {
            return Self::undriven(inertia, viscous);
        }
        let looped = twin.speed_loop().is_some();
        let interval_s = TAU / (f64::from(twin.encoder.grid_edges()) * nominal);
        let hold_s = match twin.noise {
            Some(TwinNoise::White { hold_s, .. }) => hold_s.unwrap_or(interval_s),
            Some(TwinNoise::SpeedWander { hold_s, .. }) => {
                hold_s.unwrap_or(interval_s.min(1.0 / (crate::sim::NOISE_STEPS * held.max(1e-30))))
            }
            None => 0.0,
        };
        Self {
            inertia,
            viscous,
            stiffness: if looped { 0.0 } else { held - viscous },
            coulomb: shaft.coulomb_n_m / inertia,
            drag: shaft.drag_n_m_s2 / inertia,
            stribeck: shaft.stribeck_n_m / inertia,
            stribeck_rad_s: shaft.stribeck_rad_s,
            off_s: match twin.drive {
                Drive::RunDown { off_s, .. } => off_s,
                _ => f64::INFINITY,
            },
            mode: twin.torsional_resonance.as_ref().map(|mode| {
                let free = TAU * mode.f_hz;
                Mode {
                    square: free * free,
                    damping: 2.0 * mode.damping_ratio * free,
                    ratio: mode.inertia_share / (1.0 - mode.inertia_share),
                    load: mode.load_psd_n2_m2_s.unwrap_or(0.0) / (inertia * inertia),
                }
            }),
            hold_s: if hold_s.is_finite() { hold_s } else { 0.0 },
            undriven: false,
        }
    }

    /// The same of a shaft that is held more stiffly, 1/s.
    #[must_use]
    pub fn held(self, stiffness: f64) -> Self {
        Self {
            stiffness: self.stiffness + stiffness,
            ..self
        }
    }

    /// Of a shaft whose drive is unknown: what that does against friction is in the free course, which nothing damps. What a torque adds
    /// to the course is damped all the same.
    const fn undriven(inertia: f64, viscous: f64) -> Self {
        Self {
            inertia,
            viscous,
            stiffness: 0.0,
            coulomb: 0.0,
            drag: 0.0,
            stribeck: 0.0,
            stribeck_rad_s: 0.0,
            off_s: f64::INFINITY,
            mode: None,
            hold_s: 0.0,
            undriven: true,
        }
    }

    /// Size of the friction without the viscous part at a speed, rad/s^2, and its slope, 1/s.
    #[must_use]
    pub fn friction(&self, speed: f64) -> (f64, f64) {
        let size = speed.abs();
        let mut at = self.coulomb + self.drag * size * size;
        let mut slope = 2.0 * self.drag * size;
        if self.stribeck > 0.0 {
            let over = size / self.stribeck_rad_s;
            let left = self.stribeck * (-over * over).exp();
            at += left;
            slope -= 2.0 * over / self.stribeck_rad_s * left;
        }
        (at, slope)
    }

    /// What it has of one kind of friction, over the inertia.
    #[must_use]
    pub fn coefficient(&self, kind: Carrier) -> f64 {
        match kind {
            Carrier::Power(0.0) => self.coulomb,
            Carrier::Power(1.0) => self.viscous,
            Carrier::Power(2.0) => self.drag,
            Carrier::Stribeck(_) => self.stribeck,
            _ => 0.0,
        }
    }

    /// Share of a time for which the drive is on.
    fn share_on(&self, from_s: f64, until_s: f64) -> f64 {
        if until_s <= self.off_s {
            1.0
        } else if from_s >= self.off_s {
            0.0
        } else {
            (self.off_s - from_s) / (until_s - from_s)
        }
    }

    /// Damping at a time and a speed, 1/s.
    #[must_use]
    pub fn damping(&self, time_s: f64, speed: f64) -> f64 {
        let drive = if time_s < self.off_s {
            self.stiffness
        } else {
            0.0
        };
        self.viscous + drive + self.friction(speed).1
    }
}

/// -1, 0 or 1.
#[must_use]
pub fn sign(value: f64) -> f64 {
    if value == 0.0 { 0.0 } else { value.signum() }
}

/// Angle, rad, and speed, rad/s.
pub type Motion = [f64; 2];

/// A shaft along its course.
#[derive(Clone, Debug)]
pub struct Plant {
    /// Its law.
    pub law: Law,
    /// Damping over the interval that ends at each edge, 1/s.
    pub damping: Vec<f64>,
    /// Part of it that is the slope of friction, 1/s.
    slopes: Vec<f64>,
    /// Angle of a speed and what stays of it, over each whole interval and over half of it.
    reaches: Vec<[(f64, f64); 2]>,
}

/// Phase, rad, that a torque may take over a part of an interval.
const PHASE: f64 = 0.35;
/// Parts of an interval at the most.
const PARTS_MOST: f64 = 256.0;

impl Plant {
    /// Of a law along a course.
    #[must_use]
    pub fn new(law: Law, course: &Course) -> Self {
        let slopes = (0..course.len()).map(|at| {
            let before = at.saturating_sub(1);
            law.friction(0.5 * (course.speed[at] + course.speed[before]))
                .1
        });
        let slopes: Vec<f64> = slopes.collect();
        let damping = slopes.iter().enumerate().map(|(at, slope)| {
            let before = at.saturating_sub(1);
            let on = law.share_on(course.time_s[before], course.time_s[at]);
            law.viscous + on * law.stiffness + slope
        });
        let damping: Vec<f64> = damping.collect();
        let reaches = (0..course.len()).map(|at| {
            let h = course.time_s[at] - course.time_s[at.saturating_sub(1)];
            [reach(damping[at], h), reach(damping[at], 0.5 * h)]
        });
        Self {
            reaches: reaches.collect(),
            damping,
            slopes,
            law,
        }
    }

    /// The same shaft as its free course goes, which nothing damps.
    #[must_use]
    pub fn free(&self, course: &Course) -> Self {
        Self::new(Law::undriven(self.law.inertia, 0.0), course)
    }

    /// Acceleration by friction about the course: what it is there, less what the damping of that interval has of it already.
    #[must_use]
    pub fn friction(&self, course: &Course, here: Here) -> f64 {
        let at = course
            .time_s
            .partition_point(|time_s| *time_s < here.inside_s);
        let slope = self.slopes.get(at).copied().unwrap_or(0.0);
        slope * here.speed - self.law.friction(here.speed).0 * here.way
    }

    /// Angle that an acceleration makes at each edge of a range, rad, from rest at the first. `rate` is how fast the acceleration's phase
    /// may go, rad/s, at a speed; `breaks` are instants at which it jumps, s, by time.
    pub fn response_over(
        &self,
        range: std::ops::Range<usize>,
        course: &Course,
        acceleration: impl Fn(Here) -> f64,
        rate: impl Fn(f64) -> f64,
        breaks: &[f64],
    ) -> Vec<f64> {
        let [out] = self.responses(
            range,
            course,
            false,
            |here| [acceleration(here)],
            rate,
            breaks,
        );
        out.iter().map(|motion| motion[ANGLE]).collect()
    }

    /// Angle and speed that several accelerations make; they see the speed that was foretold, or the one that was.
    #[allow(clippy::too_many_arguments)]
    pub fn responses<const K: usize>(
        &self,
        range: std::ops::Range<usize>,
        course: &Course,
        foretold: bool,
        acceleration: impl Fn(Here) -> [f64; K],
        rate: impl Fn(f64) -> f64,
        breaks: &[f64],
    ) -> [Vec<Motion>; K] {
        let mut out = [(); K].map(|()| vec![Motion::default(); range.len()]);
        let mut states = [[0.0; 4]; K];
        // What acts at the start of an interval is what did at the end of the last one, unless it jumps.
        let mut push = None;
        let mut next = breaks.partition_point(|&time| {
            time <= course.time_s.get(range.start).copied().unwrap_or(0.0)
        });
        for at in range.start + 1..range.end {
            let (from, until) = (course.time_s[at - 1], course.time_s[at]);
            let h = until - from;
            if h > 0.0 {
                let mut begun = from;
                loop {
                    let end = breaks.get(next).copied().filter(|&time| time < until);
                    let stop = end.unwrap_or(until);
                    if stop > begun {
                        let part = [begun, stop];
                        let before = push.filter(|_| breaks.is_empty());
                        push = Some(self.over(
                            course,
                            at,
                            part,
                            &mut states,
                            before,
                            foretold,
                            &acceleration,
                            &rate,
                        ));
                    }
                    begun = stop;
                    match end {
                        Some(_) => next += 1,
                        None => break,
                    }
                }
            }
            while breaks.get(next).is_some_and(|&time| time <= until) {
                next += 1;
            }
            for (out, state) in out.iter_mut().zip(&states) {
                out[at - range.start] = [state[ANGLE], state[SPEED]];
            }
        }
        out
    }

    /// Angle and speed at each edge that an even unit acceleration between two instants makes; none of a shaft with a mode, or whose drive
    /// goes off.
    #[must_use]
    pub fn pushed_evenly(&self, course: &Course, from_s: f64, until_s: f64) -> Option<Vec<Motion>> {
        if self.law.mode.is_some() || self.law.off_s.is_finite() {
            return None;
        }
        let mut state = Motion::default();
        let mut out = vec![state; course.len()];
        for (at, out) in out.iter_mut().enumerate().skip(1) {
            let (before, now) = (course.time_s[at - 1], course.time_s[at]);
            let b = self.damping[at];
            let mut go = |h: f64, push: f64, whole: bool| {
                let (r, stays) = if whole {
                    self.reaches[at][0]
                } else {
                    reach(b, h)
                };
                state[ANGLE] += r * state[SPEED] + push * swept(b, h, r);
                state[SPEED] = stays * state[SPEED] + push * r;
            };
            let (begins, ends) = (before.max(from_s), now.min(until_s));
            if begins >= ends {
                go(now - before, 0.0, true);
            } else {
                go(begins - before, 0.0, false);
                go(ends - begins, 1.0, begins == before && ends == now);
                go(now - ends, 0.0, false);
            }
            *out = state;
        }
        Some(out)
    }

    /// Takes states through a part of the interval that ends at an edge; gives what acts at its end.
    #[allow(clippy::too_many_arguments)]
    fn over<const K: usize>(
        &self,
        course: &Course,
        at: usize,
        [begun, stop]: [f64; 2],
        states: &mut [[f64; 4]; K],
        before: Option<[f64; K]>,
        foretold: bool,
        acceleration: &impl Fn(Here) -> [f64; K],
        rate: &impl Fn(f64) -> f64,
    ) -> [f64; K] {
        let (from, h) = (
            course.time_s[at - 1],
            course.time_s[at] - course.time_s[at - 1],
        );
        let length = stop - begun;
        let speed = course.speed[at].abs().max(course.speed[at - 1].abs());
        let on = |from_s, until_s| self.law.share_on(from_s, until_s);
        let here_on = on(begun, stop) - on(from, course.time_s[at]);
        let b = self.damping[at] + here_on * self.law.stiffness;
        let mut fastest = rate(speed).abs();
        if let Some(mode) = &self.law.mode {
            fastest += mode.square.sqrt() + mode.damping + (1.0 + mode.ratio) * b.abs();
        }
        let parts = (fastest * length / PHASE).ceil().clamp(1.0, PARTS_MOST);
        let step = length / parts;
        let [whole, half] = if step == h && here_on == 0.0 {
            self.reaches[at]
        } else {
            [reach(b, step), reach(b, 0.5 * step)]
        };
        let inside_s = 0.5 * (begun + stop);
        // On which side of a standstill the part is, its ends do not say.
        let way = sign(course.within(at, (inside_s - from) / h).1);
        let here = |time_s: f64| {
            let (angle, speed) = course.within(at, (time_s - from) / h);
            acceleration(Here {
                time_s,
                inside_s,
                angle,
                speed: if foretold { course.steady[at] } else { speed },
                way,
            })
        };
        let mut push = before.unwrap_or_else(|| here(begun));
        for part in 0..parts as usize {
            let start = begun + step * part as f64;
            let (middle, last) = (here(start + 0.5 * step), here(start + step));
            for (k, state) in states.iter_mut().enumerate() {
                *state = match &self.law.mode {
                    Some(mode) => swung(mode, b, step, *state, [push[k], middle[k], last[k]]),
                    None => [
                        state[0]
                            + whole.0 * state[1]
                            + step / 6.0 * (whole.0 * push[k] + 4.0 * half.0 * middle[k]),
                        whole.1 * state[1]
                            + step / 6.0 * (whole.1 * push[k] + 4.0 * half.1 * middle[k] + last[k]),
                        0.0,
                        0.0,
                    ],
                };
            }
            push = last;
        }
        push
    }

    /// How a free course is damped over the interval that ends at an edge, 1/s: an unknown drive keeps it up.
    fn fades(&self, at: usize) -> f64 {
        if self.law.undriven {
            0.0
        } else {
            self.damping[at]
        }
    }

    /// Angle at each edge of a shaft that starts with unit speed and is not pushed, s.
    #[must_use]
    pub fn fading(&self, course: &Course) -> Vec<f64> {
        let (mut angle, mut speed) = (0.0, 1.0);
        (0..course.len())
            .map(|at| {
                if at > 0 {
                    let h = course.time_s[at] - course.time_s[at - 1];
                    let (reach, stays) = reach(self.fades(at), h);
                    angle += reach * speed;
                    speed *= stays;
                }
                angle
            })
            .collect()
    }

    /// How sensitive a score is to an acceleration over each interval: the transposed of [`Self::response_over`] for one that is even over
    /// it. `score` is what one rad at each edge adds to the score.
    #[must_use]
    pub fn sensitivity(&self, course: &Course, score: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; score.len()];
        let (mut angle, mut speed) = (0.0, 0.0);
        for at in (1..score.len()).rev() {
            angle += score[at];
            let h = course.time_s[at] - course.time_s[at - 1];
            let b = self.damping[at];
            let (r, stays) = reach(b, h);
            // Angle and speed that a unit acceleration over the interval gives.
            let by_angle = swept(b, h, r);
            out[at] = by_angle * angle + r * speed;
            speed = r * angle + stays * speed;
        }
        out
    }

    /// Leaps of the filter of a stiff shaft, or of one with a mode.
    #[must_use]
    pub fn leaps<const N: usize>(&self, course: &Course) -> Vec<Leap<N>> {
        let law = &self.law;
        let kept = law.undriven && law.hold_s <= 0.0 && law.viscous + law.stiffness > 0.0;
        (0..course.len())
            .map(|at| {
                let before = at.saturating_sub(1);
                let h = (course.time_s[at] - course.time_s[before]).max(0.0);
                let (way, torque, drift) = if kept {
                    self.kept_up::<N>(self.damping[at], h)
                } else {
                    self.spread::<N>(self.fades(at), course.time_s[at], h)
                };
                let load = self.law.mode.filter(|mode| mode.load > 0.0);
                Leap {
                    way,
                    torque,
                    drift,
                    load: load.map(|mode| {
                        let far = [(SWINGS, mode.load.sqrt())];
                        Box::new(self.stirred::<N>(&mode, self.damping[at], h, &far))
                    }),
                    jolt: [0.0; 2],
                    speed: course.speed[at],
                    fresh: false,
                    doubt_s: course.doubt_s[at],
                    kept,
                }
            })
            .collect()
    }

    /// Transition and covariances of unit noises over a time where an unknown drive keeps a speed: a slow drift of the acceleration makes
    /// that, torque noise makes another one beside it, which friction and drive damp.
    fn kept_up<const N: usize>(&self, b: f64, h: f64) -> (Square<N>, Square<N>, Square<N>) {
        let mut way = identity::<N>();
        let (r, stays) = reach(b, h);
        way[ANGLE][SPEED] = r;
        way[SPEED][SPEED] = stays;
        way[ANGLE][KEPT] = h;
        way[ANGLE][DRIFT] = 0.5 * h * h;
        way[KEPT][DRIFT] = h;
        let drift = self.drift_noise::<N>(KEPT, h);
        (way, self.white::<N>(b, h), drift)
    }

    /// Transition and covariances of unit noises over a time that ends at an instant.
    fn spread<const N: usize>(
        &self,
        b: f64,
        ends_s: f64,
        h: f64,
    ) -> (Square<N>, Square<N>, Square<N>) {
        let zero = [[0.0; N]; N];
        let hold = self.law.hold_s;
        let drift = self.drift_noise::<N>(SPEED, h);
        if hold <= 0.0 || h > STEPS_MOST * hold {
            let way = self.way::<N>(b, h, false);
            return (way, self.white::<N>(b, h), drift);
        }
        // The noise's grid: a value is held over each step of it.
        let starts_s = ends_s - h;
        let mut way = identity::<N>();
        let mut torque = zero;
        let mut now = starts_s;
        let mut grid = (starts_s / hold).floor() + 1.0;
        loop {
            let stop = (grid * hold).min(ends_s);
            if stop > now {
                let part = self.way::<N>(b, stop - now, true);
                torque = filter::through(&part, &torque);
                way = product(&part, &way);
            }
            if stop >= ends_s {
                break;
            }
            // A new value: nothing of the old one stays.
            for k in 0..N {
                way[HELD][k] = 0.0;
                torque[HELD][k] = 0.0;
                torque[k][HELD] = 0.0;
            }
            torque[HELD][HELD] = 1.0 / hold;
            now = stop;
            grid += 1.0;
        }
        (way, torque, drift)
    }

    /// How a state goes on; with `held`, the held torque pushes.
    fn way<const N: usize>(&self, b: f64, h: f64, held: bool) -> Square<N> {
        let mut way = identity::<N>();
        if !held {
            way[HELD][HELD] = 0.0;
        }
        match (&self.law.mode, N > SWINGS) {
            (Some(mode), true) => {
                let mut column = |place: usize, start: [f64; 4], push: f64| {
                    let parts =
                        ((mode.square.sqrt() + mode.damping + (1.0 + mode.ratio) * b.abs()) * h
                            / PHASE)
                            .ceil()
                            .clamp(1.0, PARTS_MOST);
                    let mut state = start;
                    for _ in 0..parts as usize {
                        state = swung(mode, b, h / parts, state, [push; 3]);
                    }
                    for (row, value) in [ANGLE, SPEED, SWING, SWINGS].into_iter().zip(state) {
                        way[row][place] = value;
                    }
                };
                column(ANGLE, [1.0, 0.0, 0.0, 0.0], 0.0);
                column(SPEED, [0.0, 1.0, 0.0, 0.0], 0.0);
                column(SWING, [0.0, 0.0, 1.0, 0.0], 0.0);
                column(SWINGS, [0.0, 0.0, 0.0, 1.0], 0.0);
                column(DRIFT, [0.0; 4], 1.0);
                if held {
                    column(HELD, [0.0; 4], 1.0);
                }
            }
            _ => {
                let (r, stays) = reach(b, h);
                let by_angle = swept(b, h, r);
                way[ANGLE][SPEED] = r;
                way[SPEED][SPEED] = stays;
                way[ANGLE][DRIFT] = by_angle;
                way[SPEED][DRIFT] = r;
                if held {
                    way[ANGLE][HELD] = by_angle;
                    way[SPEED][HELD] = r;
                }
            }
        }
        way
    }

    /// Covariance that unit white torque noise makes over a time.
    fn white<const N: usize>(&self, b: f64, h: f64) -> Square<N> {
        if let (Some(mode), true) = (&self.law.mode, N > SWINGS) {
            let near = [(SPEED, 1.0 + mode.ratio), (SWINGS, mode.ratio)];
            return self.stirred::<N>(mode, b, h, &near);
        }
        let mut q = [[0.0; N]; N];
        let [angle, both, speed] = stir(b * h);
        q[ANGLE][ANGLE] = h * h * h * angle;
        q[ANGLE][SPEED] = h * h * both;
        q[SPEED][ANGLE] = q[ANGLE][SPEED];
        q[SPEED][SPEED] = h * speed;
        q
    }

    /// Covariance that white noise makes over a time of two masses, pushing states by so much: pushes in the middle of short parts.
    fn stirred<const N: usize>(
        &self,
        mode: &Mode,
        b: f64,
        h: f64,
        pushed: &[(usize, f64)],
    ) -> Square<N> {
        let mut q = [[0.0; N]; N];
        let parts = ((mode.square.sqrt() + mode.damping) * h / PHASE)
            .ceil()
            .clamp(4.0, 32.0);
        let step = h / parts;
        let part = self.way::<N>(b, step, false);
        for _ in 0..parts as usize {
            q = filter::through(&part, &q);
            for (row, one) in pushed {
                for (column, other) in pushed {
                    q[*row][*column] += step * one * other;
                }
            }
        }
        q
    }

    /// Covariance that a unit random walk of the acceleration makes over a time, by way of a speed.
    fn drift_noise<const N: usize>(&self, speed: usize, h: f64) -> Square<N> {
        let mut q = [[0.0; N]; N];
        let h2 = h * h;
        let (aa, av, am) = (h2 * h2 * h / 20.0, h2 * h2 / 8.0, h2 * h / 6.0);
        let (vv, vm, mm) = (h2 * h / 3.0, h2 / 2.0, h);
        let all = [[aa, av, am], [av, vv, vm], [am, vm, mm]];
        let places = [ANGLE, speed, DRIFT];
        for (row, values) in places.into_iter().zip(all) {
            for (column, value) in places.into_iter().zip(values) {
                q[row][column] = value;
            }
        }
        q
    }
}

/// Steps of the noise's grid in an interval from which on the noise is as good as white.
const STEPS_MOST: f64 = 6.0;

/// Angle that a speed makes over a time, and what stays of the speed.
#[must_use]
#[inline]
pub fn reach(b: f64, h: f64) -> (f64, f64) {
    let x = b * h;
    if x.abs() < 1e-4 {
        (h * (1.0 - 0.5 * x), 1.0 - x + 0.5 * x * x)
    } else {
        let forgotten = -(-x).exp_m1();
        (forgotten / b, 1.0 - forgotten)
    }
}

/// Angle that a unit acceleration makes over a time in which a unit speed makes the angle `r`.
fn swept(b: f64, h: f64, r: f64) -> f64 {
    if (b * h).abs() < 1e-3 {
        0.5 * h * h * (1.0 - b * h / 3.0)
    } else {
        (h - r) / b
    }
}

/// Two masses over a short step, pushed near at its start, middle and end: Runge and Kutta's fourth order.
fn swung(mode: &Mode, b: f64, h: f64, state: [f64; 4], push: [f64; 3]) -> [f64; 4] {
    let slope = |[_, v, q, u]: [f64; 4], push: f64| {
        let near = push - b * v;
        let swing = -mode.square * q - mode.damping * u;
        [
            v,
            (1.0 + mode.ratio) * near + swing,
            u,
            mode.ratio * near + swing,
        ]
    };
    let along = |k: [f64; 4], by: f64| {
        let mut at = state;
        at.iter_mut().zip(k).for_each(|(at, k)| *at += by * k);
        at
    };
    let k1 = slope(state, push[0]);
    let k2 = slope(along(k1, 0.5 * h), push[1]);
    let k3 = slope(along(k2, 0.5 * h), push[1]);
    let k4 = slope(along(k3, h), push[2]);
    let mut end = state;
    for at in 0..4 {
        end[at] += h / 6.0 * (k1[at] + 2.0 * k2[at] + 2.0 * k3[at] + k4[at]);
    }
    end
}

fn identity<const N: usize>() -> Square<N> {
    let mut one = [[0.0; N]; N];
    for (at, row) in one.iter_mut().enumerate() {
        row[at] = 1.0;
    }
    one
}

fn product<const N: usize>(a: &Square<N>, b: &Square<N>) -> Square<N> {
    let mut c = [[0.0; N]; N];
    for row in 0..N {
        for column in 0..N {
            c[row][column] = (0..N).map(|k| a[row][k] * b[k][column]).sum();
        }
    }
    c
}

/// Variance of the angle, covariance with the speed and variance of the speed that unit white noise gives over unit time from rest,
/// damped by `x` (G. E. Uhlenbeck, L. S. Ornstein, Physical Review 36, 1930).
fn stir(x: f64) -> [f64; 3] {
    if x.abs() < 1e-2 {
        return [
            1.0 / 3.0 - x / 4.0 + 7.0 / 60.0 * x * x,
            0.5 * (1.0 - x + 7.0 / 12.0 * x * x),
            1.0 - x + 2.0 / 3.0 * x * x,
        ];
    }
    let forgotten = -(-x).exp_m1();
    let reach = forgotten / x;
    [
        (1.0 - reach - 0.5 * reach * forgotten) / (x * x),
        0.5 * reach * reach,
        reach * (1.0 - 0.5 * forgotten),
    ]
}

/// The filter of either shaft.
#[derive(Clone, Debug)]
pub enum Gains {
    /// Stiff, without drift and noise grid.
    Plain(filter::Filter<PLAIN>),
    /// Stiff, without a noise grid.
    Drifting(filter::Filter<DRIFTING>),
    /// Stiff.
    Stiff(filter::Filter<STIFF>),
    /// With a mode.
    Sprung(filter::Filter<STATES>),
}

/// The leaps of either shaft.
#[derive(Clone, Debug)]
pub enum Leaps {
    /// Stiff.
    Stiff(Vec<Leap<STIFF>>),
    /// With a mode.
    Sprung(Vec<Leap<STATES>>),
}

impl Leaps {
    /// Of a plant.
    #[must_use]
    pub fn of(plant: &Plant, course: &Course) -> Self {
        match plant.law.mode {
            None => Self::Stiff(plant.leaps(course)),
            Some(_) => Self::Sprung(plant.leaps(course)),
        }
    }

    /// Leaves open how angle and speed changed within intervals.
    pub fn jolt(&mut self, jolts: &[(usize, Motion)]) {
        for (at, jolt) in jolts {
            match self {
                Self::Stiff(leaps) => leaps[*at].jolt = *jolt,
                Self::Sprung(leaps) => leaps[*at].jolt = *jolt,
            }
        }
    }

    /// Mean of the speed's size over the edges, rad/s.
    #[must_use]
    pub fn speed(&self) -> f64 {
        let mean = |speeds: &mut dyn Iterator<Item = f64>| {
            let (sum, count) = speeds.fold((0.0, 0.0), |(sum, count), speed| {
                (sum + speed.abs(), count + 1.0)
            });
            sum / f64::max(count, 1.0)
        };
        match self {
            Self::Stiff(leaps) => mean(&mut leaps.iter().map(|leap| leap.speed)),
            Self::Sprung(leaps) => mean(&mut leaps.iter().map(|leap| leap.speed)),
        }
    }

    /// The filter for a noise over a range of edges.
    #[must_use]
    pub fn filter(&self, range: std::ops::Range<usize>, noise: &filter::Noise) -> Gains {
        match self {
            Self::Stiff(leaps) => {
                let leaps = &leaps[range];
                // Fewer states take less time.
                match (leaps.iter().any(Leap::is_held), noise.drift > 0.0) {
                    (true, _) => Gains::Stiff(filter::Filter::new(leaps, noise)),
                    (false, true) => Gains::Drifting(first(leaps, noise)),
                    (false, false) => Gains::Plain(first(leaps, noise)),
                }
            }
            Self::Sprung(leaps) => Gains::Sprung(filter::Filter::new(&leaps[range], noise)),
        }
    }
}

/// The filter of the first states.
fn first<const M: usize>(leaps: &[Leap<STIFF>], noise: &filter::Noise) -> filter::Filter<M> {
    let leaps: Vec<Leap<M>> = leaps.iter().map(Leap::first).collect();
    filter::Filter::new(&leaps, noise)
}

impl Gains {
    /// See [`filter::Filter::whiten`].
    pub fn whiten(&self, angles: &mut [f64]) {
        match self {
            Self::Plain(filter) => filter.whiten(angles),
            Self::Drifting(filter) => filter.whiten(angles),
            Self::Stiff(filter) => filter.whiten(angles),
            Self::Sprung(filter) => filter.whiten(angles),
        }
    }

    /// See [`filter::Filter::whiten_from`].
    pub fn whiten_from(&self, first: usize, angles: &mut [f64]) {
        match self {
            Self::Plain(filter) => filter.whiten_from(first, angles),
            Self::Drifting(filter) => filter.whiten_from(first, angles),
            Self::Stiff(filter) => filter.whiten_from(first, angles),
            Self::Sprung(filter) => filter.whiten_from(first, angles),
        }
    }

    /// See [`filter::Filter::colour`].
    pub fn colour(&self, white: &mut [f64]) {
        match self {
            Self::Plain(filter) => filter.colour(white),
            Self::Drifting(filter) => filter.colour(white),
            Self::Stiff(filter) => filter.colour(white),
            Self::Sprung(filter) => filter.colour(white),
        }
    }

    /// See [`filter::Filter::transposed`].
    pub fn transposed(&self, white: &mut [f64]) {
        match self {
            Self::Plain(filter) => filter.transposed(white),
            Self::Drifting(filter) => filter.transposed(white),
            Self::Stiff(filter) => filter.transposed(white),
            Self::Sprung(filter) => filter.transposed(white),
        }
    }

    /// See [`filter::Filter::whiten_rows`].
    pub fn whiten_rows(&self, rows: &mut [Vec<f64>]) {
        match self {
            Self::Plain(filter) => filter.whiten_rows(rows),
            Self::Drifting(filter) => filter.whiten_rows(rows),
            Self::Stiff(filter) => filter.whiten_rows(rows),
            Self::Sprung(filter) => filter.whiten_rows(rows),
        }
    }

    /// See [`filter::Filter::transposed_rows`].
    pub fn transposed_rows(&self, rows: &mut [Vec<f64>]) {
        match self {
            Self::Plain(filter) => filter.transposed_rows(rows),
            Self::Drifting(filter) => filter.transposed_rows(rows),
            Self::Stiff(filter) => filter.transposed_rows(rows),
            Self::Sprung(filter) => filter.transposed_rows(rows),
        }
    }

    /// See [`filter::Filter::scales`].
    #[must_use]
    pub fn scales(&self) -> Vec<f64> {
        match self {
            Self::Plain(filter) => filter.scales().collect(),
            Self::Drifting(filter) => filter.scales().collect(),
            Self::Stiff(filter) => filter.scales().collect(),
            Self::Sprung(filter) => filter.scales().collect(),
        }
    }
}

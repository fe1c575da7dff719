//! What accelerations make of a shaft's angle and speed along its course.

use std::ops::Range;

use super::law::{Law, sign};
use crate::diagnose::course::Course;
use crate::effect::Here;

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

/// Parts of a time that are short beside a motion of a rate, rad/s: its phase goes by 0.35 rad in each, where Simpson's rule is right to
/// some millionths. 256 at the most bound the time that it takes.
pub(super) fn parts(rate: f64, h: f64) -> f64 {
    (rate * h / 0.35).ceil().clamp(1.0, 256.0)
}

impl Plant {
    /// Of a law along a course.
    #[must_use]
    pub fn new(law: Law, course: &Course) -> Self {
        let each = (0..course.len()).map(|at| {
            let before = at.saturating_sub(1);
            let speed = 0.5 * (course.speed[at] + course.speed[before]);
            let slope = law.friction(speed).1;
            let (from, until) = (course.time_s[before], course.time_s[at]);
            let b = law.viscous + law.share_on(from, until) * law.stiffness + slope;
            let h = until - from;
            (slope, (b, [reach(b, h), reach(b, 0.5 * h)]))
        });
        let (slopes, (damping, reaches)) = each.unzip();
        Self {
            law,
            damping,
            slopes,
            reaches,
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
        let times = &course.time_s;
        let at = times.partition_point(|time_s| *time_s < here.inside_s);
        let slope = self.slopes.get(at).copied().unwrap_or(0.0);
        slope * here.speed - self.law.friction(here.speed).0 * here.way
    }

    /// Angle that an acceleration makes at each edge of a range, rad, from rest at the first. `rate` is how fast the acceleration's phase
    /// may go, rad/s, at a speed; `breaks` are instants at which it jumps, s, by time.
    pub fn response_over(
        &self,
        range: Range<usize>,
        course: &Course,
        acceleration: impl Fn(Here) -> f64,
        rate: impl Fn(f64) -> f64,
        breaks: &[f64],
    ) -> Vec<f64> {
        let push = |here: Here| [acceleration(here)];
        let [out] = self.responses(range, course, false, push, rate, breaks);
        out.iter().map(|[angle, _]| *angle).collect()
    }

    /// Angle and speed that several accelerations make; they see the speed that was foretold, or the one that was.
    pub fn responses<const K: usize>(
        &self,
        range: Range<usize>,
        course: &Course,
        foretold: bool,
        acceleration: impl Fn(Here) -> [f64; K],
        rate: impl Fn(f64) -> f64,
        breaks: &[f64],
    ) -> [Vec<Motion>; K] {
        let pushed = Pushed {
            plant: self,
            course,
            foretold,
            acceleration,
            rate,
        };
        let mut out = [(); K].map(|()| vec![Motion::default(); range.len()]);
        let mut states = [[0.0; 4]; K];
        // What acts at the start of an interval is what did at the end of the last one, unless it jumps.
        let mut push = None;
        let begins = course.time_s.get(range.start).copied().unwrap_or(0.0);
        let mut next = breaks.partition_point(|&time| time <= begins);
        for at in range.start + 1..range.end {
            let (mut begun, until) = (course.time_s[at - 1], course.time_s[at]);
            let within = breaks[next..].partition_point(|&time| time <= until);
            let stops = breaks[next..next + within].iter().chain([&until]);
            for &stop in stops {
                if stop > begun {
                    let before = push.filter(|_| breaks.is_empty());
                    push = Some(pushed.over(at, [begun, stop], &mut states, before));
                    begun = stop;
                }
            }
            next += within;
            for (out, state) in out.iter_mut().zip(&states) {
                out[at - range.start] = [state[0], state[1]];
            }
        }
        out
    }

    /// How a free course is damped over the interval that ends at an edge, 1/s: an unknown drive keeps it up.
    pub(super) fn fades(&self, at: usize) -> f64 {
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
        let angle = |at: usize| {
            let h = course.time_s[at] - course.time_s[at.saturating_sub(1)];
            let (reach, stays) = reach(self.fades(at), h);
            angle += reach * speed;
            speed *= stays;
            angle
        };
        (0..course.len()).map(angle).collect()
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
            let (r, stays) = self.reaches[at][0];
            // Angle and speed that a unit acceleration over the interval gives.
            out[at] = swept(self.damping[at], h, r) * angle + r * speed;
            speed = r * angle + stays * speed;
        }
        out
    }
}

/// What pushes a shaft along its course.
struct Pushed<'a, A, R> {
    plant: &'a Plant,
    course: &'a Course,
    foretold: bool,
    acceleration: A,
    rate: R,
}

impl<A, R: Fn(f64) -> f64> Pushed<'_, A, R> {
    /// Takes states through a part of the interval that ends at an edge; gives what acts at its end.
    fn over<const K: usize>(
        &self,
        at: usize,
        [begun, stop]: [f64; 2],
        states: &mut [[f64; 4]; K],
        before: Option<[f64; K]>,
    ) -> [f64; K]
    where
        A: Fn(Here) -> [f64; K],
    {
        let (plant, course) = (self.plant, self.course);
        let mode = plant.law.mode.as_ref();
        let (from, until) = (course.time_s[at - 1], course.time_s[at]);
        let (h, length) = (until - from, stop - begun);
        let speed = course.speed[at].abs().max(course.speed[at - 1].abs());
        let here_on = plant.law.share_on(begun, stop) - plant.law.share_on(from, until);
        let b = plant.damping[at] + here_on * plant.law.stiffness;
        let rate = (self.rate)(speed).abs() + mode.map_or(0.0, |mode| mode.rate(b));
        let parts = parts(rate, length);
        let step = length / parts;
        let [whole, half] = if step == h && here_on == 0.0 {
            plant.reaches[at]
        } else {
            [reach(b, step), reach(b, 0.5 * step)]
        };
        let inside_s = 0.5 * (begun + stop);
        // On which side of a standstill the part is, its ends do not say.
        let way = sign(course.within(at, (inside_s - from) / h).1);
        let foretold = self.foretold.then_some(course.steady[at]);
        let here = |time_s: f64| {
            let (angle, speed) = course.within(at, (time_s - from) / h);
            (self.acceleration)(Here {
                time_s,
                inside_s,
                angle,
                speed: foretold.unwrap_or(speed),
                way,
            })
        };
        let mut push = before.unwrap_or_else(|| here(begun));
        for part in 0..parts as usize {
            let start = begun + step * part as f64;
            let (middle, last) = (here(start + 0.5 * step), here(start + step));
            for (k, state) in states.iter_mut().enumerate() {
                let (push, middle, last) = (push[k], middle[k], last[k]);
                *state = match mode {
                    Some(mode) => mode.swung(b, step, *state, [push, middle, last]),
                    None => {
                        let [angle, speed, ..] = *state;
                        let reached = whole.0 * push + 4.0 * half.0 * middle;
                        let kept = whole.1 * push + 4.0 * half.1 * middle + last;
                        let sixth = step / 6.0;
                        let angle = angle + whole.0 * speed + sixth * reached;
                        [angle, whole.1 * speed + sixth * kept, 0.0, 0.0]
                    }
                };
            }
            push = last;
        }
        push
    }
}

/// Angle that a speed makes over a time, and what stays of the speed.
#[inline]
pub(super) fn reach(b: f64, h: f64) -> (f64, f64) {
    let x = b * h;
    if x.abs() < 1e-4 {
        (h * (1.0 - 0.5 * x), 1.0 - x + 0.5 * x * x)
    } else {
        let forgotten = -(-x).exp_m1();
        (forgotten / b, 1.0 - forgotten)
    }
}

/// Angle that a unit acceleration makes over a time in which a unit speed makes the angle `r`.
pub(super) fn swept(b: f64, h: f64, r: f64) -> f64 {
    if (b * h).abs() < 1e-3 {
        0.5 * h * h * (1.0 - b * h / 3.0)
    } else {
        (h - r) / b
    }
}

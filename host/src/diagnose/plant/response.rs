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
    /// Angle of a speed and what stays of it, over each interval.
    reaches: Vec<(f64, f64)>,
}

/// Parts of a time that are short beside a motion of a rate, rad/s: its phase goes by 0.35 rad in each, where Simpson's rule is right to
/// some millionths. 256 at the most bound the time that it takes.
pub(super) fn parts(rate: f64, h: f64) -> f64 {
    (rate * h / 0.35).ceil().clamp(1.0, 256.0)
}

/// Where in a part of a time a motion is looked at, as shares of it, with weights, and in how many parts, for a phase that goes by so much,
/// rad. Gauss's rules are right to some millionths with fewer points than Simpson's (M. Abramowitz, I. A. Stegun, Handbook of Mathematical
/// Functions, 25.4.29).
fn rule(phase: f64) -> (&'static [(f64, f64)], f64) {
    const TWO: [(f64, f64); 2] = [
        (0.211_324_865_405_187_1, 0.5),
        (0.788_675_134_594_812_9, 0.5),
    ];
    const THREE: [(f64, f64); 3] = [
        (0.112_701_665_379_258_3, 5.0 / 18.0),
        (0.5, 4.0 / 9.0),
        (0.887_298_334_620_741_7, 5.0 / 18.0),
    ];
    const FOUR: [(f64, f64); 4] = [
        (0.069_431_844_202_973_71, 0.173_927_422_568_726_9),
        (0.330_009_478_207_571_9, 0.326_072_577_431_273_1),
        (0.669_990_521_792_428_1, 0.326_072_577_431_273_1),
        (0.930_568_155_797_026_3, 0.173_927_422_568_726_9),
    ];
    match phase {
        ..0.35 => (&TWO, 1.0),
        ..1.4 => (&THREE, 1.0),
        _ => (&FOUR, (phase / 3.0).ceil().min(64.0)),
    }
}

impl Plant {
    /// Of a law along a course.
    pub fn new(law: Law, course: &Course) -> Self {
        let each = (0..course.len()).map(|at| {
            let before = at.saturating_sub(1);
            let speed = 0.5 * (course.speed[at] + course.speed[before]);
            let slope = law.friction(speed).1;
            let (from, until) = (course.time_s[before], course.time_s[at]);
            let b = law.viscous + law.share_on(from, until) * law.stiffness + slope;
            let h = until - from;
            (slope, (b, reach(b, h)))
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
                    push = pushed.over(at, [begun, stop], &mut states, before);
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

    /// Angle, s, and speed at each edge of a shaft that starts with unit speed and is not pushed.
    pub fn fading(&self, course: &Course) -> Vec<Motion> {
        let (mut angle, mut speed) = (0.0, 1.0);
        let motion = |at: usize| {
            let h = course.time_s[at] - course.time_s[at.saturating_sub(1)];
            let (reach, stays) = reach(self.fades(at), h);
            angle += reach * speed;
            speed *= stays;
            [angle, speed]
        };
        (0..course.len()).map(motion).collect()
    }

    /// How sensitive a score is to an acceleration over each interval: the transposed of [`Self::response_over`] for one that is even over
    /// it. `score` is what one rad at each edge adds to the score.
    pub fn sensitivity(&self, course: &Course, score: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; score.len()];
        let (mut angle, mut speed) = (0.0, 0.0);
        for at in (1..score.len()).rev() {
            angle += score[at];
            let h = course.time_s[at] - course.time_s[at - 1];
            let (r, stays) = self.reaches[at];
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
    /// Takes states through a part of the interval that ends at an edge; gives what acts at its end where the next one begins with that.
    fn over<const K: usize>(
        &self,
        at: usize,
        [begun, stop]: [f64; 2],
        states: &mut [[f64; 4]; K],
        before: Option<[f64; K]>,
    ) -> Option<[f64; K]>
    where
        A: Fn(Here) -> [f64; K],
    {
        let (plant, course) = (self.plant, self.course);
        let mode = plant.law.mode.as_ref();
        let (from, until) = (course.time_s[at - 1], course.time_s[at]);
        let (h, length) = (until - from, stop - begun);
        let inside_s = 0.5 * (begun + stop);
        let (_, inside) = course.within(at, (inside_s - from) / h);
        let ends = course.speed[at].abs().max(course.speed[at - 1].abs());
        let speed = ends.max(inside.abs());
        let here_on = plant.law.share_on(begun, stop) - plant.law.share_on(from, until);
        let b = plant.damping[at] + here_on * plant.law.stiffness;
        let rate = (self.rate)(speed).abs() + mode.map_or(0.0, |mode| mode.rate(b));
        // On which side of a standstill the part is, its ends do not say.
        let way = sign(inside);
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
        let Some(mode) = mode else {
            let (nodes, parts) = rule(rate * length);
            let step = length / parts;
            let (whole, kept) = reach(b, step);
            for part in 0..parts as usize {
                let start = begun + step * part as f64;
                for [angle, speed, ..] in states.iter_mut() {
                    *angle += whole * *speed;
                    *speed *= kept;
                }
                for (node, weight) in nodes {
                    let (reach, kept) = reach(b, step * (1.0 - node));
                    let (reach, kept) = (weight * step * reach, weight * step * kept);
                    let pushes = here(start + node * step);
                    for ([angle, speed, ..], push) in states.iter_mut().zip(pushes) {
                        *angle += reach * push;
                        *speed += kept * push;
                    }
                }
            }
            return None;
        };
        let parts = parts(rate, length);
        let step = length / parts;
        let mut push = before.unwrap_or_else(|| here(begun));
        for part in 0..parts as usize {
            let start = begun + step * part as f64;
            let (middle, last) = (here(start + 0.5 * step), here(start + step));
            for (k, state) in states.iter_mut().enumerate() {
                *state = mode.swung(b, step, *state, [push[k], middle[k], last[k]]);
            }
            push = last;
        }
        Some(push)
    }
}

/// Angle that a speed makes over a time, and what stays of the speed.
#[inline]
pub(super) fn reach(b: f64, h: f64) -> (f64, f64) {
    let x = b * h;
    if x.abs() < 1e-2 {
        // To some 1e-13.
        let series = 1.0 - x / 2.0 * (1.0 - x / 3.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0)));
        (h * series, 1.0 - x * series)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_points_sum_a_wave_to_some_millionths_of_it() {
        let phases = [0.1, 0.34, 0.36, 1.0, 1.39, 1.41, 2.9, 3.1, 7.3, 40.0];
        for phase in phases {
            let (nodes, parts) = rule(phase);
            let each = (0..parts as usize).flat_map(|part| {
                let at = move |(node, weight): &(f64, f64)| {
                    let share = (part as f64 + node) / parts;
                    weight / parts * (phase * share + 0.4).sin()
                };
                nodes.iter().map(at)
            });
            let sum: f64 = each.sum();
            let closed = (0.4_f64.cos() - (phase + 0.4).cos()) / phase;
            assert!((sum - closed).abs() < 6e-6, "{phase}: {sum} {closed}");
        }
    }

    #[test]
    fn a_short_reach_and_a_long_one_meet() {
        let (b, h) = (2.0, 4.999e-3);
        let (short, long) = (reach(b, h), reach(b, h * 1.001));
        let forgotten = -(-b * h).exp_m1();
        assert!((short.0 / (forgotten / b) - 1.0).abs() < 1e-11);
        assert!((short.1 - (1.0 - forgotten)).abs() < 1e-12);
        assert!(long.0 > short.0 && long.1 < short.1);
    }
}

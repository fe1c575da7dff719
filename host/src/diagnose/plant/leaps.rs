//! How a shaft's state and its noise go from edge to edge, and the filters that this makes.

use std::ops::Range;
use std::sync::Arc;

use super::law::Mode;
use super::response::{Motion, Plant, parts, reach, swept};
use crate::diagnose::corners::Corner;
use crate::diagnose::course::Course;
use crate::diagnose::filter::State::{Angle, Drift, Held, Speed, Swing, Swings};
use crate::diagnose::filter::{DRIFTING, Filter, Leap, Noise, State, Whitens};
use crate::diagnose::square::{Square, identity, product, through};

/// The filter of any shaft.
pub type Gains = Arc<dyn Whitens>;

impl Plant {
    /// Leaps of the filter of a stiff shaft, or of one with a mode.
    pub fn leaps<const N: usize>(&self, course: &Course) -> Vec<Leap<N>> {
        let law = &self.law;
        let forgets = law.viscous + law.hold.forgets;
        let kept = law.undriven && !law.hold.loose && law.hold_s <= 0.0 && forgets > 0.0;
        let leap = |at: usize| {
            let before = at.saturating_sub(1);
            let h = (course.time_s[at] - course.time_s[before]).max(0.0);
            let b = self.damping[at];
            // Where an unknown drive keeps a speed, a slow drift of the acceleration changes that one.
            let (way, torque, drifts) = if kept {
                let b = b - law.hold.stiffness + law.hold.forgets;
                (kept_up(b, h), self.white(b, h), Held)
            } else {
                let (way, torque) = self.spread(self.fades(at), course.time_s[at], h);
                (way, torque, Speed)
            };
            let load = law.mode.filter(|mode| mode.load > 0.0).map(|mode| {
                let far = [(Swings, mode.load.sqrt())];
                Box::new(self.stirred(&mode, b, h, &far))
            });
            Leap {
                way,
                torque,
                drift: drift_noise(drifts, h),
                load,
                speed: course.speed[at],
                h,
                doubt_s: course.doubt_s[at],
                kept,
                ..Leap::default()
            }
        };
        (0..course.len()).map(leap).collect()
    }

    /// Transition and covariance of unit torque noise over a time that ends at an instant.
    fn spread<const N: usize>(&self, b: f64, ends_s: f64, h: f64) -> (Square<N>, Square<N>) {
        let hold = self.law.hold_s;
        // Over more than 6 steps of its grid the noise is as good as white.
        if hold <= 0.0 || h > 6.0 * hold {
            return (self.way(b, h, false), self.white(b, h));
        }
        // The noise's grid: a value is held over each step of it.
        let mut way = identity::<N>();
        let mut torque = Square::default();
        let mut now = ends_s - h;
        let mut grid = (now / hold).floor() + 1.0;
        loop {
            let stop = (grid * hold).min(ends_s);
            if stop > now {
                let part = self.way::<N>(b, stop - now, true);
                torque = through(&part, &torque);
                way = product(&part, &way);
            }
            if stop >= ends_s {
                break;
            }
            // A new value: nothing of the old one stays.
            way.0[Held as usize] = [0.0; N];
            torque.0[Held as usize] = [0.0; N];
            torque.0.iter_mut().for_each(|row| row[Held as usize] = 0.0);
            torque[(Held, Held)] = 1.0 / hold;
            now = stop;
            grid += 1.0;
        }
        (way, torque)
    }

    /// How a state goes on; with `held`, the held torque pushes.
    fn way<const N: usize>(&self, b: f64, h: f64, held: bool) -> Square<N> {
        let mut way = identity::<N>();
        if !held {
            way[(Held, Held)] = 0.0;
        }
        let pushed = &[Drift, Held][..1 + usize::from(held)];
        if let Some(mode) = &self.law.mode {
            let parts = parts(mode.rate(b), h);
            let places = [Angle, Speed, Swing, Swings];
            let mut column = |column: State, mut state: [f64; 4], push: f64| {
                for _ in 0..parts as usize {
                    state = mode.swung(b, h / parts, state, [push; 3]);
                }
                for (row, value) in places.into_iter().zip(state) {
                    way[(row, column)] = value;
                }
            };
            for (place, start) in places.into_iter().zip(identity().0) {
                column(place, start, 0.0);
            }
            for &place in pushed {
                column(place, [0.0; 4], 1.0);
            }
        } else {
            rigid(&mut way, b, h, pushed);
        }
        way
    }

    /// Covariance that unit white torque noise makes over a time.
    fn white<const N: usize>(&self, b: f64, h: f64) -> Square<N> {
        if let Some(mode) = &self.law.mode {
            let near = [(Speed, 1.0 + mode.ratio), (Swings, mode.ratio)];
            return self.stirred(mode, b, h, &near);
        }
        jostled(b, h)
    }

    /// Covariance that white noise makes over a time of two masses, pushing states by so much: pushes in the middle of short parts.
    fn stirred<const N: usize>(
        &self,
        mode: &Mode,
        b: f64,
        h: f64,
        pushed: &[(State, f64)],
    ) -> Square<N> {
        let mut q = Square::default();
        let parts = parts(mode.rate(0.0), h).clamp(4.0, 32.0);
        let step = h / parts;
        let part = self.way(b, step, false);
        for _ in 0..parts as usize {
            q = through(&part, &q);
            for (row, one) in pushed {
                for (column, other) in pushed {
                    q[(*row, *column)] += step * one * other;
                }
            }
        }
        q
    }
}

/// The leap of a stiff shaft that nothing damps.
pub fn free<const N: usize>(h: f64) -> Leap<N> {
    let mut way = identity();
    rigid(&mut way, 0.0, h, &[Drift]);
    Leap {
        way,
        torque: jostled(0.0, h),
        drift: drift_noise(Speed, h),
        speed: 1.0,
        h,
        ..Leap::default()
    }
}

/// How angle and speed of a stiff shaft go on over a time, where some states push it.
fn rigid<const N: usize>(way: &mut Square<N>, b: f64, h: f64, pushed: &[State]) {
    let (r, stays) = reach(b, h);
    way[(Angle, Speed)] = r;
    way[(Speed, Speed)] = stays;
    for &place in pushed {
        way[(Angle, place)] = swept(b, h, r);
        way[(Speed, place)] = r;
    }
}

/// Covariance that unit white torque noise gives a stiff shaft over a time.
fn jostled<const N: usize>(b: f64, h: f64) -> Square<N> {
    let mut q = Square::default();
    let [angle, both, speed] = stir(b * h);
    q[(Angle, Angle)] = h * h * h * angle;
    q[(Angle, Speed)] = h * h * both;
    q[(Speed, Angle)] = q[(Angle, Speed)];
    q[(Speed, Speed)] = h * speed;
    q
}

/// How a state goes on over a time where an unknown drive keeps a speed: torque noise makes another one beside it, which friction and
/// drive damp.
fn kept_up<const N: usize>(b: f64, h: f64) -> Square<N> {
    let mut way = identity();
    rigid(&mut way, b, h, &[]);
    way[(Angle, Held)] = h;
    way[(Angle, Drift)] = 0.5 * h * h;
    way[(Held, Drift)] = h;
    way
}

/// Covariance that a unit random walk of the acceleration makes over a time, by way of a speed.
fn drift_noise<const N: usize>(speed: State, h: f64) -> Square<N> {
    let mut q = Square::default();
    let h2 = h * h;
    let (aa, av, am) = (h2 * h2 * h / 20.0, h2 * h2 / 8.0, h2 * h / 6.0);
    let (vv, vm, mm) = (h2 * h / 3.0, h2 / 2.0, h);
    let all = [[aa, av, am], [av, vv, vm], [am, vm, mm]];
    let places = [Angle, speed, Drift];
    for (row, values) in places.into_iter().zip(all) {
        for (column, value) in places.into_iter().zip(values) {
            q[(row, column)] = value;
        }
    }
    q
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

/// Change of angle, rad, and speed, rad/s, that the course within an interval leaves open.
#[derive(Clone, Copy, Debug)]
pub struct Jolt {
    /// Edge that ends the interval.
    pub at: usize,
    /// By torques that are known.
    pub known: Motion,
    /// Of the speed by torques that nobody has found yet, for unit of [`Noise::unseen`].
    pub unseen: f64,
}

/// The leaps of either shaft.
#[derive(Clone, Debug)]
pub enum Leaps {
    /// Stiff.
    Stiff(Vec<Leap<{ Held.and_before() }>>),
    /// With a mode.
    Sprung(Vec<Leap<{ Swings.and_before() }>>),
}

/// The same of the leaps of either shaft.
macro_rules! either {
    ($all:expr, $leaps:ident => $of:expr) => {
        match $all {
            Leaps::Stiff($leaps) => $of,
            Leaps::Sprung($leaps) => $of,
        }
    };
}

impl Leaps {
    /// Of a plant.
    pub fn of(plant: &Plant, course: &Course) -> Self {
        match plant.law.mode {
            None => Self::Stiff(plant.leaps(course)),
            Some(_) => Self::Sprung(plant.leaps(course)),
        }
    }

    /// Leaves open how angle and speed changed within intervals.
    pub fn jolt(&mut self, jolts: &[Jolt]) {
        either!(self, leaps => for jolt in jolts {
            let leap = &mut leaps[jolt.at];
            (leap.jolt, leap.unseen) = (jolt.known, jolt.unseen);
        });
    }

    /// Whether torques that nobody has found yet leave any interval open.
    pub fn has_unseen(&self) -> bool {
        either!(self, leaps => leaps.iter().any(|leap| leap.unseen > 0.0))
    }

    /// Leaves the course open by corners, and by no others: the interval of each as far as it jumps.
    pub fn bend(&mut self, corners: &[Corner], time_s: &[f64]) {
        either!(self, leaps => {
            leaps.iter_mut().for_each(|leap| leap.corner = [0.0; 2]);
            for corner in corners {
                let at = time_s.partition_point(|time| *time < corner.time_s);
                if let Some(leap) = leaps.get_mut(at).filter(|_| at > 0) {
                    let h = time_s[at] - time_s[at - 1];
                    leap.corner[0] += corner.jump * corner.jump / h;
                    leap.corner[1] += corner.kick * corner.kick;
                }
            }
        });
    }

    /// Mean of the speed's size over the edges, rad/s.
    pub fn speed(&self) -> f64 {
        either!(self, leaps => {
            let sum: f64 = leaps.iter().map(|leap| leap.speed.abs()).sum();
            sum / leaps.len().max(1) as f64
        })
    }

    /// The filter for a noise over a range of edges.
    pub fn filter(&self, range: Range<usize>, noise: &Noise) -> Gains {
        let leaps = match self {
            Self::Stiff(leaps) => &leaps[range],
            Self::Sprung(leaps) => {
                return Arc::new(Filter::<{ Swings.and_before() }>::new(&leaps[range], noise));
            }
        };
        if noise.ring.density > 0.0 {
            return Arc::new(Filter::<{ Swings.and_before() }>::new(leaps, noise));
        }
        // Fewer states take less time.
        match (leaps.iter().any(Leap::is_held), noise.drift > 0.0) {
            (true, _) => Arc::new(Filter::<{ Held.and_before() }>::new(leaps, noise)),
            (false, true) => Arc::new(Filter::<DRIFTING>::new(leaps, noise)),
            (false, false) => Arc::new(Filter::<{ Speed.and_before() }>::new(leaps, noise)),
        }
    }
}

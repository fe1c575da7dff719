//! An effect: where it enters (site), what it follows (carrier), how its size goes (growth). One function gives what it does to edges.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::course::Course;
use super::declared::Asked;
use super::plant::{Here, Plant, sign};
use super::record::{Change, Record};

/// Which edges it is on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct On {
    /// The one channel; all where none.
    pub channel: Option<u8>,
    /// Rises only or falls only; both where none.
    pub rises: Option<bool>,
}

impl On {
    /// All edges.
    pub const ALL: Self = Self {
        channel: None,
        rises: None,
    };

    /// Whether a change is one of them.
    #[must_use]
    pub fn has(self, change: Change) -> bool {
        self.channel.is_none_or(|channel| channel == change.channel)
            && self.rises.is_none_or(|rises| rises == change.rises)
    }
}

/// Where an effect enters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Site {
    /// A torque on the shaft, N m.
    Torque,
    /// The speed that an open-loop drive asks for, as a share of it.
    Drive,
    /// An angle of the edge, rad: it comes so much before its place on the grid.
    Disc(On),
    /// The comparator's level, rad: rises come later, falls earlier. The flank of [`On`] is not used.
    Level(On),
    /// A time of the stamp, s: it comes so much later. Flanks are those of the signal.
    Stamp(On),
    /// A number that the twin declares, as the board counts those that it corrects.
    Declared(u16),
}

/// What an effect follows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Carrier {
    /// Nothing: always there.
    Steady,
    /// The shaft's angle: cycles a turn. Sizes of cosine and sine.
    Order(f64),
    /// Time: Hz. Sizes of cosine and sine.
    Tone(f64),
    /// Time, with a frequency that goes evenly from one at time 0: Hz and Hz a second.
    Chirp(f64, f64),
    /// A place of the disc: middle and sigma of a bump, rad.
    Bump(f64, f64),
    /// An instant, s, and one at which it ends.
    Window(f64, f64),
    /// An instant, s, and the time constant, s, with which it settles.
    Settling(f64, f64),
    /// Time since the recording's zero, s.
    Time,
    /// Direction of motion: half forward, minus half in reverse.
    Direction,
    /// Speed: sign(w) |w|^p, against the motion.
    Power(f64),
    /// Speed: sign(w) exp(-(w/ws)^2), against the motion.
    Stribeck(f64),
}

/// How its size goes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Growth {
    /// It stays.
    Constant,
    /// 1 + rate t, 1/s.
    Even(f64),
    /// |w|^p, w in rad/s.
    Speed(f64),
    /// 1 + depth sin(2 pi f t + phase): Hz, depth and phase.
    Modulated(f64, f64, f64),
}

/// An effect without its sizes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Effect {
    /// Where it enters.
    pub site: Site,
    /// What it follows.
    pub carrier: Carrier,
    /// How its size goes.
    pub growth: Growth,
}

/// What an effect acts on.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    /// The edges.
    pub record: &'a Record,
    /// Where the shaft was.
    pub course: &'a Course,
    /// How it answers to a torque.
    pub plant: &'a Plant,
    /// What the drive asks for.
    pub asked: &'a Asked,
}

impl Effect {
    /// One that stays as it is.
    #[must_use]
    pub const fn new(site: Site, carrier: Carrier) -> Self {
        Self {
            site,
            carrier,
            growth: Growth::Constant,
        }
    }

    /// Numbers that size it: 1, or 2 for cosine and sine.
    #[must_use]
    pub const fn sizes(&self) -> usize {
        match self.carrier {
            Carrier::Order(_) | Carrier::Tone(_) | Carrier::Chirp(..) => 2,
            _ => 1,
        }
    }

    /// Its value at an instant, for unit of each size.
    #[must_use]
    #[inline]
    pub fn value(&self, here: Here) -> [f64; 2] {
        let one = |value: f64| [value, 0.0];
        let round = |phase: f64| {
            let (sin, cos) = phase.sin_cos();
            [cos, sin]
        };
        let t = here.time_s;
        let mut value = match self.carrier {
            Carrier::Steady => one(1.0),
            Carrier::Order(order) => round(order * here.angle),
            Carrier::Tone(f_hz) => round(TAU * f_hz * t),
            Carrier::Chirp(f_hz, rate) => round(TAU * (f_hz + 0.5 * rate * t) * t),
            Carrier::Bump(middle, sigma) => {
                let apart = here.angle - middle;
                let apart = (apart - TAU * (apart / TAU).round()) / sigma;
                one((-0.5 * apart * apart).exp())
            }
            Carrier::Window(from_s, until_s) => one(f64::from(u8::from(
                here.inside_s >= from_s && here.inside_s < until_s,
            ))),
            Carrier::Settling(from_s, tau_s) => one(-(-((t - from_s).max(0.0)) / tau_s).exp_m1()),
            Carrier::Time => one(t),
            Carrier::Direction => one(0.5 * sign(here.speed)),
            Carrier::Power(power) => one(-sign(here.speed) * here.speed.abs().powf(power)),
            Carrier::Stribeck(speed) => {
                let over = here.speed / speed;
                one(-sign(here.speed) * (-over * over).exp())
            }
        };
        let growth = match self.growth {
            Growth::Constant => return value,
            Growth::Even(rate) => 1.0 + rate * t,
            Growth::Speed(power) => here.speed.abs().powf(power),
            Growth::Modulated(f_hz, depth, phase) => 1.0 + depth * (TAU * f_hz * t + phase).sin(),
        };
        value.iter_mut().for_each(|value| *value *= growth);
        value
    }

    /// What it adds to the grid angle of each edge, rad, for unit of each size.
    #[must_use]
    pub fn columns(&self, scene: &Scene<'_>) -> Vec<Vec<f64>> {
        match self.site {
            Site::Torque | Site::Drive => self.pushed(scene),
            Site::Disc(_) | Site::Level(_) | Site::Stamp(_) | Site::Declared(_) => {
                let mut columns = vec![vec![0.0; scene.record.len()]; self.sizes()];
                for at in 0..scene.record.len() {
                    let by = self.by_edge(scene, at);
                    if by != 0.0 {
                        let value = self.value(scene.here(at, self));
                        for (column, value) in columns.iter_mut().zip(value) {
                            column[at] = by * value;
                        }
                    }
                }
                columns
            }
        }
    }

    /// Angle that one unit at its site is at an edge, rad.
    fn by_edge(&self, scene: &Scene<'_>, at: usize) -> f64 {
        let change = scene.record.change(at);
        match self.site {
            Site::Disc(on) if on.has(change) => {
                // A play holds marks back in either direction.
                if self.carrier == Carrier::Direction {
                    -1.0
                } else {
                    1.0
                }
            }
            Site::Level(on)
                if on.has(Change {
                    rises: true,
                    ..change
                }) || on.has(Change {
                    rises: false,
                    ..change
                }) =>
            {
                if change.rises {
                    -1.0
                } else {
                    1.0
                }
            }
            Site::Stamp(on) => {
                if on.has(scene.record.captured(at)) {
                    -scene.course.speed[at]
                } else {
                    0.0
                }
            }
            _ => 0.0,
        }
    }

    fn pushed(&self, scene: &Scene<'_>) -> Vec<Vec<f64>> {
        let rate = |speed: f64| match self.carrier {
            Carrier::Order(order) => order * speed,
            Carrier::Tone(f_hz) => TAU * f_hz,
            Carrier::Chirp(f_hz, rate) => {
                TAU * (f_hz.abs()
                    + (rate * scene.course.time_s.last().copied().unwrap_or(0.0)).abs())
            }
            Carrier::Bump(_, sigma) => speed / sigma,
            _ => 0.0,
        };
        let mut breaks = match self.carrier {
            Carrier::Window(from_s, until_s) => vec![from_s, until_s],
            Carrier::Settling(from_s, _) => vec![from_s],
            Carrier::Direction | Carrier::Power(_) | Carrier::Stribeck(_) => {
                scene.course.reversals_s.clone()
            }
            _ => Vec::new(),
        };
        breaks.retain(|time| time.is_finite());
        let law = &scene.plant.law;
        let all = 0..scene.course.len();
        let responses = match self.site {
            Site::Drive => {
                let change = |here: Here| {
                    if here.inside_s >= law.off_s {
                        return [0.0; 2];
                    }
                    // What the drive adds to follow: J dw/dt, and damping times what it asks for on top.
                    let (asked, rate) = scene.asked.at(here.time_s, here.inside_s);
                    let by = 1e-6 * (1.0 + here.time_s.abs());
                    let at = |time_s: f64| self.value(Here { time_s, ..here });
                    let (before, value, after) =
                        (at(here.time_s - by), at(here.time_s), at(here.time_s + by));
                    let damping = law.damping(here.inside_s, here.speed);
                    [0, 1].map(|size| {
                        let change = (after[size] - before[size]) / (2.0 * by);
                        rate * value[size] + asked * change + damping * asked * value[size]
                    })
                };
                scene
                    .plant
                    .responses(all, scene.course, change, rate, &breaks)
            }
            _ => {
                let push = |here: Here| self.value(here).map(|torque| torque / law.inertia);
                scene
                    .plant
                    .responses(all, scene.course, push, rate, &breaks)
            }
        };
        responses.into_iter().take(self.sizes()).collect()
    }

    /// Its numbers that are searched, beside its sizes.
    #[must_use]
    pub fn knobs(&self) -> Vec<f64> {
        let mut knobs = match self.carrier {
            Carrier::Order(a) | Carrier::Tone(a) | Carrier::Stribeck(a) => vec![a],
            Carrier::Chirp(a, b)
            | Carrier::Bump(a, b)
            | Carrier::Window(a, b)
            | Carrier::Settling(a, b) => vec![a, b],
            Carrier::Steady | Carrier::Time | Carrier::Direction | Carrier::Power(_) => Vec::new(),
        };
        match self.growth {
            Growth::Constant => {}
            Growth::Even(a) | Growth::Speed(a) => knobs.push(a),
            Growth::Modulated(a, b, c) => knobs.extend([a, b, c]),
        }
        knobs
    }

    /// The same with other such numbers.
    #[must_use]
    pub fn with_knobs(&self, knobs: &[f64]) -> Self {
        let mut all = knobs.iter().copied();
        let mut next = |was: f64| all.next().unwrap_or(was);
        let carrier = match self.carrier {
            Carrier::Order(a) => Carrier::Order(next(a)),
            Carrier::Tone(a) => Carrier::Tone(next(a)),
            Carrier::Stribeck(a) => Carrier::Stribeck(next(a)),
            Carrier::Chirp(a, b) => Carrier::Chirp(next(a), next(b)),
            Carrier::Bump(a, b) => Carrier::Bump(next(a), next(b)),
            Carrier::Window(a, b) => Carrier::Window(next(a), next(b)),
            Carrier::Settling(a, b) => Carrier::Settling(next(a), next(b)),
            carrier => carrier,
        };
        let growth = match self.growth {
            Growth::Constant => Growth::Constant,
            Growth::Even(a) => Growth::Even(next(a)),
            Growth::Speed(a) => Growth::Speed(next(a)),
            Growth::Modulated(a, b, c) => Growth::Modulated(next(a), next(b), next(c)),
        };
        Self {
            site: self.site,
            carrier,
            growth,
        }
    }
}

impl Scene<'_> {
    /// The instant of an edge as an effect sees it: errors of the disc go with the grid, all else with the shaft, a run-out as well. What
    /// goes with time goes by when the edge was there, before any delay.
    #[must_use]
    #[inline]
    pub fn here(&self, at: usize, effect: &Effect) -> Here {
        let runs_out = matches!(effect.carrier, Carrier::Order(order) if order.fract() != 0.0);
        let angle = match effect.site {
            Site::Disc(_) if !runs_out => self.record.grid_rad(at),
            _ => self.course.angle[at],
        };
        let time_s = self.course.time_s[at] - self.course.late_s[at];
        Here {
            time_s,
            inside_s: time_s,
            angle,
            speed: self.course.speed[at],
        }
    }
}

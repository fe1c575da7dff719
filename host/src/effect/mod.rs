//! An effect: where it enters (site), what it follows (carrier), how its size goes (growth). Simulator and diagnosis both evaluate
//! [`Effect::value`].

pub mod number;
pub mod words;

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use number::{Number, Sloped};

/// Steepest power of the speed that a size goes with: no loss of a machine grows faster than the cube of the speed.
pub const STEEPEST: f64 = 3.0;

/// What changes at an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// 0 is A.
    pub channel: u8,
    /// Whether the level rises when the mark is passed forward.
    pub rises: bool,
}

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
    /// The speed that an open-loop drive asks for, as a share of it; the torque of an unknown drive, N m.
    Drive,
    /// An angle of the edge, rad: it comes so much before its place on the grid.
    Disc(On),
    /// The comparator's level, rad: rises come later, falls earlier. The flank of [`On`] is not used.
    Level(On),
    /// A time of the stamp, s: it comes so much later. Flanks are those of the signal.
    Stamp(On),
    /// A number that the twin declares, as the board counts those that it corrects; no twin has it as an effect.
    Declared(u16),
}

impl Site {
    /// Whether it moves the shaft, and not its edges alone.
    #[must_use]
    pub const fn pushes(self) -> bool {
        matches!(self, Self::Torque | Self::Drive)
    }

    /// Whether it moves all edges alike, or one channel or flank against the others; none of a declared number, which may be either.
    #[must_use]
    pub fn moves_all_alike(self) -> Option<bool> {
        match self {
            Self::Torque | Self::Drive => Some(true),
            Self::Disc(on) | Self::Stamp(on) => Some(on == On::ALL),
            Self::Level(_) => Some(false),
            Self::Declared(_) => None,
        }
    }
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
    /// Speed: sign(w) |w|^p, against the motion. Of torques that is friction, which an open-loop drive balances at the speed that it asks
    /// for, as it does all friction of its shaft.
    Power(f64),
    /// Speed: sign(w) exp(-(w/ws)^2), against the motion; balanced as well.
    Stribeck(f64),
}

/// Whether an order is exactly what it is, and so no number to be fitted: what a machine does each turn, or every two turns as a
/// four-stroke engine does.
#[must_use]
pub fn is_exact(order: f64) -> bool {
    (2.0 * order).fract() == 0.0
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
    /// The error that each mark of the disc has by itself, rad: by so much a wave finds it elsewhere than on the grid. Only what is fitted
    /// beside a wave of the disc goes so.
    Own,
    /// 1 - v / |w|, v in rad/s: nothing at the one speed at which a disc was learned, whose places have a delay's share of that speed in
    /// them. Only what is fitted beside such a disc goes so.
    Past(f64),
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
    /// The one recording that has it, by its place among those of the rig; all where none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub only: Option<u8>,
}

/// What an effect is evaluated at.
#[derive(Clone, Copy, Debug)]
pub struct Here<N = f64> {
    /// Time, s.
    pub time_s: N,
    /// A time near it on the same side of whatever jumps, s.
    pub inside_s: f64,
    /// Angle, rad.
    pub angle: N,
    /// Speed, rad/s.
    pub speed: N,
    /// Sign of the motion: -1, 0 or 1.
    pub way: f64,
}

impl Effect {
    /// One that stays as it is.
    #[must_use]
    pub const fn new(site: Site, carrier: Carrier) -> Self {
        Self {
            site,
            carrier,
            growth: Growth::Constant,
            only: None,
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
    pub fn value<N: Number>(&self, here: Here<N>) -> [N; 2] {
        let none = N::constant(0.0);
        let one = |value: N| [value, none];
        let round = |phase: N| {
            let (sin, cos) = phase.sin_cos();
            [cos, sin]
        };
        let t = here.time_s;
        // The speed's size, and a size that acts against the motion.
        let size = here.speed * here.way;
        let against = |value: N| one(value * -here.way);
        let value = match self.carrier {
            Carrier::Steady => one(N::constant(1.0)),
            Carrier::Order(order) => round(here.angle * order),
            Carrier::Tone(f_hz) => round(t * (TAU * f_hz)),
            Carrier::Chirp(f_hz, rate) => round((t * (0.5 * rate) + N::constant(f_hz)) * t * TAU),
            Carrier::Bump(middle, sigma) => {
                let apart = here.angle - N::constant(middle);
                let turns = (apart.value() / TAU).round();
                let apart = (apart - N::constant(TAU * turns)) * sigma.recip();
                one((apart * apart * -0.5).exp())
            }
            Carrier::Window(from_s, until_s) => one(N::constant(f64::from(u8::from(
                here.inside_s >= from_s && here.inside_s < until_s,
            )))),
            Carrier::Settling(from_s, _) if here.inside_s < from_s => one(none),
            Carrier::Settling(from_s, tau_s) => {
                let left = ((t - N::constant(from_s)) * -tau_s.recip()).exp();
                one(N::constant(1.0) - left)
            }
            Carrier::Time => one(t),
            Carrier::Direction => one(N::constant(0.5 * here.way)),
            Carrier::Power(power) => against(size.powf(power)),
            Carrier::Stribeck(speed) => {
                let over = here.speed * speed.recip();
                against((over * over * -1.0).exp())
            }
        };
        let growth = match self.growth {
            // That is known where the disc is.
            Growth::Constant | Growth::Own => return value,
            Growth::Even(rate) => t * rate + N::constant(1.0),
            Growth::Speed(power) => size.powf(power),
            Growth::Past(speed) => size.powf(-1.0) * -speed + N::constant(1.0),
            Growth::Modulated(f_hz, depth, phase) => {
                let turned = t * (TAU * f_hz) + N::constant(phase);
                turned.sin_cos().0 * depth + N::constant(1.0)
            }
        };
        value.map(|value| value * growth)
    }

    /// Its value at an instant for sizes.
    #[must_use]
    pub fn sized<N: Number>(&self, sizes: &[f64], here: Here<N>) -> N {
        let each = self.value(here).into_iter().zip(sizes);
        each.fold(N::constant(0.0), |sum, (value, size)| sum + value * *size)
    }

    /// How far a mark is passed before its place, rad, for unit of an effect of disc or level; 0 where it is none of those or not on the
    /// mark.
    #[must_use]
    pub fn ahead(&self, change: Change) -> f64 {
        match self.site {
            // A play holds marks back in either direction.
            Site::Disc(on) if on.has(change) && self.carrier == Carrier::Direction => -1.0,
            Site::Disc(on) if on.has(change) => 1.0,
            Site::Level(on) if on.channel.is_none_or(|one| one == change.channel) => {
                if change.rises { -1.0 } else { 1.0 }
            }
            _ => 0.0,
        }
    }

    /// Whether it is part of the disc: every turn repeats it, in either direction and at any speed.
    #[must_use]
    pub fn is_of_disc(&self) -> bool {
        let repeats = match self.carrier {
            Carrier::Steady | Carrier::Bump(..) => true,
            Carrier::Order(order) => order.fract() == 0.0,
            _ => false,
        };
        matches!(self.site, Site::Disc(_)) && self.growth == Growth::Constant && repeats
    }

    /// Whether it is friction.
    #[must_use]
    pub fn is_friction(&self) -> bool {
        let against = matches!(self.carrier, Carrier::Power(_) | Carrier::Stribeck(_));
        self.site == Site::Torque && against
    }

    /// Instants at which it jumps or kinks, s.
    #[must_use]
    pub fn instants_s(&self) -> Vec<f64> {
        let mut instants = match self.carrier {
            Carrier::Window(from_s, until_s) => vec![from_s, until_s],
            Carrier::Settling(from_s, _) => vec![from_s],
            _ => Vec::new(),
        };
        instants.retain(|time| time.is_finite());
        instants
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
            Growth::Constant | Growth::Own | Growth::Past(_) => {}
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
            growth @ (Growth::Constant | Growth::Own | Growth::Past(_)) => growth,
            Growth::Even(a) => Growth::Even(next(a)),
            Growth::Speed(a) => Growth::Speed(next(a)),
            Growth::Modulated(a, b, c) => Growth::Modulated(next(a), next(b), next(c)),
        };
        Self {
            site: self.site,
            carrier,
            growth,
            only: self.only,
        }
    }

    /// Whether it can be evaluated at all.
    #[must_use]
    pub fn is_possible(&self) -> bool {
        let grows = match self.growth {
            // What moves the shaft has to stay finite where it stands.
            Growth::Speed(power) if power < 0.0 && self.site.pushes() => false,
            Growth::Speed(power) => power.abs() <= STEEPEST,
            _ => true,
        };
        grows
            && match self.carrier {
                Carrier::Order(a) | Carrier::Tone(a) | Carrier::Stribeck(a) => a > 0.0,
                Carrier::Bump(_, sigma) => sigma > 1e-9 && sigma < 1.5,
                Carrier::Settling(_, tau) => tau > 0.0,
                Carrier::Window(from, until) => until > from,
                _ => true,
            }
    }
}

/// An instant with its slope along time, all else held: what the drive's speed changes by.
#[must_use]
pub fn along_time<N: Number>(here: Here<N>) -> Here<Sloped<N>> {
    let held = |at: N| Sloped {
        at,
        slope: N::constant(0.0),
    };
    Here {
        time_s: Sloped {
            at: here.time_s,
            slope: N::constant(1.0),
        },
        inside_s: here.inside_s,
        angle: held(here.angle),
        speed: held(here.speed),
        way: here.way,
    }
}

//! Effects that a twin declares by site, carrier and growth: those that push the shaft, as series over a step of the motion.

use std::f64::consts::TAU;

use super::taylor::{DEGREE, Series};
use crate::effect::number::{self, Number};
use crate::effect::{Carrier, Change, Effect, Growth, Here, Site, along_time};
use crate::twin::Twin;

/// Travel, rad, that a fractional power of the speed is held over where the shaft starts from rest: it has no series there.
const FROM_REST_RAD: f64 = 1e-13;

/// An effect with its sizes.
pub(super) type Sized = (Effect, Vec<f64>);

/// A twin's effects at sites, with their sizes.
pub(super) fn at(twin: &Twin, site: impl Fn(Site) -> bool) -> Vec<Sized> {
    let all = twin.effect.iter().map(|one| (one.effect(), one.sizes()));
    all.filter(|(effect, _)| site(effect.site)).collect()
}

/// Instants at which effects jump or kink, s, by time.
pub(super) fn instants(twin: &Twin) -> Vec<f64> {
    let each = twin.effect.iter().flat_map(|one| one.effect().instants_s());
    let mut instants: Vec<f64> = each.filter(|time| *time > 0.0).collect();
    instants.sort_by(f64::total_cmp);
    instants.dedup();
    instants
}

/// Where a step starts.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Start {
    /// Time, s.
    pub(super) time_s: f64,
    /// A time within the segment, s.
    pub(super) inside_s: f64,
    /// Angle, rad.
    pub(super) angle_rad: f64,
}

impl Start {
    /// The motion from here with terms 0 to `k` of its speed known.
    fn along(&self, k: usize, speed: &Series, way: f64) -> Here<number::Series> {
        let mut angle = [0.0; DEGREE];
        angle[0] = self.angle_rad;
        for j in 0..k {
            angle[j + 1] = speed[j] / (j as f64 + 1.0);
        }
        let mut time = [0.0; DEGREE];
        (time[0], time[1]) = (self.time_s, 1.0);
        Here {
            time_s: number::Series::new(&time[..=k]),
            inside_s: self.inside_s,
            angle: number::Series::new(&angle[..=k]),
            speed: number::Series::new(&speed[..=k]),
            way,
        }
    }
}

/// Effects that push the shaft.
#[derive(Clone, Debug)]
pub(super) struct Effects {
    /// Torques, sizes over the inertia.
    torques: Vec<Sized>,
    /// Changes of what the drive asks for.
    drives: Vec<Sized>,
}

impl Effects {
    /// Those of a twin.
    pub(super) fn new(twin: &Twin) -> Self {
        let mut torques = at(twin, |site| site == Site::Torque);
        let inertia = twin.shaft.inertia_or_one();
        for (_, sizes) in &mut torques {
            sizes.iter_mut().for_each(|size| *size /= inertia);
        }
        Self {
            torques,
            drives: at(twin, |site| site == Site::Drive),
        }
    }

    /// Whether there is none.
    pub(super) const fn is_empty(&self) -> bool {
        self.torques.is_empty() && self.drives.is_empty()
    }

    /// Whether the drive's speed is changed.
    pub(super) const fn drives(&self) -> bool {
        !self.drives.is_empty()
    }

    /// Term `k` of the acceleration by torques, terms 0 to `k` of the speed being known; `way` is the motion's sign.
    pub(super) fn term(&self, k: usize, start: &Start, speed: &Series, way: f64) -> f64 {
        if self.torques.is_empty() {
            return 0.0;
        }
        let along = start.along(k, speed, way);
        let each = self.torques.iter();
        each.map(|(effect, sizes)| effect.sized(sizes, along).terms[k])
            .sum()
    }

    /// Term `k` of the acceleration by which a drive that asks for a speed balances friction among the torques; `towards` is the sign of
    /// that speed.
    pub(super) fn balance(&self, k: usize, start: &Start, asked: &Series, towards: f64) -> f64 {
        let friction = self
            .torques
            .iter()
            .filter(|(effect, _)| effect.is_friction());
        let along = start.along(k, asked, towards);
        -friction
            .map(|(effect, sizes)| effect.sized(sizes, along).terms[k])
            .sum::<f64>()
    }

    /// Term `k` of what torques hold a standing shaft with: what of them is against either way that it might go, rad/s^2.
    pub(super) fn hold(&self, k: usize, start: &Start) -> f64 {
        let at = |way: f64| self.term(k, start, &[0.0; DEGREE], way);
        0.5 * (at(-1.0) - at(1.0))
    }

    /// Share by which the drive's speed is changed, and how fast that goes along time: terms 0 to `k`.
    pub(super) fn share(
        &self,
        k: usize,
        start: &Start,
        speed: &Series,
        way: f64,
    ) -> (number::Series, number::Series) {
        let along = along_time(start.along(k, speed, way));
        let none = (number::Series::constant(0.0), number::Series::constant(0.0));
        self.drives.iter().fold(none, |sum, (effect, sizes)| {
            let share = effect.sized(sizes, along);
            (sum.0 + share.at, sum.1 + share.slope)
        })
    }

    /// How far a step may go, rad, from a speed of the shaft and one that friction is balanced at: a bump shows in no series from afar.
    pub(super) fn reach_rad(&self, speed: f64, balanced: Option<f64>) -> f64 {
        let slowest = balanced.map_or(speed.abs(), |other| speed.abs().min(other.abs()));
        let all = self.torques.iter().chain(&self.drives);
        let reach = all.map(|(effect, _)| {
            let fractional = |power: f64| slowest <= number::NO_SERIES && power.fract() != 0.0;
            match (effect.carrier, effect.growth) {
                (Carrier::Power(power), _) | (_, Growth::Speed(power)) if fractional(power) => {
                    FROM_REST_RAD
                }
                (Carrier::Bump(_, sigma), _) => sigma,
                _ => f64::INFINITY,
            }
        });
        reach.fold(f64::INFINITY, f64::min)
    }

    /// Fastest rate of change along time, 1/s.
    pub(super) fn fastest(&self, now_s: f64) -> f64 {
        let all = self.torques.iter().chain(&self.drives);
        let rates = all.map(|(effect, _)| {
            let carrier = match effect.carrier {
                Carrier::Tone(f_hz) => TAU * f_hz,
                Carrier::Chirp(f_hz, rate) => TAU * (f_hz + rate * now_s).abs(),
                Carrier::Settling(_, tau_s) => 1.0 / tau_s,
                _ => 0.0,
            };
            let growth = match effect.growth {
                Growth::Modulated(f_hz, ..) => TAU * f_hz,
                _ => 0.0,
            };
            carrier + growth
        });
        rates.fold(0.0, f64::max)
    }

    /// Torques that swing evenly at a speed, rad/s: amplitude, rad/s^2, rate, rad/s, and phase at the start.
    pub(super) fn waves(&self, speed: f64, angle_rad: f64) -> Vec<(f64, f64, f64)> {
        let all = self.torques.iter().filter_map(|(effect, sizes)| {
            let (turning, from) = match (effect.carrier, effect.growth) {
                (Carrier::Order(order), Growth::Constant) => (order * speed, order * angle_rad),
                (Carrier::Tone(f_hz), Growth::Constant) => (TAU * f_hz, 0.0),
                _ => return None,
            };
            let (cos, sin) = (sizes[0], sizes[1]);
            Some((cos.hypot(sin), turning, from + libm::atan2(cos, sin)))
        });
        all.collect()
    }

    /// Share by which the drive's speed is changed at time 0, as if at that speed for long.
    pub(super) fn share_at_start(&self, speed: f64, angle_rad: f64) -> f64 {
        let start = Start {
            angle_rad,
            ..Start::default()
        };
        let mut series = [0.0; DEGREE];
        series[0] = speed;
        let way = super::shaft::sign(speed);
        self.share(0, &start, &series, way).0.value()
    }
}

/// A drive's speed changed by a share: term `k` of what it asks for and of the rate of that.
pub(super) fn changed(
    asked: &Series,
    (share, rate): &(number::Series, number::Series),
    k: usize,
) -> (f64, f64) {
    let next = |j: usize| match asked.get(j + 1) {
        Some(term) => term * (j as f64 + 1.0),
        None => 0.0,
    };
    let mut changed = (asked[k], next(k));
    for (j, asked) in asked.iter().enumerate().take(k + 1) {
        changed.0 += asked * share.terms[k - j];
        changed.1 += next(j) * share.terms[k - j] + asked * rate.terms[k - j];
    }
    changed
}

/// What effects that are part of the disc add to the error of an edge at a grid angle, rad.
pub(super) fn on_disc(effects: &[Sized], change: Change, grid_rad: f64) -> f64 {
    let still = Here {
        time_s: number::Series::constant(0.0),
        inside_s: 0.0,
        angle: number::Series::new(&[grid_rad]),
        speed: number::Series::constant(0.0),
        way: 0.0,
    };
    let each = effects.iter();
    each.map(|(effect, sizes)| effect.ahead(change) * effect.sized(sizes, still).value())
        .sum()
}

//! An effect that no section has a name for.

use serde::{Deserialize, Serialize};

use super::{Channel, Flank};
use crate::effect::{self, Carrier, Growth, On};

/// Where an effect enters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EffectSite {
    /// A torque on the shaft.
    Torque,
    /// The speed that an open-loop drive asks for, as a share of it.
    Drive,
    /// The place of marks on the disc.
    Disc,
    /// The comparator's level.
    Level,
    /// The time of stamps.
    Stamp,
}

impl EffectSite {
    /// The key of its size.
    #[must_use]
    pub const fn size_key(self) -> &'static str {
        match self {
            Self::Torque => "torque_n_m",
            Self::Drive => "fraction",
            Self::Disc | Self::Level => "shift_rad",
            Self::Stamp => "delay_s",
        }
    }
}

/// What an effect follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Follows {
    /// Nothing: it is always there.
    #[default]
    Nothing,
    /// The shaft's angle, some cycles a turn.
    Order,
    /// Time, at a frequency that may change evenly.
    Frequency,
    /// A place of the disc: a bump.
    Place,
    /// It is there from one instant to another.
    Window,
    /// It settles from an instant on.
    Settling,
    /// It grows evenly with time.
    Time,
    /// The direction of motion.
    Direction,
    /// A power of the speed, against the motion; of a torque, friction that an open-loop drive balances at the speed that it asks for.
    Speed,
    /// Against the motion, falling with the speed; balanced as well.
    Stribeck,
}

impl Follows {
    const fn is_nothing(&self) -> bool {
        matches!(self, Self::Nothing)
    }
}

/// `[[effect]]`: any effect by where it enters, what it follows and how its size grows, as `quadcal diagnose` writes what has no
/// section of its own. What follows an order or a frequency is size sin(x + phase).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeclaredEffect {
    /// Where it enters.
    pub site: EffectSite,
    /// The channel that it is on, of a disc, a level or stamps; all where left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channel: Option<Channel>,
    /// The edges that it is on, of a disc or stamps; both where left out. Of a disc as in forward motion, of stamps as captured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edge: Option<Flank>,
    /// What it follows.
    #[serde(default, skip_serializing_if = "Follows::is_nothing")]
    pub follows: Follows,
    /// Cycles a turn, of an order.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub order: Option<f64>,
    /// Frequency at time 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub f_hz: Option<f64>,
    /// By how much the frequency grows each second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_hz_s: Option<f64>,
    /// Middle of a bump on the disc.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle_rad: Option<f64>,
    /// Width of a bump: its sigma.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width_rad: Option<f64>,
    /// When a window or settling begins; a window without it was there before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from_s: Option<f64>,
    /// When a window ends; it stays where left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub until_s: Option<f64>,
    /// Time constant of settling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tau_s: Option<f64>,
    /// Power of the speed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power: Option<f64>,
    /// Speed over which a Stribeck effect falls.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stribeck_rad_s: Option<f64>,
    /// Its size as a torque, at 1 s of what follows time, at 1 rad/s of what follows a power of the speed; so are the other sizes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_n_m: Option<f64>,
    /// Its size as a share of the drive's speed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fraction: Option<f64>,
    /// Its size as an angle: marks of a disc come so much early, rises of a level late and falls early.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shift_rad: Option<f64>,
    /// Its size as a time that stamps come late.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_s: Option<f64>,
    /// Phase of an order or a frequency, at angle or time 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase_rad: Option<f64>,
    /// Growth with time: the size times 1 + rate t.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub growth_per_s: Option<f64>,
    /// Growth with the speed w: the size times |w in rad/s|^power.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_power: Option<f64>,
    /// Modulation: the size times 1 + depth sin(2 pi f t + phase).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub modulation_hz: Option<f64>,
    /// Its depth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub modulation_depth: Option<f64>,
    /// Its phase at time 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub modulation_phase_rad: Option<f64>,
}

impl DeclaredEffect {
    /// One that follows nothing, with no size.
    const fn at(site: EffectSite) -> Self {
        Self {
            site,
            channel: None,
            edge: None,
            follows: Follows::Nothing,
            order: None,
            f_hz: None,
            rate_hz_s: None,
            angle_rad: None,
            width_rad: None,
            from_s: None,
            until_s: None,
            tau_s: None,
            power: None,
            stribeck_rad_s: None,
            torque_n_m: None,
            fraction: None,
            shift_rad: None,
            delay_s: None,
            phase_rad: None,
            growth_per_s: None,
            speed_power: None,
            modulation_hz: None,
            modulation_depth: None,
            modulation_phase_rad: None,
        }
    }

    /// An effect with its sizes as a section declares it; none of a number that a twin declares elsewhere.
    #[must_use]
    pub fn of(effect: &effect::Effect, sizes: &[f64]) -> Option<Self> {
        let (site, on) = match effect.site {
            effect::Site::Torque => (EffectSite::Torque, On::ALL),
            effect::Site::Drive => (EffectSite::Drive, On::ALL),
            effect::Site::Disc(on) => (EffectSite::Disc, on),
            effect::Site::Level(on) => (EffectSite::Level, On { rises: None, ..on }),
            effect::Site::Stamp(on) => (EffectSite::Stamp, on),
            effect::Site::Declared(_) => return None,
        };
        let mut new = Self::at(site);
        new.channel = on.channel.map(Channel::numbered);
        new.edge = on
            .rises
            .map(|rises| if rises { Flank::Rise } else { Flank::Fall });
        let some = |time: f64| time.is_finite().then_some(time);
        new.follows = match effect.carrier {
            Carrier::Steady => Follows::Nothing,
            Carrier::Order(order) => {
                new.order = Some(order);
                Follows::Order
            }
            Carrier::Tone(f_hz) => {
                new.f_hz = Some(f_hz);
                Follows::Frequency
            }
            Carrier::Chirp(f_hz, rate) => {
                (new.f_hz, new.rate_hz_s) = (Some(f_hz), Some(rate));
                Follows::Frequency
            }
            Carrier::Bump(angle, width) => {
                (new.angle_rad, new.width_rad) = (Some(angle), Some(width));
                Follows::Place
            }
            Carrier::Window(from_s, until_s) => {
                (new.from_s, new.until_s) = (some(from_s), some(until_s));
                Follows::Window
            }
            Carrier::Settling(from_s, tau_s) => {
                (new.from_s, new.tau_s) = (Some(from_s), Some(tau_s));
                Follows::Settling
            }
            Carrier::Time => Follows::Time,
            Carrier::Direction => Follows::Direction,
            Carrier::Power(power) => {
                new.power = Some(power);
                Follows::Speed
            }
            Carrier::Stribeck(speed) => {
                new.stribeck_rad_s = Some(speed);
                Follows::Stribeck
            }
        };
        let size = match sizes {
            [cos, sin] => {
                new.phase_rad = Some(cos.atan2(*sin));
                cos.hypot(*sin)
            }
            _ => sizes.first().copied().unwrap_or(0.0),
        };
        *new.size_mut() = Some(size);
        match effect.growth {
            Growth::Constant => {}
            Growth::Own | Growth::Past(_) => return None,
            Growth::Even(rate) => new.growth_per_s = Some(rate),
            Growth::Speed(power) => new.speed_power = Some(power),
            Growth::Modulated(f_hz, depth, phase) => {
                new.modulation_hz = Some(f_hz);
                new.modulation_depth = Some(depth);
                new.modulation_phase_rad = Some(phase);
            }
        }
        Some(new)
    }

    fn size_mut(&mut self) -> &mut Option<f64> {
        match self.site {
            EffectSite::Torque => &mut self.torque_n_m,
            EffectSite::Drive => &mut self.fraction,
            EffectSite::Disc | EffectSite::Level => &mut self.shift_rad,
            EffectSite::Stamp => &mut self.delay_s,
        }
    }

    /// Its size.
    #[must_use]
    pub fn size(&self) -> f64 {
        let mut own = *self;
        own.size_mut().unwrap_or(0.0)
    }

    /// The effect that simulator and diagnosis evaluate.
    #[must_use]
    pub fn effect(&self) -> effect::Effect {
        let on = On {
            channel: self.channel.map(|channel| channel as u8),
            rises: self.edge.map(|edge| edge == Flank::Rise),
        };
        let site = match self.site {
            EffectSite::Torque => effect::Site::Torque,
            EffectSite::Drive => effect::Site::Drive,
            EffectSite::Disc => effect::Site::Disc(on),
            EffectSite::Level => effect::Site::Level(on),
            EffectSite::Stamp => effect::Site::Stamp(on),
        };
        let number = |number: Option<f64>| number.unwrap_or(0.0);
        let carrier = match self.follows {
            Follows::Nothing => Carrier::Steady,
            Follows::Order => Carrier::Order(number(self.order)),
            Follows::Frequency => match self.rate_hz_s {
                None => Carrier::Tone(number(self.f_hz)),
                Some(rate) => Carrier::Chirp(number(self.f_hz), rate),
            },
            Follows::Place => Carrier::Bump(number(self.angle_rad), number(self.width_rad)),
            Follows::Window => Carrier::Window(
                self.from_s.unwrap_or(f64::NEG_INFINITY),
                self.until_s.unwrap_or(f64::INFINITY),
            ),
            Follows::Settling => Carrier::Settling(number(self.from_s), number(self.tau_s)),
            Follows::Time => Carrier::Time,
            Follows::Direction => Carrier::Direction,
            Follows::Speed => Carrier::Power(number(self.power)),
            Follows::Stribeck => Carrier::Stribeck(number(self.stribeck_rad_s)),
        };
        let growth = match (self.growth_per_s, self.speed_power, self.modulation_hz) {
            (Some(rate), ..) => Growth::Even(rate),
            (_, Some(power), _) => Growth::Speed(power),
            (.., Some(f_hz)) => Growth::Modulated(
                f_hz,
                number(self.modulation_depth),
                number(self.modulation_phase_rad),
            ),
            _ => Growth::Constant,
        };
        effect::Effect {
            site,
            carrier,
            growth,
            only: None,
        }
    }

    /// Its sizes as the effect has them: one, or of cosine and sine.
    #[must_use]
    pub fn sizes(&self) -> Vec<f64> {
        let size = self.size();
        match self.effect().sizes() {
            2 => {
                let (sin, cos) = libm::sincos(self.phase_rad.unwrap_or(0.0));
                vec![size * sin, size * cos]
            }
            _ => vec![size],
        }
    }

    /// Its numbers that are not its size, by their keys.
    pub(super) fn numbers(&self) -> [(&'static str, Option<f64>); 16] {
        [
            ("order", self.order),
            ("f_hz", self.f_hz),
            ("rate_hz_s", self.rate_hz_s),
            ("angle_rad", self.angle_rad),
            ("width_rad", self.width_rad),
            ("from_s", self.from_s),
            ("until_s", self.until_s),
            ("tau_s", self.tau_s),
            ("power", self.power),
            ("stribeck_rad_s", self.stribeck_rad_s),
            ("phase_rad", self.phase_rad),
            ("growth_per_s", self.growth_per_s),
            ("speed_power", self.speed_power),
            ("modulation_hz", self.modulation_hz),
            ("modulation_depth", self.modulation_depth),
            ("modulation_phase_rad", self.modulation_phase_rad),
        ]
    }
}

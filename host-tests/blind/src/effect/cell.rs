//! Effects in no catalogue, put together: a site at which one enters, a carrier that it follows, a growth of its size.

use std::f64::consts::{PI, TAU};

use crate::encoder::Class;

/// Where an effect enters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Site {
    /// A torque on the shaft, N m.
    Torque,
    /// An angle of the disc, rad: e(k), so that marks are met earlier.
    Disc,
    /// The comparator's level, rad: rises late, falls early.
    Level,
    /// The stamp of an edge, s: late.
    Stamp,
}

/// What an effect follows; each is 1 at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Carrier {
    /// sin(order theta + phase).
    Order {
        /// Cycles a turn.
        order: f64,
        /// Phase, rad.
        phase_rad: f64,
    },
    /// sin(2 pi f t + phase).
    Tone {
        /// Frequency.
        f_hz: f64,
        /// Phase, rad.
        phase_rad: f64,
    },
    /// A Gaussian bump at a place of the turn.
    Place {
        /// Its middle, rad.
        angle_rad: f64,
        /// Its standard deviation, rad.
        width_rad: f64,
    },
    /// sin(2 pi (f + rate t / 2) t).
    Sweep {
        /// Frequency at time 0.
        f_hz: f64,
        /// Hz a second.
        rate_hz_s: f64,
    },
    /// 1 and -1 by turns, from switch to switch.
    Jumps,
    /// 1: all that it follows is how it grows.
    Steady,
}

/// How the size of an effect goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Growth {
    /// It stays.
    Constant,
    /// From 0 at time 0 to 1 at a time.
    Linear {
        /// The time, s.
        over_s: f64,
    },
    /// 1 + cos(2 pi f t), over 2.
    Modulated {
        /// Frequency.
        f_hz: f64,
    },
    /// The cube of the speed over a speed.
    SpeedCubed {
        /// Where it is 1, rad/s.
        at_rad_s: f64,
    },
    /// There and gone by turns, from switch to switch.
    Bursts,
}

/// An effect put together.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Where it enters.
    pub site: Site,
    /// What it follows.
    pub carrier: Carrier,
    /// How its size goes.
    pub growth: Growth,
    /// The one channel that it touches; all where none.
    pub channel: Option<usize>,
    /// Instants at which jumps and bursts switch, s.
    pub switches_s: Vec<f64>,
    /// Its size, in the unit of the site.
    pub size: f64,
}

impl Site {
    /// Its name in the truth.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Torque => "torque",
            Self::Disc => "disc",
            Self::Level => "level",
            Self::Stamp => "stamp",
        }
    }
}

impl Carrier {
    /// Its name in the truth.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Order { .. } => "order",
            Self::Tone { .. } => "frequency",
            Self::Place { .. } => "place",
            Self::Sweep { .. } => "sweep",
            Self::Jumps => "jumps",
            Self::Steady => "speed",
        }
    }
}

impl Growth {
    /// It in words.
    const fn words(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Linear { .. } => "growing with time",
            Self::Modulated { .. } => "modulated",
            Self::SpeedCubed { .. } => "growing with the cube of the speed",
            Self::Bursts => "in bursts",
        }
    }
}

impl Cell {
    /// It in words.
    #[must_use]
    pub fn words(&self) -> String {
        let (site, carrier) = (self.site.name(), self.carrier.name());
        format!("{site} by {carrier}, {}", self.growth.words())
    }

    /// Catalogue ids of the same site and carrier: not the whole of it, and yet the right place to look.
    #[must_use]
    pub fn near(&self) -> &'static [&'static str] {
        match (self.site, self.carrier) {
            (Site::Torque, Carrier::Order { .. }) => &["torque_ripple", "gear_mesh", "bearing"],
            (Site::Torque, Carrier::Tone { .. }) => &["torque_tone"],
            (Site::Torque, Carrier::Steady) => &["friction"],
            (Site::Torque, Carrier::Jumps) => &["load_step"],
            (Site::Disc, Carrier::Order { .. }) => &["eccentricity", "disc_tilt", "bearing"],
            (Site::Disc, Carrier::Place { .. }) => &["local_defect"],
            (Site::Level, Carrier::Tone { .. }) => &["threshold_ripple"],
            (Site::Level, Carrier::Place { .. }) => &["local_defect"],
            (Site::Level, Carrier::Jumps) => &["threshold_drift"],
            (Site::Stamp, Carrier::Steady) => &["channel_skew", "edge_delay"],
            _ => &[],
        }
    }

    /// Its value at a time, shaft angle and speed. `inside_s` lies on the same side of every switch as the time.
    #[must_use]
    pub fn value(&self, time_s: f64, inside_s: f64, theta: f64, speed: f64) -> f64 {
        let odd = self.switches_s.partition_point(|&at| at <= inside_s) % 2 == 1;
        let carrier = match self.carrier {
            Carrier::Order { order, phase_rad } => libm::sin(order * theta + phase_rad),
            Carrier::Tone { f_hz, phase_rad } => libm::sin(TAU * f_hz * time_s + phase_rad),
            Carrier::Place {
                angle_rad,
                width_rad,
            } => {
                let away = (theta - angle_rad + PI).rem_euclid(TAU) - PI;
                libm::exp(-0.5 * (away / width_rad) * (away / width_rad))
            }
            Carrier::Sweep { f_hz, rate_hz_s } => {
                libm::sin(TAU * (f_hz + 0.5 * rate_hz_s * time_s) * time_s)
            }
            Carrier::Jumps if odd => -1.0,
            Carrier::Jumps | Carrier::Steady => 1.0,
        };
        let growth = match self.growth {
            Growth::Constant => 1.0,
            Growth::Linear { over_s } => time_s / over_s,
            Growth::Modulated { f_hz } => 0.5 * (1.0 + libm::cos(TAU * f_hz * time_s)),
            Growth::SpeedCubed { at_rad_s } => (speed / at_rad_s).powi(3),
            Growth::Bursts => f64::from(u8::from(odd)),
        };
        // A torque by the speed alone is a drag.
        let sign = match (self.site, self.carrier) {
            (Site::Torque, Carrier::Steady) => -1.0,
            _ => 1.0,
        };
        sign * self.size * carrier * growth
    }

    /// Whether it touches an edge of a class; of an index mark only where it touches all channels.
    #[must_use]
    pub fn touches(&self, class: Option<Class>) -> bool {
        match (self.channel, class) {
            (None, _) => true,
            (Some(channel), Some(class)) => channel == class.channel,
            (Some(_), None) => false,
        }
    }

    /// Whether it moves marks.
    #[must_use]
    pub const fn moves_marks(&self) -> bool {
        matches!(self.site, Site::Disc | Site::Level)
    }

    /// Fastest change of a torque at a speed, rad/s.
    #[must_use]
    pub fn quickest(&self, speed: f64, until_s: f64) -> f64 {
        match self.carrier {
            Carrier::Order { order, .. } => order * speed,
            Carrier::Tone { f_hz, .. } => TAU * f_hz,
            Carrier::Place { width_rad, .. } => speed / width_rad,
            Carrier::Sweep { f_hz, rate_hz_s } => TAU * (f_hz + rate_hz_s * until_s).max(f_hz),
            Carrier::Jumps | Carrier::Steady => 0.0,
        }
    }
}

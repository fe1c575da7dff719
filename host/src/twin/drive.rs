//! Shaft, drive, ripple and noise of a twin.

use std::f64::consts::TAU;

use serde::de::{Deserializer, Error, Unexpected};
use serde::{Deserialize, Serialize};

use super::{SpeedProfile, TorqueProfile, Twin, is_zero};

/// Inertia and friction of everything that turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shaft {
    /// Moment of inertia J, more than 0; 0 where it is left out, as it may be where nothing in the twin is a torque.
    #[serde(
        default,
        deserialize_with = "given_inertia",
        skip_serializing_if = "is_zero"
    )]
    pub inertia_kg_m2: f64,
    /// Viscous friction b: torque a rad/s.
    #[serde(default)]
    pub viscous_n_m_s: f64,
    /// Coulomb friction: constant against the motion, and the most a standing shaft resists.
    #[serde(default)]
    pub coulomb_n_m: f64,
    /// Drag that grows with the square of the speed (air, oil): torque drag w |w|.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub drag_n_m_s2: f64,
    /// Stribeck friction: comes on top of Coulomb friction at rest and goes with the speed as exp(-(w / stribeck_rad_s)^2).
    #[serde(default, skip_serializing_if = "is_zero")]
    pub stribeck_n_m: f64,
    /// Speed over which Stribeck friction goes; more than 0, needed where there is such friction.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub stribeck_rad_s: f64,
    /// How strongly an open-loop drive pulls towards its speed: torque a rad/s. 0 is pure torque mode.
    #[serde(default)]
    pub stiffness_n_m_s: f64,
    /// Angle at time 0.
    #[serde(default)]
    pub initial_angle_rad: f64,
}

impl Shaft {
    /// The inertia, kg m^2; 1 where it is not known, as accelerations are all that counts then.
    #[must_use]
    pub fn inertia_or_one(&self) -> f64 {
        if self.inertia_kg_m2 == 0.0 {
            1.0
        } else {
            self.inertia_kg_m2
        }
    }

    pub(super) fn is_unknown(&self) -> bool {
        *self == Self::default()
    }
}

/// An inertia as a file gives it: one that is left out is 0, so 0 itself is refused here.
fn given_inertia<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    let inertia = f64::deserialize(deserializer)?;
    if inertia == 0.0 {
        let found = Unexpected::Float(inertia);
        return Err(Error::invalid_value(found, &"an inertia above 0"));
    }
    Ok(inertia)
}

impl Twin {
    /// All friction but the viscous, against the motion, at a speed, N m.
    #[must_use]
    pub fn friction_n_m(&self, rad_s: f64) -> f64 {
        let shaft = &self.shaft;
        let mut friction = shaft.coulomb_n_m;
        if shaft.drag_n_m_s2 > 0.0 {
            friction += shaft.drag_n_m_s2 * rad_s * rad_s;
        }
        if shaft.stribeck_n_m > 0.0 {
            let over = rad_s / shaft.stribeck_rad_s;
            friction += shaft.stribeck_n_m * libm::exp(-over * over);
        }
        friction
    }
}

/// What drives the shaft; a negative speed is reverse.
///
/// All but the torque and the speed loop follow a speed in open loop: with w* the declared speed, the torque is J dw*/dt + b w* + coulomb sgn(w*) +
/// stiffness (w* - w), and to drag and Stribeck friction at w*, so that without ripple and noise the shaft follows w* exactly wherever w* has no jump. At a jump the
/// shaft comes after with time constant J / (b + stiffness).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Drive {
    /// Not known: the twin has no `drive`. It can't be simulated.
    #[default]
    #[serde(skip)]
    Unknown,
    /// One speed.
    Constant {
        /// Speed.
        r_min: f64,
    },
    /// From one speed to another at a constant rate, which is then held.
    Ramp {
        /// Speed at time 0.
        from_r_min: f64,
        /// Speed at the end.
        to_r_min: f64,
        /// Length of the ramp, more than 0.
        over_s: f64,
    },
    /// A list of speeds, each held until the next; the first holds from the start.
    Steps(Vec<Step>),
    /// Straight lines from speed to speed.
    Profile(SpeedProfile),
    /// A torque, whatever speed comes of it.
    Torque(TorqueProfile),
    /// One speed, then no drive torque at all.
    RunDown {
        /// Speed at first.
        r_min: f64,
        /// Time at which the drive goes off.
        off_s: f64,
    },
    /// A PI speed controller, sampled in time, that sees the captured edges: grid step over last interval in ticks.
    ///
    /// Either both gains or the bandwidth: then kp = 2 pi bandwidth J and ki = kp 2 pi bandwidth / 5. The integrator starts with the
    /// friction torque of the speed, the measured speed is taken as right until the first interval ends.
    SpeedLoop {
        /// Speed asked for.
        r_min: f64,
        /// Sample rate.
        f_hz: f64,
        /// Bandwidth that sets both gains.
        #[serde(skip_serializing_if = "Option::is_none")]
        bandwidth_hz: Option<f64>,
        /// Proportional gain: torque a rad/s.
        #[serde(skip_serializing_if = "Option::is_none")]
        kp_n_m_s: Option<f64>,
        /// Integral gain: torque a rad.
        #[serde(skip_serializing_if = "Option::is_none")]
        ki_n_m: Option<f64>,
        /// The measured speed is zero when no edge came for so long; 20 intervals of the speed asked for where left out.
        #[serde(skip_serializing_if = "Option::is_none")]
        timeout_s: Option<f64>,
        /// Most torque the drive gives, either way; no limit where left out. The integrator stops at the limit.
        #[serde(skip_serializing_if = "Option::is_none")]
        limit_n_m: Option<f64>,
    },
}

/// A speed from a time on, or at it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// Time.
    pub t_s: f64,
    /// Speed.
    pub r_min: f64,
}

impl Drive {
    /// Whether it turns the shaft one way and then the other.
    #[must_use]
    pub fn reverses(&self) -> bool {
        match self {
            Self::Ramp {
                from_r_min,
                to_r_min,
                ..
            } => from_r_min * to_r_min < 0.0,
            Self::Profile(profile) => {
                let goes = |way: f64| profile.points().iter().any(|p| p.r_min * way > 0.0);
                goes(1.0) && goes(-1.0)
            }
            _ => false,
        }
    }

    pub(super) fn is_unknown(&self) -> bool {
        *self == Self::Unknown
    }

    /// The nominal speed, rad/s, that relative sizes (ripple, wander) refer to: the fastest the profile has, that
    /// at the start where a torque drives; negative for reverse, 0 where the drive is not known.
    #[must_use]
    pub fn nominal_rad_s(&self) -> f64 {
        let fastest = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
        let r_min = match self {
            Self::Constant { r_min }
            | Self::RunDown { r_min, .. }
            | Self::SpeedLoop { r_min, .. } => *r_min,
            Self::Ramp {
                from_r_min,
                to_r_min,
                ..
            } => fastest(*from_r_min, *to_r_min),
            Self::Steps(steps) => steps.iter().fold(0.0, |w, step| fastest(w, step.r_min)),
            Self::Profile(profile) => {
                let points = profile.points().iter();
                points.fold(0.0, |w, point| fastest(w, point.r_min))
            }
            Self::Torque(torque) => torque.start_r_min,
            Self::Unknown => 0.0,
        };
        r_min * (TAU / 60.0)
    }
}

/// A torque locked to the shaft's angle: amplitude sin(order theta + phase).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ripple {
    /// Cycles a turn; need not be whole (a gear).
    pub order: f64,
    /// Phase of the torque.
    #[serde(default)]
    pub phase_rad: f64,
    /// Amplitude as a torque.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_n_m: Option<f64>,
    /// Amplitude as the relative speed swing it makes at the nominal speed w: torque = fraction w |i J order w + b + stiffness|.
    /// A speed loop comes on top: the swing named here is the open-loop one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_fraction: Option<f64>,
}

/// White torque noise, constant over each step of a fixed time grid (zero-order hold) that does not depend on the integration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Noise {
    /// Torque noise by its density.
    White {
        /// Two-sided power spectral density S; the torque of a step of length h has variance S / h.
        psd_n2_m2_s: f64,
        /// Step of the grid; one interval at the nominal speed where left out.
        #[serde(skip_serializing_if = "Option::is_none")]
        hold_s: Option<f64>,
    },
    /// Torque noise by the speed wander it makes: at the nominal speed w the true speed wanders normally, with this relative RMS and
    /// autocorrelation exp(-angle / correlation). Open-loop drives only; it sets the noise's density, and where the correlation is given the
    /// drive's stiffness too: b + stiffness = J w / correlation.
    SpeedWander {
        /// RMS of the speed over the nominal speed.
        rms_fraction: f64,
        /// Correlation angle; that of J w / (b + stiffness) as declared where left out.
        #[serde(skip_serializing_if = "Option::is_none")]
        correlation_rad: Option<f64>,
        /// Step of the grid; one interval at the nominal speed where left out, but at most a 50th of the correlation time.
        #[serde(skip_serializing_if = "Option::is_none")]
        hold_s: Option<f64>,
    },
}

//! The sealed truth of a case, as `quadcal-blind` writes it.

use std::fmt;

use quadcal_host::mechanism::Mechanism;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::cell::Cell;

/// What a disc's own pattern may be called where the twin does not give it; right there, but not what was asked for.
pub const OF_THE_DISC: [Mechanism; 6] = [
    Mechanism::LineError,
    Mechanism::WidthError,
    Mechanism::QuadratureError,
    Mechanism::Eccentricity,
    Mechanism::DiscTilt,
    Mechanism::LocalDefect,
];

/// What a case tries.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// One effect.
    One,
    /// Two or three.
    Several,
    /// One under a larger pattern of the disc.
    Masked,
    /// One under a speed loop that the twin knows.
    Loop,
    /// One that the recording can't tell from another.
    LookAlike,
    /// Nothing is missing.
    Nothing,
    /// Physics in no catalogue.
    Outside,
}

impl Kind {
    /// Its name in the truth.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::One => "one",
            Self::Several => "several",
            Self::Masked => "masked",
            Self::Loop => "loop",
            Self::LookAlike => "look_alike",
            Self::Nothing => "nothing",
            Self::Outside => "outside",
        }
    }

    /// Whether there is one effect, and its name is what counts.
    #[must_use]
    pub const fn has_one_name(self) -> bool {
        matches!(self, Self::One | Self::Masked | Self::Loop)
    }
}

/// A family of cases beside the kinds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Family {
    /// The twin knows sensor, timer and inertia alone.
    Thin,
    /// The twin does not know the drive.
    FreeDrive,
    /// Noise that is not white and normal.
    Heavy,
    /// Effects in no catalogue.
    CatalogueFree,
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Thin,
        Self::FreeDrive,
        Self::Heavy,
        Self::CatalogueFree,
    ];

    /// Its name in figures.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Thin => "thin twin",
            Self::FreeDrive => "free drive",
            Self::Heavy => "heavy noise",
            Self::CatalogueFree => "no catalogue",
        }
    }
}

/// Sizes of effects in classes, in sizes that the ideal detector needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct SizeClass(pub u32);

impl SizeClass {
    /// All of them.
    pub const ALL: [Self; 4] = [Self(3), Self(5), Self(10), Self(30)];

    /// The one whose ratio to a size is nearest 1.
    #[must_use]
    pub fn of(times: f64) -> Self {
        let off = |class: &Self| (times / f64::from(class.0)).ln().abs();
        let nearest = Self::ALL
            .into_iter()
            .min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.unwrap_or(Self(3))
    }
}

impl fmt::Display for SizeClass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} times", self.0)
    }
}

/// The truth about a case.
#[derive(Clone, Debug, Deserialize)]
pub struct Truth {
    /// What it tries.
    pub kind: Kind,
    /// The family it is of, beside the kinds.
    #[serde(default)]
    pub family: Option<Family>,
    /// What the rig has, beside what is tried, and the twin does not give.
    #[serde(default)]
    pub undeclared: Vec<Mechanism>,
    /// What the twin lacks.
    pub mechanisms: Vec<Missing>,
    /// Mechanisms that the recording can't tell apart.
    #[serde(default)]
    pub indistinguishable: Vec<Mechanism>,
    /// Whether the twin gives the disc's pattern.
    pub disc_known: bool,
    /// The rig's noise.
    pub noise: Noise,
}

impl Truth {
    /// Whether anything that is there, and that the twin does not give, may be called so.
    #[must_use]
    pub fn has(&self, mechanism: Mechanism) -> bool {
        let mut missing = self.mechanisms.iter();
        missing.any(|one| one.is(mechanism) || one.near.contains(&mechanism))
            || self.undeclared.contains(&mechanism)
            || self.indistinguishable.contains(&mechanism)
            || (!self.disc_known && OF_THE_DISC.contains(&mechanism))
    }
}

/// Noise of the rig without what is missing.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Noise {
    /// RMS of the white error of a stamp, s.
    pub jitter_s: f64,
}

/// One effect that the twin lacks.
#[derive(Clone, Debug, Deserialize)]
pub struct Missing {
    /// Its mechanism; `unknown` for physics in no catalogue.
    pub id: Mechanism,
    /// What physics it is: the id, or words for what no catalogue has.
    pub physics: String,
    /// Other mechanisms that describe the very same.
    #[serde(default)]
    pub same_physics: Vec<Mechanism>,
    /// Mechanisms of the same site and carrier, where it is in no catalogue.
    #[serde(default)]
    pub near: Vec<Mechanism>,
    /// Its parameters.
    pub parameters: Map<String, Value>,
    /// Its size in those that the ideal detector needs; what counts even where d' grows as the square of it.
    pub times_ideal: f64,
    /// How surely the ideal detector tells it from its look-alikes, as d'; none where it has none.
    pub separation_d_prime: Option<f64>,
}

impl Missing {
    /// Whether a mechanism is this one by any of its names.
    #[must_use]
    pub fn is(&self, mechanism: Mechanism) -> bool {
        self.id == mechanism || self.same_physics.contains(&mechanism)
    }

    /// Whether the ideal detector can tell it from its look-alikes: d' is 5 or more, or it has none.
    #[must_use]
    pub fn identifiable(&self) -> bool {
        self.separation_d_prime.is_none_or(|apart| apart >= 5.0)
    }

    /// Where it enters and what it follows; none for physics in no catalogue.
    #[must_use]
    pub fn cell(&self) -> Option<Cell> {
        Cell::of(self.id, self.parameters.contains_key("runout_rad"))
    }

    /// A parameter that is a number.
    #[must_use]
    pub fn number(&self, name: &str) -> Option<f64> {
        self.parameters.get(name)?.as_f64()
    }
}

//! The sealed truth of a case, as `quadcal-blind` writes it.

use std::fmt;

use quadcal_host::mechanism::Mechanism;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

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

    /// A parameter that is a number.
    #[must_use]
    pub fn number(&self, name: &str) -> Option<f64> {
        self.parameters.get(name)?.as_f64()
    }
}

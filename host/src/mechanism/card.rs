//! What is known of a mechanism before any recording is looked at.

use super::{EdgeClasses, LockedTo, Mechanism};

/// A mechanism: what it is, what it is told by, and which others look the same. Its file has one.
#[derive(Clone, Copy, Debug)]
pub struct Card {
    /// A few words for people, without a full stop.
    pub title: &'static str,
    /// What happens, in a sentence or two.
    pub physics: &'static str,
    /// Its mark in the residual, or its torque.
    pub equation: &'static str,
    /// Where the equation comes from.
    pub source: &'static str,
    /// The twin's section that declares it.
    pub twin: &'static str,
    /// Its numbers, by the names that findings and the JSON have for them.
    pub parameters: &'static [Quantity],
    /// What it keeps step with: one, or each that it may.
    pub locked_to: &'static [LockedTo],
    /// Exponent n where the size of the angle residual goes as speed^n; none where it follows no power of the speed.
    pub speed_exponent: Option<i8>,
    /// How it tells edges apart.
    pub edge_classes: EdgeClasses,
    /// Mechanisms that the same recording may show alike; if one is another's look-alike, so is the other the one's.
    pub look_alikes: &'static [Mechanism],
    /// Those of them that leave the very same mark: no recording of edges alone tells them apart.
    pub same_mark: &'static [Mechanism],
    /// Those that only what is known of the rig tells apart: always named beside it, and no reason to record anew.
    pub told_by_rig: &'static [Mechanism],
    /// The recording to make next: what to change and what then shows. One or two sentences.
    pub separated_by: &'static str,
}

/// A number that a finding may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantity {
    /// Its name: the twin's, where the twin has it.
    pub name: &'static str,
    /// `rad`, `s`, `Hz`, `N m`, `1`, ..
    pub unit: &'static str,
    /// Least plausible value.
    pub from: f64,
    /// Greatest plausible value. A fit that ends outside is not named: it only resembles the mechanism.
    pub to: f64,
    /// What it is, in a few words.
    pub what: &'static str,
}

impl Quantity {
    /// A number with its unit and range, both ends included.
    #[must_use]
    pub const fn new(
        name: &'static str,
        unit: &'static str,
        range: [f64; 2],
        what: &'static str,
    ) -> Self {
        let [from, to] = range;
        Self {
            name,
            unit,
            from,
            to,
            what,
        }
    }

    /// A phase, rad.
    #[must_use]
    pub const fn phase(what: &'static str) -> Self {
        Self::new("phase_rad", "rad", [0.0, std::f64::consts::TAU], what)
    }

    /// A torque that drives and brakes in turn, N m, by its amplitude.
    #[must_use]
    pub const fn torque(what: &'static str) -> Self {
        Self::new("torque_n_m", "N m", [0.0, TORQUE_N_M], what)
    }

    /// Whether a value is plausible; what is no number is not.
    #[must_use]
    pub fn allows(&self, value: f64) -> bool {
        (self.from..=self.to).contains(&value)
    }
}

/// Largest torque of a shaft with an encoder on it, N m: that of a wind turbine's main shaft is some megas.
pub const TORQUE_N_M: f64 = 1e7;
/// Largest error of an edge, rad: half of the way between a pole pair's Hall edges.
pub const ERROR_RAD: f64 = 0.53;
/// Largest amplitude of a rhythm of the disc, rad: a tenth of the radius, which no rig passes for centred, or a tilt of 36 degrees.
pub const RUN_OUT_RAD: f64 = 0.1;
/// Longest delay of an edge, s: slow optocouplers have some 0.1 ms, filters of a slow input some ms.
pub const DELAY_S: f64 = 0.05;
/// Times on a recording's clock, s: what began before it counts back.
pub const INSTANT_S: [f64; 2] = [-1e7, 1e7];
/// Orders of the turn, not whole ones.
pub const ORDERS: [f64; 2] = [1e-3, 1e5];
/// Frequencies of what swings along time, Hz.
pub const FREQUENCIES_HZ: [f64; 2] = [1e-4, 1e6];

impl Card {
    /// Its number of a name.
    #[must_use]
    pub fn quantity(&self, name: &str) -> Option<&'static Quantity> {
        let of = |name: &str| self.parameters.iter().find(|one| one.name == name);
        // That of a harmonic has its order before it.
        of(name).or_else(|| of(name.split_once('.')?.1))
    }

    /// The unit of a number of its; that of a pure number where it has none of the name.
    #[must_use]
    pub fn unit(&self, name: &str) -> &'static str {
        self.quantity(name).map_or("1", |one| one.unit)
    }

    /// The first of some numbers that no rig has, if there is one.
    pub fn implausible<'a>(
        &self,
        numbers: impl IntoIterator<Item = (&'a str, f64)>,
    ) -> Option<(&'static Quantity, f64)> {
        numbers
            .into_iter()
            .filter_map(|(name, value)| Some((self.quantity(name)?, value)))
            .find(|(quantity, value)| !quantity.allows(*value))
    }
}

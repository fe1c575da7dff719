//! The figures of a trial, with what they have to reach.

use std::fmt;

use quadcal_host::mechanism::Mechanism;
use serde::Serialize;

use super::score::{Named, Score};
use super::truth::{Family, Kind, SizeClass};
use super::{families, field};

/// What a figure has to reach.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// This or more.
    AtLeast(f64),
    /// This or less.
    AtMost(f64),
    /// From one to another.
    Between(f64, f64),
}

impl Target {
    /// Whether a value reaches it.
    #[must_use]
    pub fn met(self, value: f64) -> bool {
        match self {
            Self::AtLeast(least) => value >= least,
            Self::AtMost(most) => value <= most,
            Self::Between(low, high) => (low..=high).contains(&value),
        }
    }
}

/// Unit of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Unit {
    /// Share, shown in percent.
    Share,
    /// Seconds.
    Seconds,
}

/// One figure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// What it is.
    pub name: String,
    /// Its value; none where no case says anything on it.
    pub value: Option<f64>,
    /// Its unit.
    pub unit: Unit,
    /// How many cases or parameters count for it, of how many; the latter alone for a median.
    pub of: (Option<usize>, usize),
    /// What it has to reach, where it has to.
    pub target: Option<Target>,
}

impl Figure {
    pub(super) fn share(name: impl Into<String>, target: Option<Target>, each: &[bool]) -> Self {
        let count = each.iter().filter(|&&one| one).count();
        Self {
            name: name.into(),
            value: (!each.is_empty()).then(|| count as f64 / each.len() as f64),
            unit: Unit::Share,
            of: (Some(count), each.len()),
            target,
        }
    }

    pub(super) fn middle(
        name: &str,
        unit: Unit,
        target: Option<Target>,
        mut values: Vec<f64>,
    ) -> Self {
        values.sort_by(f64::total_cmp);
        Self {
            name: name.to_owned(),
            value: values.get(values.len() / 2).copied(),
            unit,
            of: (None, values.len()),
            target,
        }
    }

    /// Whether it reaches its target; none without target or value.
    #[must_use]
    pub fn met(&self) -> Option<bool> {
        Some(self.target?.met(self.value?))
    }

    /// Its value as a reader wants it.
    #[must_use]
    pub fn value_text(&self) -> String {
        self.value
            .map_or_else(|| "-".to_owned(), |value| self.number(value))
    }

    /// Its target as a reader wants it.
    #[must_use]
    pub fn target_text(&self) -> String {
        match self.target {
            None => "-".to_owned(),
            Some(Target::AtLeast(least)) => format!("{} or more", self.number(least)),
            Some(Target::AtMost(most)) => format!("{} or less", self.number(most)),
            Some(Target::Between(low, high)) => {
                format!("{} to {}", self.number(low), self.number(high))
            }
        }
    }

    /// What it is taken from.
    #[must_use]
    pub fn of_text(&self) -> String {
        match self.of {
            (Some(count), all) => format!("{count} of {all}"),
            (None, all) => format!("{all}"),
        }
    }

    fn number(&self, value: f64) -> String {
        match self.unit {
            Unit::Share => format!("{} %", Short(100.0 * value)),
            Unit::Seconds => format!("{} s", Short(value)),
        }
    }
}

/// A number with a decimal or two, none where it is whole.
struct Short(f64);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(value) = *self;
        if (value - value.round()).abs() < 1e-9 {
            write!(f, "{value:.0}")
        } else if value.abs() < 1.0 {
            write!(f, "{value:.2}")
        } else {
            write!(f, "{value:.1}")
        }
    }
}

/// All figures of a trial: those of the kinds where it has any, those of each family that it has, and those of all its cases.
#[must_use]
pub fn figures(scores: &[Score]) -> Vec<Figure> {
    let of = |family| -> Vec<&Score> {
        let scores = scores.iter();
        scores.filter(|score| score.family == family).collect()
    };
    let mut all = Vec::new();
    let plain = of(None);
    if !plain.is_empty() {
        all.extend(of_kinds(&plain));
    }
    for family in Family::ALL {
        let scores = of(Some(family));
        if !scores.is_empty() {
            all.extend(families::figures(family, &scores));
        }
    }
    let every: Vec<&Score> = scores.iter().collect();
    all.extend(field::figures(&every));
    all.extend(of_runs(&every));
    all
}

/// Figures of the kinds of case.
fn of_kinds(scores: &[&Score]) -> Vec<Figure> {
    use Target::{AtLeast, AtMost, Between};
    let each = |pick: &dyn Fn(&Score) -> bool, is: &dyn Fn(&Score) -> bool| -> Vec<bool> {
        let picked = scores.iter().filter(|s| pick(s));
        picked.map(|s| is(s)).collect()
    };
    let right = |score: &Score| score.right;
    let of = |kind: Kind| move |score: &Score| score.kind == kind;
    let mut all = Vec::new();
    for size in SizeClass::ALL {
        let target = match size {
            SizeClass(10) => Some(AtLeast(0.95)),
            SizeClass(5) => Some(AtLeast(0.85)),
            _ => None,
        };
        let pick = |s: &Score| s.kind.has_one_name() && s.size == Some(size) && s.identifiable;
        all.push(Figure::share(
            format!("right mechanism first, {size} the detectable size, identifiable"),
            target,
            &each(&pick, &right),
        ));
    }
    for kind in [Kind::One, Kind::Masked, Kind::Loop] {
        let pick = |s: &Score| s.kind == kind && s.identifiable;
        all.push(Figure::share(
            format!("the same, {} only, any size", kind.name()),
            None,
            &each(&pick, &right),
        ));
    }
    all.push(Figure::share(
        "first or among the look-alikes, any size, not identifiable",
        None,
        &each(&|s| s.kind.has_one_name() && !s.identifiable, &right),
    ));
    all.push(Figure::share(
        "two or three effects: all named, nothing else",
        None,
        &each(&of(Kind::Several), &right),
    ));
    let several = || scores.iter().filter(|s| s.kind == Kind::Several);
    let effects: Vec<bool> = several()
        .flat_map(|s| (0..s.truth.len()).map(|at| at < s.found))
        .collect();
    all.push(Figure::share(
        "two or three effects: of the effects named",
        None,
        &effects,
    ));
    all.push(Figure::share(
        "two or three effects: cases with something else named",
        None,
        &each(&of(Kind::Several), &|s| !s.extras.is_empty()),
    ));
    all.push(Figure::share(
        "the disc is missing too: cases with more named than it and the effect",
        None,
        &each(&|s| !s.disc_known, &|s| s.beside > 0),
    ));
    all.push(Figure::share(
        "false finding where nothing is missing",
        Some(AtMost(0.01)),
        &each(&of(Kind::Nothing), &|s| !s.right),
    ));
    all.push(Figure::share(
        "physics in no catalogue given a known name",
        Some(AtMost(0.05)),
        &each(&of(Kind::Outside), &|s| !s.right),
    ));
    all.push(Figure::share(
        "physics in no catalogue called unknown",
        None,
        &each(&of(Kind::Outside), &|s| {
            s.first == Named::Mechanism(Mechanism::Unknown)
        }),
    ));
    let held: Vec<bool> = (scores.iter().flat_map(|s| &s.parameters))
        .filter_map(|parameter| parameter.holds)
        .collect();
    all.push(Figure::share(
        "95 % intervals that hold the true value",
        Some(Between(0.92, 0.98)),
        &held,
    ));
    let removed: Vec<f64> = scores.iter().filter_map(|s| s.reducible_removed).collect();
    let most: Vec<bool> = removed.iter().map(|&removed| removed >= 0.9).collect();
    all.push(Figure::middle(
        "reducible RMS removed on held-out turns, right mechanism, median",
        Unit::Share,
        Some(AtLeast(0.9)),
        removed,
    ));
    all.push(Figure::share(
        "cases with 90 % of it or more removed",
        None,
        &most,
    ));
    all.push(Figure::share(
        "ambiguous pairs named as ambiguous",
        Some(AtLeast(0.9)),
        &each(&of(Kind::LookAlike), &right),
    ));
    all
}

/// Figures of the runs themselves.
fn of_runs(scores: &[&Score]) -> Vec<Figure> {
    let mut all = Vec::new();
    let mut seconds: Vec<f64> = scores.iter().map(|s| s.seconds).collect();
    all.push(Figure::middle(
        "time a case, median",
        Unit::Seconds,
        None,
        seconds.clone(),
    ));
    seconds.sort_by(f64::total_cmp);
    all.push(Figure {
        value: seconds.last().copied(),
        ..Figure::middle("time a case, slowest", Unit::Seconds, None, seconds)
    });
    all.push(Figure::share(
        "runs that failed",
        None,
        &(scores.iter().map(|s| s.failure.is_some())).collect::<Vec<_>>(),
    ));
    all
}

//! What is known of a mechanism before any recording is looked at: its card, from `catalogue.toml`.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::{Deserialize, Deserializer};

use super::Mechanism;

/// The catalogue's text.
pub(super) const TEXT: &str = include_str!("catalogue.toml");

/// A card for each mechanism.
pub(super) static CARDS: LazyLock<BTreeMap<Mechanism, Card>> = LazyLock::new(|| {
    read(TEXT).expect("the text is part of the program, and a unit test reads it")
});

/// A mechanism: what it is, what it is told by, and which others look the same.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Card {
    /// A few words for people, without a full stop.
    pub title: String,
    /// What happens, in a sentence or two.
    #[serde(deserialize_with = "in_one_line")]
    pub physics: String,
    /// Its mark in the residual, or its torque.
    pub equation: String,
    /// Where the equation comes from.
    #[serde(deserialize_with = "in_one_line")]
    pub source: String,
    /// The twin's section that declares it; empty where there is none.
    #[serde(default)]
    pub twin: String,
    /// Its numbers, by the names that findings and the JSON have for them.
    pub parameters: Vec<Quantity>,
    /// What it keeps step with, in words: one, or each that it may.
    #[serde(default)]
    pub locked_to: Vec<String>,
    /// Exponent n where the size of the angle residual goes as speed^n; none where it follows no power of the speed.
    pub speed_exponent: Option<i8>,
    /// How it tells edges apart, in words.
    pub edge_classes: String,
    /// Mechanisms that the same recording may show alike; if one is another's look-alike, so is the other the one's.
    #[serde(default)]
    pub look_alikes: Vec<Mechanism>,
    /// Those of them that leave the very same mark: no recording of edges alone tells them apart.
    #[serde(default)]
    pub same_mark: Vec<Mechanism>,
    /// Those that only what is known of the rig tells apart: always named beside it, and no reason to record anew.
    #[serde(default)]
    pub told_by_rig: Vec<Mechanism>,
    /// The recording to make next: what to change and what then shows. One or two sentences.
    #[serde(deserialize_with = "in_one_line")]
    pub separated_by: String,
}

/// A number that a finding may have.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quantity {
    /// Its name: the twin's, where the twin has it.
    pub name: String,
    /// `rad`, `s`, `Hz`, `N m`, `1`, ..
    pub unit: String,
    /// Least and greatest plausible value. A fit that ends outside only resembles the mechanism.
    pub range: [f64; 2],
    /// What it is, in a few words.
    #[serde(deserialize_with = "in_one_line")]
    pub what: String,
}

impl Quantity {
    /// Whether a value is plausible; what is no number is not.
    #[must_use]
    pub fn allows(&self, value: f64) -> bool {
        let [from, to] = self.range;
        (from..=to).contains(&value)
    }
}

impl Card {
    /// Its number of a name.
    #[must_use]
    pub fn quantity(&self, name: &str) -> Option<&Quantity> {
        let of = |name: &str| self.parameters.iter().find(|one| one.name == name);
        // That of a harmonic has its order before it.
        of(name).or_else(|| of(name.rsplit_once('.')?.1))
    }

    /// Least and greatest plausible value of a number of its; none of a name that it has not.
    #[must_use]
    pub fn range(&self, name: &str) -> [f64; 2] {
        self.quantity(name).map_or([f64::NAN; 2], |one| one.range)
    }

    /// The unit of a number of its; that of a pure number where it has none of the name.
    #[must_use]
    pub fn unit(&self, name: &str) -> &str {
        self.quantity(name).map_or("1", |one| &one.unit)
    }

    /// Whether a rig may have a number of its.
    #[must_use]
    pub fn allows(&self, name: &str, value: f64) -> bool {
        self.quantity(name).is_none_or(|one| one.allows(value))
    }
}

/// Reads a catalogue; a range that is given by its name is that of `[ranges]`.
pub(super) fn read(text: &str) -> Result<BTreeMap<Mechanism, Card>, toml::de::Error> {
    let mut cards: toml::Table = text.parse()?;
    let ranges = cards.remove("ranges");
    let named = |range: &toml::Value| ranges.as_ref()?.get(range.as_str()?).cloned();
    let parameters = cards
        .iter_mut()
        .filter_map(|(_, card)| card.get_mut("parameters")?.as_array_mut())
        .flatten();
    for range in parameters.filter_map(|one| one.get_mut("range")) {
        // A name that is not there stays a text, which is no range.
        if let Some(known) = named(range) {
            *range = known;
        }
    }
    cards.try_into()
}

/// A text whose line breaks are spaces.
fn in_one_line<'de, D: Deserializer<'de>>(text: D) -> Result<String, D::Error> {
    let text = String::deserialize(text)?;
    Ok(text.split_whitespace().collect::<Vec<_>>().join(" "))
}

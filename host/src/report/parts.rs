//! The parts of a report: tiles, table cells and blocks.

use super::number::{si, si_digits, si_parts};
use super::plot::Plot;

/// How the outcome is to be taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// As wanted.
    Good,
    /// Usable, with a reservation that the headline names.
    Warn,
    /// Not usable.
    Bad,
}

/// One big number at the head of the page.
#[derive(Clone, Debug)]
pub struct Tile {
    pub(super) label: String,
    pub(super) value: String,
    pub(super) unit: String,
    pub(super) note: String,
}

impl Tile {
    /// A tile with the value as text.
    pub fn new(
        label: impl Into<String>,
        value: impl Into<String>,
        unit: impl Into<String>,
        note: impl Into<String>,
    ) -> Self {
        Self {
            label: label.into(),
            value: value.into(),
            unit: unit.into(),
            note: note.into(),
        }
    }

    /// A tile with three significant digits and an SI prefix: 8.9e-7 `rad` shows as 890 nrad.
    pub fn si(label: impl Into<String>, value: f64, unit: &str, note: impl Into<String>) -> Self {
        let (value, unit) = si_parts(value, unit);
        Self::new(label, value, unit, note)
    }
}

/// One cell of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// A number as it is to be shown.
    Number(String),
    /// Nothing known.
    Empty,
}

impl Cell {
    /// A value with an SI prefix, three significant digits.
    pub fn si(value: f64, unit: &str) -> Self {
        Self::Number(si(value, unit))
    }

    /// A value with an SI prefix and `digits` significant digits (1 to 9).
    pub fn si_digits(value: f64, unit: &str, digits: usize) -> Self {
        let (number, unit) = si_digits(value, unit, digits);
        Self::Number(format!("{number}\u{a0}{unit}").trim_end().to_owned())
    }

    /// A value with fixed decimals.
    pub fn fixed(value: f64, decimals: usize) -> Self {
        if value.is_finite() {
            Self::Number(super::number::grouped(value, decimals))
        } else {
            Self::Empty
        }
    }

    /// A value and its standard error under one prefix: `125.66 ± 0.04 µrad`, the error to one or two digits.
    pub fn with_error(value: f64, standard_error: f64, unit: &str) -> Self {
        if !(value.is_finite()
            && standard_error.is_finite()
            && standard_error > 0.0
            && value != 0.0)
        {
            return Self::si(value, unit);
        }
        let (exponent, unit) = super::number::prefixed_unit(value.abs().max(standard_error), unit);
        let factor = 10f64.powi(-exponent);
        let decimals = (1.0 - (standard_error * factor).log10().floor()).clamp(0.0, 9.0) as usize;
        let number = |v: f64| super::number::grouped(v * factor, decimals);
        let text = format!("{} ± {}\u{a0}{unit}", number(value), number(standard_error));
        Self::Number(text.trim_end().to_owned())
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Cell {
    /// Whole numbers as they are, others to four significant digits; empty where not finite.
    fn from(value: f64) -> Self {
        if value.fract() == 0.0 && value.abs() < 1e15 {
            Self::fixed(value, 0)
        } else if value.is_finite() {
            Self::Number(si_digits(value, "", 4).0)
        } else {
            Self::Empty
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct Figure {
    pub(super) plot: Plot,
    pub(super) caption: String,
}

#[derive(Clone, Debug)]
pub(super) enum Block {
    Section {
        title: String,
        paragraphs: Vec<String>,
    },
    Table {
        caption: String,
        columns: Vec<String>,
        rows: Vec<Vec<Cell>>,
    },
    Figure(Box<Figure>),
    Pair(Box<[Figure; 2]>),
    Card(Box<Card>),
    Details {
        title: String,
        body: Body,
    },
}

/// One thing with named facts, a figure beside them and more below.
#[derive(Clone, Debug)]
pub(super) struct Card {
    pub(super) title: String,
    pub(super) facts: Vec<(String, Vec<String>)>,
    pub(super) figure: Option<Figure>,
    pub(super) body: Body,
}

/// Text, tables and figures in order.
#[derive(Clone, Debug, Default)]
pub struct Body {
    pub(super) blocks: Vec<Block>,
}

impl Body {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// As [`super::Report::section`]; an empty title adds paragraphs only.
    pub fn section(&mut self, title: impl Into<String>, paragraphs: &[&str]) -> &mut Self {
        self.blocks.push(Block::Section {
            title: title.into(),
            paragraphs: paragraphs.iter().map(|p| (*p).to_owned()).collect(),
        });
        self
    }

    /// As [`super::Report::table`].
    pub fn table(
        &mut self,
        caption: impl Into<String>,
        columns: &[&str],
        rows: Vec<Vec<Cell>>,
    ) -> &mut Self {
        self.blocks.push(Block::Table {
            caption: caption.into(),
            columns: columns.iter().map(|c| (*c).to_owned()).collect(),
            rows,
        });
        self
    }

    /// As [`super::Report::figure`].
    pub fn figure(&mut self, plot: impl Into<Plot>, caption: impl Into<String>) -> &mut Self {
        self.blocks.push(Block::Figure(Box::new(Figure {
            plot: plot.into(),
            caption: caption.into(),
        })));
        self
    }

    /// As [`super::Report::figure_pair`].
    pub fn figure_pair(
        &mut self,
        left: (impl Into<Plot>, &str),
        right: (impl Into<Plot>, &str),
    ) -> &mut Self {
        let figure = |plot, caption: &str| Figure {
            plot,
            caption: caption.to_owned(),
        };
        let pair = [
            figure(left.0.into(), left.1),
            figure(right.0.into(), right.1),
        ];
        self.blocks.push(Block::Pair(Box::new(pair)));
        self
    }

    /// Adds a card: one thing, its named facts of one or more lines each, a figure beside them, and more below.
    pub fn card(
        &mut self,
        title: impl Into<String>,
        facts: Vec<(String, Vec<String>)>,
        figure: Option<(Plot, String)>,
        body: Body,
    ) -> &mut Self {
        self.blocks.push(Block::Card(Box::new(Card {
            title: title.into(),
            facts,
            figure: figure.map(|(plot, caption)| Figure { plot, caption }),
            body,
        })));
        self
    }

    /// As [`super::Report::details`].
    pub fn details(&mut self, title: impl Into<String>, body: Body) -> &mut Self {
        self.blocks.push(Block::Details {
            title: title.into(),
            body,
        });
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_decides_the_decimals_of_its_value() {
        let number = |s: &str| Cell::Number(s.to_owned());
        assert_eq!(
            Cell::with_error(1.2566e-4, 3.5e-8, "rad"),
            number("125.660 ± 0.035\u{a0}µrad")
        );
        assert_eq!(Cell::with_error(-2.0, 0.5, ""), number("−2.00 ± 0.50"));
        assert_eq!(Cell::with_error(1.0, f64::NAN, "s"), number("1.00\u{a0}s"));
        assert_eq!(Cell::from(f64::INFINITY), Cell::Empty);
        assert_eq!(Cell::from(11.0), number("11"));
        assert_eq!(Cell::from(0.98765), number("0.9877"));
    }
}

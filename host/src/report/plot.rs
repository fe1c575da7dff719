//! What a figure shows, apart from how it is drawn.

use maud::Markup;

pub use super::bars::Bars;
pub use super::heat::Heat;
pub use super::histogram::Histogram;
pub use super::polar::Polar;
pub use super::scale::Axis;
pub use super::spectrum::Spectrum;
pub use super::strip::Strip;
pub use super::xy::{Band, Series, Xy};

use super::draw::Canvas;

/// Colours of a figure: the Okabe-Ito set, which the colour-blind tell apart, adjusted for light and dark pages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// First choice for a single series, and for what comes after correction.
    Blue,
    /// What was there before correction.
    Orange,
    /// A third series.
    Green,
    /// A fourth series.
    Purple,
    /// A fifth series.
    Sky,
    /// Truth, limits, noise floors and everything that is only there to compare with.
    Grey,
}

impl Colour {
    /// The colour of raw, uncorrected data.
    pub const BEFORE: Self = Self::Orange;
    /// The colour of corrected data.
    pub const AFTER: Self = Self::Blue;
    /// The colour of the truth or of a reference encoder.
    pub const TRUTH: Self = Self::Grey;

    /// Class that sets `currentColor`.
    pub(super) fn class(self) -> &'static str {
        match self {
            Self::Blue => "blue",
            Self::Orange => "orange",
            Self::Green => "green",
            Self::Purple => "purple",
            Self::Sky => "sky",
            Self::Grey => "grey",
        }
    }
}

/// A figure of any kind; every kind converts into it.
#[derive(Clone, Debug)]
pub enum Plot {
    /// Lines, steps and points over two axes.
    Xy(Xy),
    /// Amplitude by order.
    Spectrum(Spectrum),
    /// A value by angle and turn.
    Strip(Strip),
    /// An error around the shaft.
    Polar(Polar),
    /// How often a value occurs.
    Histogram(Histogram),
    /// Named magnitudes beside each other.
    Bars(Bars),
    /// Magnitudes by row and column.
    Heat(Heat),
}

macro_rules! into_plot {
    ($($kind:ident),*) => {$(
        impl From<$kind> for Plot {
            fn from(plot: $kind) -> Self {
                Self::$kind(plot)
            }
        }
    )*};
}
into_plot!(Xy, Spectrum, Strip, Polar, Histogram, Bars, Heat);

impl Plot {
    pub(super) fn keys(&self) -> Vec<Key> {
        match self {
            Self::Xy(p) => p.keys(),
            Self::Spectrum(p) => p.keys(),
            Self::Strip(_) => Vec::new(),
            Self::Polar(p) => p.keys(),
            Self::Histogram(p) => p.keys(),
            Self::Bars(_) | Self::Heat(_) => Vec::new(),
        }
    }

    pub(super) fn draw(&self, canvas: Canvas, label: &str) -> Markup {
        match self {
            Self::Xy(p) => p.draw(canvas, label),
            Self::Spectrum(p) => p.draw(canvas, label),
            Self::Strip(p) => p.draw(canvas, label),
            Self::Polar(p) => p.draw(label),
            Self::Histogram(p) => p.draw(canvas, label),
            Self::Bars(p) => p.draw(canvas, label),
            Self::Heat(p) => p.draw(canvas, label),
        }
    }

    /// Whether one drawing serves every width.
    pub(super) fn is_round(&self) -> bool {
        matches!(self, Self::Polar(_))
    }
}

/// How a legend entry is marked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mark {
    Line,
    Dash,
    Dot,
    Area,
}

/// One legend entry.
#[derive(Clone, Debug)]
pub(super) struct Key {
    pub(super) colour: Colour,
    pub(super) mark: Mark,
    pub(super) name: String,
}

impl Key {
    pub(super) fn new(colour: Colour, mark: Mark, name: &str) -> Self {
        Self {
            colour,
            mark,
            name: name.to_owned(),
        }
    }
}

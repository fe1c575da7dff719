//! How a diagnosis handles a mechanism: which patterns it makes, when it is tried, and how a fit is named and put into a twin.

use std::collections::BTreeMap;

use super::Mechanism;
use crate::diagnose::basis::Basis;
use crate::diagnose::board::Board;
use crate::diagnose::diagnosis::{Parameter, Place};
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::mended::Mended;
use crate::diagnose::named::{Named, Numbers};
use crate::diagnose::seen::Seen;
use crate::diagnose::shaft::ShaftLaw;
use crate::twin::Twin;

/// A rhythm of all edges alike that stands out of a residual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rhythm {
    /// Cycles a turn.
    pub order: f64,
    /// The same in Hz, at the recording's mean speed.
    pub f_hz: f64,
    /// To how many cycles a turn it is known.
    pub within: f64,
}

impl Rhythm {
    /// The whole order that it may be.
    #[must_use]
    pub fn whole(self) -> Option<f64> {
        let whole = self.order.round();
        (whole > 0.0 && (self.order - whole).abs() < self.within).then_some(whole)
    }

    /// Its order where it need not be a whole one: a hair off a whole number, so that it is known as searched for.
    #[must_use]
    pub fn fractional(self) -> Option<f64> {
        let whole = self.order.round();
        let sure = whole > 0.0 && (self.order - whole).abs() < 0.3 * self.within;
        (!sure).then_some(off_whole(self.order))
    }
}

/// An order, off a whole number by a hair if it is one.
#[must_use]
pub fn off_whole(order: f64) -> f64 {
    if order.fract() == 0.0 {
        order + 1e-9
    } else {
        order
    }
}

/// The rig that a rival is tried on.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Channels of its encoder.
    pub channels: usize,
    /// Mean speed of the recording that shows the finding best, rad/s.
    pub speed_rad_s: f64,
}

/// Where a finding shows, for its sentence.
#[derive(Clone, Copy, Debug)]
pub struct Shows<'a> {
    /// Where.
    pub place: &'a Place,
    /// Its edges in words.
    pub edges: &'a str,
}

impl Shows<'_> {
    /// Its order, 0 where it has none.
    #[must_use]
    pub fn order(&self) -> f64 {
        self.place.orders.first().copied().unwrap_or(0.0)
    }

    /// Its order with as many digits as say something: a whole one without any.
    #[must_use]
    pub fn order_in_words(&self) -> String {
        let text = format!("{:.4}", self.order());
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    }

    /// Its frequency, Hz, 0 where it has none.
    #[must_use]
    pub fn f_hz(&self) -> f64 {
        self.place.frequencies_hz.first().copied().unwrap_or(0.0)
    }
}

/// A mechanism's ways with the diagnosis. [`Handling::NONE`] is what recognises itself apart from the search for patterns.
#[derive(Clone, Copy, Debug)]
pub struct Handling {
    /// Whether a pattern is of its making; each pattern is of one mechanism's.
    pub makes: fn(Basis) -> bool,
    /// A pattern of its along a residual: one column for each number that sizes it.
    pub columns: fn(Basis, &Seen, &ShaftLaw) -> Vec<Vec<f64>>,
    /// What is tried whatever a residual shows.
    pub proposed: fn(&Board) -> Vec<Hypothesis>,
    /// What may make a rhythm of all edges alike.
    pub of_rhythm: fn(Rhythm) -> Option<Basis>,
    /// What is tried in the place of a finding of a look-alike.
    pub instead_of: fn(&Hypothesis, Setting) -> Vec<Hypothesis>,
    /// Patterns of an unknown disc that a pattern of its is fitted beside, with so many channels.
    pub beside: fn(Basis, usize) -> Vec<Basis>,
    /// The numbers of a fit.
    pub values: fn(&Numbers<'_>) -> Named,
    /// Where a fit shows, in a sentence.
    pub text: fn(Shows<'_>) -> String,
    /// Puts a pattern of given sizes into a twin.
    pub mends: fn(&mut Mended, Basis, &[f64]),
    /// Puts the numbers of a finding that is no pattern into a twin.
    pub puts_in: fn(&mut Twin, &BTreeMap<String, Parameter>),
}

impl Handling {
    /// Of a mechanism that makes no pattern and is not searched for by one.
    pub const NONE: Self = Self {
        makes: |_| false,
        columns: |_, _, _| Vec::new(),
        proposed: |_| Vec::new(),
        of_rhythm: |_| None,
        instead_of: |_, _| Vec::new(),
        beside: |_, _| Vec::new(),
        values: |_| Named::new(),
        text: |_| String::new(),
        mends: |_, _, _| {},
        puts_in: |_, _| {},
    };
}

/// The value of a finding's number.
#[must_use]
pub fn value(parameters: &BTreeMap<String, Parameter>, name: &str) -> Option<f64> {
    parameters.get(name).map(|parameter| parameter.value)
}

impl Basis {
    /// The mechanism whose mark it is.
    #[must_use]
    pub fn mechanism(self) -> Mechanism {
        let mut all = Mechanism::ALL.into_iter();
        all.find(|mechanism| (mechanism.card().handling.makes)(self))
            .unwrap_or(Mechanism::Unknown)
    }
}

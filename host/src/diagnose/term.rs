//! A pattern that physics may leave in the angle: along the turn, along time, by edge class, and how it grows with speed.

use std::f64::consts::TAU;

use super::residual::Residual;

/// What a pattern goes along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rhythm {
    /// Nothing: always the same.
    Constant,
    /// The turn: so many cycles of it, whole or not.
    Order(f64),
    /// Time, hertz.
    Hertz(f64),
}

/// Which edges show it: a weight for every class as it is passed forward.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pattern {
    /// Its name in a finding.
    pub name: &'static str,
    /// Weights; the first C count.
    pub weights: [f64; 6],
}

impl Pattern {
    /// All edges alike.
    pub const ALL: Self = Self::new("all edges alike", [1.0; 6]);

    const fn new(name: &'static str, weights: [f64; 6]) -> Self {
        Self { name, weights }
    }

    /// Ways in which the edges of a sensor with so many classes can differ.
    #[must_use]
    pub fn of_classes(classes: i64) -> &'static [Self] {
        const QUADRATURE: [Pattern; 4] = [
            Pattern::new(
                "rising against falling edges",
                [1.0, 1.0, -1.0, -1.0, 0.0, 0.0],
            ),
            Pattern::new(
                "rising against falling edges of A",
                [1.0, 0.0, -1.0, 0.0, 0.0, 0.0],
            ),
            Pattern::new(
                "rising against falling edges of B",
                [0.0, 1.0, 0.0, -1.0, 0.0, 0.0],
            ),
            Pattern::new("channel A against B", [1.0, -1.0, 1.0, -1.0, 0.0, 0.0]),
        ];
        const HALL: [Pattern; 3] = [
            Pattern::new(
                "rising against falling edges",
                [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0],
            ),
            Pattern::new(
                "channel A against B and C",
                [-1.0, 2.0, -1.0, -1.0, 2.0, -1.0],
            ),
            Pattern::new("channel B against C", [-1.0, 0.0, 1.0, -1.0, 0.0, 1.0]),
        ];
        const BOTH: [Pattern; 1] = [Pattern::new(
            "rising against falling edges",
            [1.0, -1.0, 0.0, 0.0, 0.0, 0.0],
        )];
        match classes {
            4 => &QUADRATURE,
            6 => &HALL,
            2 => &BOTH,
            _ => &[],
        }
    }
}

/// A pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// What it goes along.
    pub rhythm: Rhythm,
    /// Which edges show it.
    pub pattern: Pattern,
    /// Its size in angle goes with this power of the speed.
    pub exponent: i32,
}

impl Term {
    /// How many numbers size it: cosine and sine of a rhythm, else one.
    #[must_use]
    pub const fn count(&self) -> usize {
        match self.rhythm {
            Rhythm::Constant => 1,
            _ => 2,
        }
    }

    /// How many numbers describe it: those that size it, and a frequency that is not a whole number.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        let free = match self.rhythm {
            Rhythm::Constant => false,
            Rhythm::Order(order) => order.fract() != 0.0,
            Rhythm::Hertz(_) => true,
        };
        self.count() + usize::from(free)
    }

    /// The pattern of unit size along a residual, at the speed `reference` rad/s.
    #[must_use]
    pub fn columns(&self, residual: &Residual, reference: f64) -> Vec<Vec<f64>> {
        let mut columns = vec![Vec::with_capacity(residual.places.len()); self.count()];
        for at in 0..residual.places.len() {
            let weight = self.pattern.weights[residual.class(at).min(5)];
            let relative = residual.readings[at].speed / reference;
            let size = weight * relative.powi(self.exponent);
            let phase = match self.rhythm {
                Rhythm::Constant => {
                    columns[0].push(size);
                    continue;
                }
                Rhythm::Order(order) => order * residual.theta(at),
                Rhythm::Hertz(hertz) => TAU * hertz * residual.times_s[at],
            };
            let (sin, cos) = phase.sin_cos();
            columns[0].push(size * cos);
            columns[1].push(size * sin);
        }
        columns
    }
}

//! Numbers that an effect can be evaluated on: plain ones, power series in time, and either with a slope beside it.
//!
//! A series is the motion over a step of the integration, so an effect on it is the effect's own series (R. E. Moore, Interval
//! Analysis, 1966, on the recurrences; A. Griewank, A. Walther, Evaluating Derivatives, 2008).

use std::ops::{Add, Mul, Sub};

/// What an effect is evaluated on.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Mul<f64, Output = Self>
{
    /// A constant.
    fn constant(value: f64) -> Self;
    /// The value of it.
    fn value(self) -> f64;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// e to the power of it.
    fn exp(self) -> Self;
    /// It to a power; it is 0 or more.
    fn powf(self, power: f64) -> Self;
}

impl Number for f64 {
    fn constant(value: f64) -> Self {
        value
    }

    fn value(self) -> f64 {
        self
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        self.sin_cos()
    }

    #[inline]
    fn exp(self) -> Self {
        self.exp()
    }

    #[inline]
    fn powf(self, power: f64) -> Self {
        // A speed that passes 0 is a little below it, and what falls with it stays finite.
        self.max(NO_SERIES).powf(power)
    }
}

/// Up to so much a fractional power has no series that converges over any step: far below any speed in rad/s that an edge shows.
pub const NO_SERIES: f64 = 1e-9;
/// Most terms of a series.
pub const TERMS: usize = 17;

/// A power series of which the first terms are known; its functions are those of `libm`, alike on all machines.
#[derive(Clone, Copy, Debug)]
pub struct Series {
    /// Factors of the powers.
    pub terms: [f64; TERMS],
    /// How many are known, 1 or more.
    pub known: usize,
}

impl Series {
    /// A series of known terms.
    #[must_use]
    pub fn new(some: &[f64]) -> Self {
        let known = some.len().clamp(1, TERMS);
        let mut terms = [0.0; TERMS];
        terms[..some.len().min(TERMS)].copy_from_slice(&some[..some.len().min(TERMS)]);
        Self { terms, known }
    }

    fn with(self, other: Self, by: impl Fn(f64, f64) -> f64) -> Self {
        let known = self.known.min(other.known);
        let mut terms = [0.0; TERMS];
        for (at, term) in terms[..known].iter_mut().enumerate() {
            *term = by(self.terms[at], other.terms[at]);
        }
        Self { terms, known }
    }

    /// The sum over j of j a(j) b(k - j), over k: the term k of what integrates a' b.
    fn integrated(&self, other: &[f64; TERMS], k: usize) -> f64 {
        let sum = (1..=k).map(|j| j as f64 * self.terms[j] * other[k - j]);
        sum.sum::<f64>() / k as f64
    }
}

impl Add for Series {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        self.with(other, |a, b| a + b)
    }
}

impl Sub for Series {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self.with(other, |a, b| a - b)
    }
}

impl Mul for Series {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let known = self.known.min(other.known);
        let mut terms = [0.0; TERMS];
        for (k, term) in terms[..known].iter_mut().enumerate() {
            *term = (0..=k).map(|j| self.terms[j] * other.terms[k - j]).sum();
        }
        Self { terms, known }
    }
}

impl Mul<f64> for Series {
    type Output = Self;

    fn mul(mut self, by: f64) -> Self {
        self.terms[..self.known]
            .iter_mut()
            .for_each(|term| *term *= by);
        self
    }
}

impl Number for Series {
    fn constant(value: f64) -> Self {
        let mut terms = [0.0; TERMS];
        terms[0] = value;
        Self {
            terms,
            known: TERMS,
        }
    }

    fn value(self) -> f64 {
        self.terms[0]
    }

    fn sin_cos(self) -> (Self, Self) {
        let (mut sin, mut cos) = ([0.0; TERMS], [0.0; TERMS]);
        (sin[0], cos[0]) = libm::sincos(self.terms[0]);
        for k in 1..self.known {
            (sin[k], cos[k]) = (self.integrated(&cos, k), -self.integrated(&sin, k));
        }
        let known = self.known;
        (Self { terms: sin, known }, Self { terms: cos, known })
    }

    fn exp(self) -> Self {
        let mut terms = [0.0; TERMS];
        terms[0] = libm::exp(self.terms[0]);
        for k in 1..self.known {
            terms[k] = self.integrated(&terms, k);
        }
        Self { terms, ..self }
    }

    fn powf(self, power: f64) -> Self {
        // Whole powers are products, at 0 too.
        const MOST: f64 = 8.0;
        if power.fract() == 0.0 && (0.0..=MOST).contains(&power) {
            let mut product = Self::constant(1.0);
            for _ in 0..power as usize {
                product = product * self;
            }
            return product;
        }
        let mut terms = [0.0; TERMS];
        let first = self.terms[0];
        terms[0] = libm::pow(first.max(0.0), power);
        if first <= NO_SERIES {
            // The value alone.
            return Self { terms, ..self };
        }
        for k in 1..self.known {
            let each = (1..=k).map(|j| {
                let j_power = j as f64 * (power + 1.0) - k as f64;
                j_power * self.terms[j] * terms[k - j]
            });
            terms[k] = each.sum::<f64>() / (k as f64 * first);
        }
        Self { terms, ..self }
    }
}

/// A number with its slope along something beside it.
#[derive(Clone, Copy, Debug)]
pub struct Sloped<N> {
    /// It.
    pub at: N,
    /// Its slope.
    pub slope: N,
}

impl<N: Number> Add for Sloped<N> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            at: self.at + other.at,
            slope: self.slope + other.slope,
        }
    }
}

impl<N: Number> Sub for Sloped<N> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            at: self.at - other.at,
            slope: self.slope - other.slope,
        }
    }
}

impl<N: Number> Mul for Sloped<N> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self {
            at: self.at * other.at,
            slope: self.at * other.slope + self.slope * other.at,
        }
    }
}

impl<N: Number> Mul<f64> for Sloped<N> {
    type Output = Self;

    fn mul(self, by: f64) -> Self {
        Self {
            at: self.at * by,
            slope: self.slope * by,
        }
    }
}

impl<N: Number> Number for Sloped<N> {
    fn constant(value: f64) -> Self {
        Self {
            at: N::constant(value),
            slope: N::constant(0.0),
        }
    }

    fn value(self) -> f64 {
        self.at.value()
    }

    fn sin_cos(self) -> (Self, Self) {
        let (sin, cos) = self.at.sin_cos();
        let sine = Self {
            at: sin,
            slope: cos * self.slope,
        };
        let cosine = Self {
            at: cos,
            slope: sin * self.slope * -1.0,
        };
        (sine, cosine)
    }

    fn exp(self) -> Self {
        let at = self.at.exp();
        Self {
            at,
            slope: at * self.slope,
        }
    }

    fn powf(self, power: f64) -> Self {
        Self {
            at: Number::powf(self.at, power),
            slope: Number::powf(self.at, power - 1.0) * self.slope * power,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Series of a function over time, held against its values there.
    fn follows(series: impl Fn(Series) -> Series, plain: impl Fn(f64) -> f64) {
        let motion = Series::new(&[0.7, 0.9, -0.3, 0.2, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let value = |of: &Series, t: f64| {
            let known = of.terms[..of.known].iter().rev();
            known.fold(0.0, |sum, term| sum * t + term)
        };
        let got = series(motion);
        for t in [0.0, 0.03, 0.1] {
            let expected = plain(value(&motion, t));
            assert!((value(&got, t) - expected).abs() < 1e-10, "{t}");
        }
    }

    #[test]
    fn a_function_of_a_series_is_the_series_of_the_function() {
        follows(|x| x.sin_cos().0, f64::sin);
        follows(|x| x.sin_cos().1, f64::cos);
        follows(Number::exp, f64::exp);
        follows(|x| x.powf(1.7), |x| x.powf(1.7));
        follows(|x| x.powf(3.0), |x| x.powi(3));
        follows(|x| x * x - x * 2.0 + x, |x| x * x - x);
    }

    #[test]
    fn a_slope_is_the_derivative() {
        let x = Sloped {
            at: 0.7,
            slope: 1.0,
        };
        assert!((x.sin_cos().0.slope - 0.7_f64.cos()).abs() < 1e-15);
        assert!((x.powf(2.5).slope - 2.5 * 0.7_f64.powf(1.5)).abs() < 1e-15);
        assert!(((x * x).exp().slope - 1.4 * (0.49_f64).exp()).abs() < 1e-15);
    }
}

//! Savitzky-Golay smoother, equations (8) to (11), in exact integers.
//!
//! The smoothed value at the window's middle is sum c(u) x(u) / D with u = 0 for the oldest sample. c is a polynomial in u, so
//! it is a sum of binomials, c(u) = sum_i b_i C(u, i), all integers over one denominator D ([`SavGol::DENOMINATOR`]; 9889
//! for 31/5). b follows from the discrete Chebyshev (Gram) polynomials
//! `T_n(u) = sum_i (-1)^(n-i) C(N-1-i, n-i) C(n+i, n) C(u, i)`: c(u) = sum_n `T_n(m) T_n(u)` / h_n, h_n = sum `T_n(u)`^2.
//!
//! # Constant work
//! The filter keeps the moments S_i = sum C(u, i) x(u). When the window slides by one, C(u-1, i) = C(u, i) - C(u-1, i-1) gives
//! S_i -= S_(i-1), one subtraction a moment; the leaving sample counts in S_0 only and the new one enters as C(N-1, i) x.
//! Integers modulo 2^64 make this exact, so nothing drifts, and the moments may wrap: only the sum must fit, which is
//! checked when compiling. The work is ORDER + 1 moments whatever the window.
//!
//! Instructions an output (Cortex-M4, opt-level 3, counted in QEMU netduinoplus2 with icount, ring and division included):
//!
//! | order | this form, 5 to 101 samples | plain sum |
//! |---|---|---|
//! | 3 | 104 to 123 | |
//! | 5 | 149 to 166 (31/5: 154) | 7: 82, 15: 110, 21: 132, 31: 161, 41: 220, 61: 295 |
//! | 7 | 181 to 214 | |
//!
//! The plain sum had each sample stored twice to lie in one piece. At order 5 the forms break even just under 31 samples;
//! shorter windows would be cheaper as a plain sum. One form serves all windows here, as 31/5 and longer are what is
//! used. The tests hold it equal to the plain sum to the bit.
//!
//! # Rounding and range
//! Output is rounded to nearest, halves up, and saturates at i32. Input is clamped to plus or minus
//! [`SavGol::INPUT_MAX`], which is `i32::MAX` up to 101/5. Output belongs to the sample (WINDOW - 1) / 2 before the newest.

mod coefficients;

use coefficients::{Plan, binomial, plan};

/// Highest order.
pub const MAX_ORDER: usize = 7;

/// Smoother over `WINDOW` samples (odd) with a polynomial of degree `ORDER` (at most [`MAX_ORDER`]).
#[derive(Clone, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SavGol<const WINDOW: usize = 31, const ORDER: usize = 5> {
    ring: [i32; WINDOW],
    /// Slot of the oldest sample.
    oldest: usize,
    /// Samples seen, at most `WINDOW`.
    filled: usize,
    moments: [i64; MAX_ORDER + 1],
}

impl<const WINDOW: usize, const ORDER: usize> SavGol<WINDOW, ORDER> {
    const PLAN: Plan = plan(WINDOW, ORDER);

    /// The middle value of an even window polynomial: an odd top degree adds nothing there.
    const DEGREE: usize = ORDER / 2 * 2;

    /// Common denominator D of the coefficients.
    pub const DENOMINATOR: u64 = Self::PLAN.denominator;

    /// Largest input that cannot overflow; larger ones are clamped.
    pub const INPUT_MAX: i32 = Self::PLAN.input_max;

    /// Samples by which the output lags the input.
    pub const DELAY: usize = WINDOW / 2;

    /// An empty filter.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            ring: [0; WINDOW],
            oldest: 0,
            filled: 0,
            moments: [0; MAX_ORDER + 1],
        }
    }

    /// Coefficient of the sample `u` (0 is the oldest) as a numerator over [`SavGol::DENOMINATOR`]; 0 outside the window.
    #[must_use]
    pub const fn coefficient(u: usize) -> i64 {
        if u < WINDOW {
            Self::PLAN.coefficient(u)
        } else {
            0
        }
    }

    /// Forgets all samples.
    pub const fn reset(&mut self) {
        *self = Self::new();
    }

    /// Takes a sample; returns the smoothed value [`SavGol::DELAY`] samples ago once the window is full.
    #[inline]
    pub fn push(&mut self, sample: i32) -> Option<i32> {
        let sample = sample.clamp(-Self::INPUT_MAX, Self::INPUT_MAX);
        let leaving = self.replace_oldest(sample);
        self.slide(leaving, sample);
        if self.filled < WINDOW {
            self.filled += 1;
            if self.filled < WINDOW {
                return None;
            }
        }
        Some(Self::PLAN.divide(self.numerator()))
    }

    #[inline]
    fn replace_oldest(&mut self, sample: i32) -> i32 {
        let mut leaving = 0;
        if let Some(slot) = self.ring.get_mut(self.oldest) {
            leaving = core::mem::replace(slot, sample);
        }
        self.oldest = if self.oldest + 1 >= WINDOW {
            0
        } else {
            self.oldest + 1
        };
        leaving
    }

    /// Moves the moments on by one sample.
    #[inline]
    fn slide(&mut self, leaving: i32, entering: i32) {
        // Lower moment of the slid window, without the entering sample.
        let mut lower = i64::from(leaving);
        let weights = const { Self::entering_weights() };
        for (moment, weight) in self.moments.iter_mut().zip(weights).take(Self::DEGREE + 1) {
            lower = moment.wrapping_sub(lower);
            *moment = lower.wrapping_add(weight.wrapping_mul(i64::from(entering)));
        }
    }

    const fn entering_weights() -> [i64; MAX_ORDER + 1] {
        let mut weights = [0; MAX_ORDER + 1];
        let mut i = 0;
        while i <= Self::DEGREE {
            weights[i] = binomial(WINDOW - 1, i) as i64;
            i += 1;
        }
        weights
    }

    #[inline]
    fn numerator(&self) -> i64 {
        self.moments
            .iter()
            .zip(Self::PLAN.binomials)
            .take(Self::DEGREE + 1)
            .fold(0, |sum: i64, (moment, b)| {
                sum.wrapping_add(moment.wrapping_mul(b))
            })
    }
}

impl<const WINDOW: usize, const ORDER: usize> Default for SavGol<WINDOW, ORDER> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests;

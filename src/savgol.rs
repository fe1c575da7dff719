//! Savitzky-Golay smoothing of the speed signal in exact integers: a polynomial is fitted to the samples in a window by
//! least squares and the fit's value at the window's centre is the output.
//!
//! The fit is that of equations (8) to (11) of Yin et al. (2022), over equally spaced samples. At the centre the odd powers
//! contribute nothing, so an odd order gives the very same filter as the even order below it: 31/5 is 31/4.
//!
//! The weights are integers `n_j` over one denominator `D`, worked out at compile time. The sum `Σ n_j x_j` is exact in
//! either of two forms, and so are bit-equal outputs of both:
//!
//! - direct: one multiplication a tap, over the history;
//! - recursive: the weights are a polynomial in a sample's age `a`, so `Y_k = Σ Δ^k n(a) x_a` (power-sum moments, combined
//!   such that `Y_0` is the wanted sum) follows a new sample by `Y_k + Y_(k+1) + Δ^k n(0) x_new - Δ^k n(W) x_leaving`.
//!   Integers don't drift, and the cost does not depend on the window.
//!
//! The quotient by `D` takes two multiplications by a reciprocal: one for an estimate that is off by less than 9, one for the
//! exact remainder. The output lies within 0.5 + 2^-25 LSB of the exact rational value, and is exact where that is an integer.
//!
//! Instructions a push at order 5, mean over 2000 pushes, counted by QEMU (`-icount`, Cortex-M4F, `opt-level = 3`, fat LTO,
//! `push` not inlined, call included, the caller's loop of 4 taken off; not cycles, and flash waits are not in it):
//!
//! | window    |   7 |   9 |  15 |  21 |  31 | 101 |  301 |
//! |-----------|-----|-----|-----|-----|-----|-----|------|
//! | recursive | 119 | 116 | 123 | 123 | 118 | 125 |  245 |
//! | direct    | 111 | 128 | 161 | 205 | 256 | 545 | 2924 |
//!
//! The break-even lies between 7 and 9 samples: from 9 on a smoother is recursive. At order 5 a window of 301 needs sums of
//! more than 64 bits, in either form.

mod weights;

#[cfg(test)]
mod tests;

use weights::Weights;

/// The default smoother: 31 samples, order 5.
pub type DefaultSavGol = SavGol<31, 5>;

/// Windows from this length on are worked recursively.
const RECURSIVE_FROM: usize = 9;

/// Moments at the most: those of a polynomial of degree 4.
const MOMENTS_MAX: usize = 5;

/// Orders at the most.
const ORDER_MAX: usize = 5;

/// Windows at the most: the determinant of order 5 then fits 128 bits, sums over split weights fit 64.
const WINDOW_MAX: usize = 701;

/// Binary digits of the lower part of a split weight.
const SPLIT_BITS: u32 = 20;

/// Savitzky-Golay smoother over `WINDOW` samples (odd, 3 to 701) with a polynomial of order `ORDER` (0 to 5, below `WINDOW`).
/// Other numbers, and ones whose sums would not fit, don't compile.
///
/// Any `i32` may come in, in any unit; the output has the input's unit. A smoothed value may overshoot the input's range by
/// the sum of the weights' magnitudes (less than 2); beyond `i32` it saturates, which inputs within plus or minus 2^30 never
/// meet.
#[derive(Clone, Debug)]
pub struct SavGol<const WINDOW: usize, const ORDER: usize> {
    history: [i32; WINDOW],
    /// Where the oldest sample is, which the next one replaces.
    head: usize,
    filled: usize,
    /// Lower 64 bits of the moments; all of them where the sum fits.
    low: [i64; MOMENTS_MAX],
    /// Upper 64 bits.
    high: [i64; MOMENTS_MAX],
}

impl<const WINDOW: usize, const ORDER: usize> Default for SavGol<WINDOW, ORDER> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const WINDOW: usize, const ORDER: usize> SavGol<WINDOW, ORDER> {
    const WEIGHTS: Weights = Weights::new(WINDOW, ORDER);
    const TERMS: usize = ORDER / 2 * 2 + 1;
    const ENTERING: [i64; MOMENTS_MAX] = Self::WEIGHTS.differences(0);
    const LEAVING: [i64; MOMENTS_MAX] = Self::WEIGHTS.differences(WINDOW as i128);
    const NARROW: bool = Self::WEIGHTS.is_narrow();
    const TAPS_LOW: &'static [i32; WINDOW] = &Self::taps(false);
    const TAPS_HIGH: &'static [i32; WINDOW] = &Self::taps(true);
    /// Binary digits of `D`.
    const BITS: u32 = 128 - Self::WEIGHTS.denominator.leading_zeros();
    const DENOMINATOR: i64 = Self::WEIGHTS.denominator as i64;
    /// `2^(BITS + 30) / D`, rounded down and kept in 31 bits.
    const RECIPROCAL: i32 = {
        let exact = (1_i128 << (Self::BITS + 30)) / Self::WEIGHTS.denominator;
        if exact > i32::MAX as i128 {
            i32::MAX
        } else {
            exact as i32
        }
    };

    /// An empty smoother.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            history: [0; WINDOW],
            head: 0,
            filled: 0,
            low: [0; MOMENTS_MAX],
            high: [0; MOMENTS_MAX],
        }
    }

    /// Samples by which the output lags the input: `WINDOW / 2`.
    #[must_use]
    pub const fn delay() -> usize {
        WINDOW / 2
    }

    /// Forgets all samples.
    pub fn reset(&mut self) {
        *self = Self::new();
    }

    /// Takes the next sample and returns the smoothed value of the sample [`Self::delay`] earlier, once there are `WINDOW`
    /// samples.
    #[inline]
    pub fn push(&mut self, sample: i32) -> Option<i32> {
        if const { WINDOW >= RECURSIVE_FROM } {
            self.push_recursive(sample)
        } else {
            self.push_direct(sample)
        }
    }

    fn push_recursive(&mut self, sample: i32) -> Option<i32> {
        let leaving = self.store(sample)?;
        let sum = self.slide(sample, leaving);
        self.is_full().then(|| Self::quotient(sum))
    }

    fn push_direct(&mut self, sample: i32) -> Option<i32> {
        self.store(sample)?;
        if !self.is_full() {
            return None;
        }
        self.convolve().map(Self::quotient)
    }

    const fn is_full(&self) -> bool {
        self.filled == WINDOW
    }

    /// Puts `sample` in the place of the oldest, which it returns (0 before there was one).
    #[inline]
    fn store(&mut self, sample: i32) -> Option<i32> {
        let place = self.history.get_mut(self.head)?;
        let leaving = core::mem::replace(place, sample);
        self.head += 1;
        if self.head == WINDOW {
            self.head = 0;
        }
        if self.filled < WINDOW {
            self.filled += 1;
        }
        Some(leaving)
    }

    /// Moves the moments on by one sample and returns `Σ n_j x_j`. Wrapping is harmless: the moments are exact modulo the
    /// word, and the sum itself fits.
    #[inline]
    fn slide(&mut self, entering: i32, leaving: i32) -> i128 {
        for k in 0..Self::TERMS {
            if const { Self::NARROW } {
                let next = if k + 1 < Self::TERMS {
                    self.low[k + 1]
                } else {
                    0
                };
                self.low[k] = self.low[k]
                    .wrapping_add(next)
                    .wrapping_add(Self::ENTERING[k].wrapping_mul(i64::from(entering)))
                    .wrapping_sub(Self::LEAVING[k].wrapping_mul(i64::from(leaving)));
            } else {
                let next = if k + 1 < Self::TERMS {
                    join(self.low[k + 1], self.high[k + 1])
                } else {
                    0
                };
                let moment = join(self.low[k], self.high[k])
                    .wrapping_add(next)
                    .wrapping_add(product(Self::ENTERING[k], entering))
                    .wrapping_sub(product(Self::LEAVING[k], leaving));
                self.low[k] = moment as i64;
                self.high[k] = (moment >> 64) as i64;
            }
        }
        if const { Self::NARROW } {
            i128::from(self.low[0])
        } else {
            join(self.low[0], self.high[0])
        }
    }

    /// `Σ n_j x_j` from the history alone.
    #[inline]
    fn convolve(&self) -> Option<i128> {
        let (newer, older) = self.history.split_at_checked(self.head)?;
        let low = dot(Self::TAPS_LOW, older, newer)?;
        if const { Self::NARROW } {
            return Some(i128::from(low));
        }
        let high = dot(Self::TAPS_HIGH, older, newer)?;
        Some((i128::from(high) << SPLIT_BITS) + i128::from(low))
    }

    /// `sum / D`, rounded: see the module's text for the bound.
    #[inline]
    fn quotient(sum: i128) -> i32 {
        let reciprocal = i64::from(Self::RECIPROCAL);
        // |sum| <= 2^32 D < 2^(32 + BITS), so this fits 32 bits. Off by 4 for the digits cut, 4 for the reciprocal, 1 here.
        let top = if const { Self::NARROW } {
            ((sum as i64) >> (Self::BITS + 1)) as i32
        } else {
            (sum >> (Self::BITS + 1)) as i32
        };
        let estimate = (i64::from(top) * reciprocal) >> 29;
        // Less than 9 D in magnitude, hence right although its terms wrap.
        let remainder = (sum as i64).wrapping_sub(estimate.wrapping_mul(Self::DENOMINATOR));
        let scaled = if const { Self::BITS <= 27 } {
            remainder << (27_u32.saturating_sub(Self::BITS))
        } else {
            remainder >> (Self::BITS.saturating_sub(27))
        } as i32;
        let correction = (i64::from(scaled) * reciprocal + (1 << 56)) >> 57;
        (estimate + correction).clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32
    }

    /// The weights, or their lower or upper part where the sum needs more than 64 bits.
    const fn taps(upper: bool) -> [i32; WINDOW] {
        let mut taps = [0; WINDOW];
        let mut age = 0;
        while age < WINDOW {
            let weight = Self::WEIGHTS.at(age as i128);
            let part = if Self::NARROW {
                weight
            } else if upper {
                weight >> SPLIT_BITS
            } else {
                weight & ((1 << SPLIT_BITS) - 1)
            };
            assert!(part >= i32::MIN as i128 && part <= i32::MAX as i128);
            taps[age] = part as i32;
            age += 1;
        }
        taps
    }
}

const fn join(low: i64, high: i64) -> i128 {
    ((high as i128) << 64) | (low as u64 as i128)
}

/// `weight * sample` in 32-bit multiplications: a 128-bit one is far longer.
const fn product(weight: i64, sample: i32) -> i128 {
    let lower = (weight & 0xffff_ffff) * sample as i64;
    let upper = (weight >> 32) * sample as i64;
    ((upper as i128) << 32) + lower as i128
}

/// Inner product of `taps` with `older` followed by `newer`.
#[inline]
fn dot(taps: &[i32], older: &[i32], newer: &[i32]) -> Option<i64> {
    let (first, second) = taps.split_at_checked(older.len())?;
    let sum = |taps: &[i32], samples: &[i32], start: i64| {
        taps.iter()
            .zip(samples)
            .fold(start, |sum, (&tap, &sample)| {
                sum + i64::from(tap) * i64::from(sample)
            })
    };
    Some(sum(second, newer, sum(first, older, 0)))
}

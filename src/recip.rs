//! Reciprocals without division: normalise, linear seed, Newton.
//!
//! With d = x 2^-n in [1/2, 1), the seed 48/17 - 32/17 d is within 1/17 of 1/d; each Newton round squares that: 3.5e-3,
//! 1.2e-5, 1.5e-10. Each round errs to the low side, so the result lies below the exact value: the relative error of
//! [`Recip::of_u32`] is within -[`Recip::ERROR`] and 0, tested against exact division.

/// A reciprocal as `mantissa` 2^-`shift`, the mantissa with its top bit set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Recip {
    /// Normalised: 2^31 to 2^32 - 1.
    pub mantissa: u32,
    /// Binary digits after the point: 32 to 95.
    pub shift: u32,
}

/// 48/17 and 32/17 in Q29.
const SEED: u32 = 1_515_870_810;
const SLOPE: u32 = 1_010_580_540;

impl Recip {
    /// Bound of the relative error of [`Recip::of_u32`]: 2^-29.
    pub const ERROR: f64 = 1.0 / 536_870_912.0;
    /// Bound of the relative error of [`Recip::of_u64`]: 2^-28.
    pub const ERROR_U64: f64 = 1.0 / 268_435_456.0;

    /// 1/x; for 0 the reciprocal of 1.
    #[inline]
    #[must_use]
    pub const fn of_u32(x: u32) -> Self {
        let x = if x == 0 { 1 } else { x };
        let zeros = x.leading_zeros();
        Self {
            mantissa: newton(x << zeros),
            shift: 63 - zeros,
        }
    }

    /// 1/x from the upper 32 significant bits of x; for 0 the reciprocal of 1.
    #[inline]
    #[must_use]
    pub const fn of_u64(x: u64) -> Self {
        let x = if x == 0 { 1 } else { x };
        let zeros = x.leading_zeros();
        Self {
            mantissa: newton(((x << zeros) >> 32) as u32),
            shift: 95 - zeros,
        }
    }

    /// `value` / x, rounded down; 64-bit values keep the reciprocal's relative error.
    #[inline]
    #[must_use]
    pub const fn times(self, value: u64) -> u64 {
        let low = (value & 0xFFFF_FFFF) * self.mantissa as u64;
        let high = (value >> 32) * self.mantissa as u64 + (low >> 32);
        // `high` holds the product's digits from 32 up, and the shift is at least 32.
        high >> (self.shift.wrapping_sub(32) & 63)
    }

    /// `value` / x, rounded toward zero.
    #[inline]
    #[must_use]
    pub const fn times_signed(self, value: i64) -> i64 {
        let size = self.times(value.unsigned_abs()).cast_signed();
        if value < 0 { size.wrapping_neg() } else { size }
    }
}

/// Upper word of a product.
#[inline]
const fn high(a: u32, b: u32) -> u32 {
    ((a as u64 * b as u64) >> 32) as u32
}

/// 2^63 / `d` for a normalised `d` (top bit set), a little low, at most 2^32 - 1.
#[inline]
const fn newton(d: u32) -> u32 {
    // Reciprocal estimate in Q30: 1 to 2.
    let mut r = (SEED * 2).wrapping_sub(high(SLOPE * 2, d));
    // From Q30 to Q31 in the last round only, so that 2 still fits in between.
    let mut round = 0;
    while round < 2 {
        let product = high(r, d) + 1;
        r = ((r as u64 * ((1 << 31) - product) as u64) >> 30) as u32;
        round += 1;
    }
    let product = ((r as u64 * d as u64) >> 31) as u32 + 1;
    // At most 0xFFFF_FFFD, as was found by going through every `d`.
    let result = ((r as u64 * product.wrapping_neg() as u64) >> 30) as u32;
    if result < 1 << 31 { 1 << 31 } else { result }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Relative error of a reciprocal of `x`.
    fn error(recip: Recip, x: u64) -> f64 {
        // m x 2^-shift - 1, exactly, then rounded once.
        let one = 1i128 << recip.shift;
        let product = i128::from(recip.mantissa) * i128::from(x);
        (product - one) as f64 / one as f64
    }

    fn bounded(x: u32) {
        let error = error(Recip::of_u32(x), u64::from(x));
        assert!((-Recip::ERROR..=0.0).contains(&error), "{x}: {error:e}");
    }

    #[test]
    fn every_16_bit_value_and_a_dense_sweep_of_mantissas_stay_in_the_bound() {
        (1..=0xFFFF).for_each(bounded);
        (0x8000_0000..=u32::MAX).step_by(997).for_each(bounded);
        (0..32).for_each(|bit| {
            bounded(1 << bit);
            bounded(u32::MAX >> bit);
            bounded((1u32 << bit) | 1);
        });
    }

    #[test]
    fn zero_is_taken_as_one() {
        assert_eq!(Recip::of_u32(0), Recip::of_u32(1));
        assert_eq!(Recip::of_u64(0), Recip::of_u64(1));
    }

    proptest! {
        #[test]
        fn u64_reciprocals_stay_in_the_bound(x in 1..=u64::MAX, zeros in 0u32..64) {
            let x = (x >> zeros).max(1);
            let error = error(Recip::of_u64(x), x);
            prop_assert!((-Recip::ERROR_U64..=Recip::ERROR_U64).contains(&error), "{}: {:e}", x, error);
        }

        #[test]
        fn quotients_agree_with_division(value: i64, x in 1..=u32::MAX, zeros in 0u32..32) {
            let x = (x >> zeros).max(1);
            let exact = i128::from(value) / i128::from(x);
            let ours = i128::from(Recip::of_u32(x).times_signed(value));
            let bound = (exact.unsigned_abs() as f64 * Recip::ERROR).ceil() + 1.0;
            prop_assert!(((exact - ours).unsigned_abs() as f64) <= bound, "{} / {}: {} not {}", value, x, ours, exact);
            prop_assert!(ours.unsigned_abs() <= exact.unsigned_abs());
        }
    }
}

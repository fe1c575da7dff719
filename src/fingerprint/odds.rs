//! Probabilities from residuals, as powers of two.

use crate::log2::{LOG2_BITS, exp2, log2};

/// A bound of the probability that a statement is wrong: at most 2^-n for `Doubt(n)`, by the model in the module's head. 64 at
/// the most: beyond that other faults come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Doubt(pub u8);

impl Doubt {
    pub(super) fn of(bits: Bits) -> Self {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        Self((bits >> LOG2_BITS).clamp(0, 64) as u8)
    }
}

/// Evidence: a base-2 logarithm in Q16.
pub(super) type Bits = i64;

/// One bit.
pub(super) const BIT: Bits = 1 << LOG2_BITS;

/// By how many bits a residual `small` is likelier than `large`, both of `freedom` contrasts of noise of unknown size:
/// freedom / 2 log2(large / small).
pub(super) fn likelier(small: u64, large: u64, freedom: u32) -> Bits {
    (log(large) - log(small)) * i64::from(freedom) / 2
}

/// log2 of an energy.
pub(super) fn log(energy: u64) -> Bits {
    log2(energy.into()).into()
}

/// log2 of a count.
pub(super) fn count_bits(count: u32) -> Bits {
    log(count.into())
}

/// Weights of places, summed; a weight of one is that of the empty table.
#[derive(Clone, Copy, Debug)]
pub(super) struct WeightSum(u64);

/// Fraction bits of a sum.
const SUM_BITS: i64 = 24;

impl WeightSum {
    pub const NONE: Self = Self(0);

    /// Adds a weight of 2^`bits`.
    pub fn add(&mut self, bits: Bits) {
        let scaled = (bits + SUM_BITS * BIT).clamp(-BIT, 62 * BIT);
        #[allow(clippy::cast_possible_truncation)]
        let weight = exp2(scaled as i32);
        self.0 = self.0.saturating_add(weight.max(1));
    }

    /// Adds `count` weights of 2^-16, the most that a place abandoned at [`light`] can have.
    pub fn add_light(&mut self, count: u32) {
        self.0 = self.0.saturating_add(u64::from(count) << (SUM_BITS - 16));
    }

    /// log2 of the sum.
    pub fn bits(self) -> Bits {
        log(self.0) - SUM_BITS * BIT
    }
}

/// The residual from which on a place weighs less than 2^-16, the empty table having left `energy`.
pub(super) fn light(energy: u64, freedom: u32) -> u64 {
    let exponent = (16 << LOG2_BITS) + (32 << LOG2_BITS) / freedom.max(1);
    let factor = exp2(exponent.cast_signed());
    u64::try_from((u128::from(energy) * u128::from(factor)) >> 16).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odds_are_powers_of_the_ratio_of_residuals() {
        assert!((likelier(1000, 4000, 36) - 36 * BIT).abs() < BIT / 100);
        assert_eq!(Doubt::of(-3 * BIT), Doubt(0));
        assert_eq!(Doubt::of(30 * BIT + 5), Doubt(30));
        assert_eq!(Doubt::of(i64::MAX), Doubt(64));
    }

    #[test]
    fn weights_add_up_and_never_overflow() {
        let mut sum = WeightSum::NONE;
        for _ in 0..1000 {
            sum.add(-3 * BIT);
        }
        assert!((sum.bits() - count_bits(125)).abs() < BIT / 1000);
        sum.add(i64::MAX / 4);
        sum.add(i64::MAX / 4);
        assert!(sum.bits() >= 38 * BIT);
    }

    #[test]
    fn a_light_place_weighs_a_65536th() {
        for freedom in [9, 36, 72] {
            let bits = likelier(1 << 40, light(1 << 40, freedom), freedom);
            assert!((bits - 16 * BIT).abs() < BIT / 50, "{freedom}: {bits}");
        }
    }
}

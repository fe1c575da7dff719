//! Fine angles: what solving computes in, as many digits below 2^-32 turn as the largest error leaves free.

use super::close::saturated;
use super::spectrum::POWER_BITS;

/// The unit 2^-(32 + bits) turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Fine {
    pub bits: u32,
}

impl Fine {
    /// Digits that keep angles of up to `largest` (2^-32 turn) within 2^26, so that twice that in a coefficient's unit fits
    /// 32 bits.
    pub(super) fn for_angles(largest: u64) -> Self {
        let used = u64::BITS - largest.leading_zeros();
        Self {
            bits: 26_u32.saturating_sub(used).min(10),
        }
    }

    /// In 2^-32 turn.
    pub(super) fn angle(self, value: i32) -> i32 {
        saturated((i64::from(value) + (1 << self.bits >> 1)) >> self.bits)
    }

    /// Root of a mean square given in 2^-[`POWER_BITS`] of the squared unit, in 2^-32 turn.
    pub(super) fn root_mean_square(self, power: u64) -> u32 {
        let shift = POWER_BITS / 2 + self.bits;
        let root = (power.isqrt() + (1 << (shift - 1))) >> shift;
        u32::try_from(root).unwrap_or(u32::MAX)
    }
}

/// A factor 2^power / divisor, as a mantissa of 31 digits and a shift.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ratio {
    mantissa: u32,
    /// At most 95.
    shift: u32,
}

impl Ratio {
    /// 2^`power` / `divisor`; the divisor counts as one at least.
    pub(super) fn new(power: u32, divisor: u64) -> Self {
        let divisor = divisor.max(1);
        let size = divisor.ilog2();
        // Normalised, so that the quotient has 31 digits.
        let mantissa = if size >= 32 {
            (1_u64 << 63) / (divisor >> (size - 32))
        } else {
            (1_u64 << (31 + size)) / divisor
        };
        // Factors of 2^31 and more are not needed.
        let shift = (31 + size).saturating_sub(power);
        Self {
            mantissa: u32::try_from(mantissa).unwrap_or(u32::MAX),
            shift,
        }
    }

    /// `value` times the factor, to the nearest; digits above 64 bits are lost.
    pub(super) fn times(self, value: i64) -> i64 {
        // Word by word: a product of 128 bits takes several times as long.
        let low = (value.cast_unsigned() & 0xFFFF_FFFF) * u64::from(self.mantissa);
        let high = (value >> 32).wrapping_mul(i64::from(self.mantissa));
        if self.shift >= 32 {
            let upper = high.wrapping_add((low >> 32).cast_signed());
            let half = (1_i64 << (self.shift - 32)) >> 1;
            upper.wrapping_add(half) >> (self.shift - 32)
        } else {
            let half = (1_u64 << self.shift) >> 1;
            let lower = ((low + half) >> self.shift).cast_signed();
            (high << (32 - self.shift)).wrapping_add(lower)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ratio_multiplies_as_the_fraction_does() {
        for (power, divisor) in [
            (4_u32, 11_u64),
            (20, 65_536),
            (0, 1),
            (30, (1 << 40) + 7),
            (20, 3),
        ] {
            let exact = (f64::from(power)).exp2() / divisor as f64;
            for value in [1_000_000_i64, -123_456_789, 1 << 40] {
                let got = Ratio::new(power, divisor).times(value) as f64;
                let want = value as f64 * exact;
                assert!(
                    (got - want).abs() <= 0.51 + want.abs() * 1e-9,
                    "{power} {divisor} {value}: {got} {want}"
                );
            }
        }
    }

    #[test]
    fn fine_angles_round_to_the_nearest() {
        let fine = Fine::for_angles(400_000);
        assert_eq!(fine.bits, 7);
        assert_eq!(
            [
                fine.angle(127),
                fine.angle(-127),
                fine.angle(64),
                fine.angle(63)
            ],
            [1, -1, 1, 0]
        );
        assert_eq!(fine.root_mean_square(9 << 22), 3);
    }
}

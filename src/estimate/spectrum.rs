//! Sequences over one turn, and the size of an order in them.

/// One 32-bit number of a sequence around the turn.
pub(super) trait Sample: Copy {
    fn value(self) -> i32;
    fn of(value: i32) -> Self;
}

impl Sample for i32 {
    #[inline]
    fn value(self) -> i32 {
        self
    }

    #[inline]
    fn of(value: i32) -> Self {
        value
    }
}

/// Two 16-bit cells that hold one number.
impl Sample for [i16; 2] {
    #[inline]
    fn value(self) -> i32 {
        (i32::from(self[1]) << 16) | i32::from(self[0].cast_unsigned())
    }

    #[inline]
    #[allow(clippy::cast_possible_truncation)]
    fn of(value: i32) -> Self {
        [value as i16, (value >> 16) as i16]
    }
}

/// One order's complex size, in 2^-[`COEFFICIENT_BITS`] of the sequence's unit: the mean of x exp(-i n theta).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Coefficient {
    pub re: i32,
    pub im: i32,
}

/// Fraction bits of a [`Coefficient`].
pub(super) const COEFFICIENT_BITS: u32 = 4;

/// Fraction bits of the square of one. With sequences below 2^27 no coefficient overflows 32 bits.
pub(super) const POWER_BITS: u32 = 2 * COEFFICIENT_BITS;

impl Coefficient {
    pub(super) const ZERO: Self = Self { re: 0, im: 0 };

    /// Squared size in 2^-[`POWER_BITS`] of the squared unit.
    pub(super) fn power(self) -> u64 {
        let square = |x: i32| u64::from(x.unsigned_abs()).pow(2);
        square(self.re) + square(self.im)
    }

    /// Both parts times `factor_q30` in Q30, capped.
    #[inline(never)]
    pub(super) fn scaled(self, factor_q30: i64) -> Self {
        Self {
            re: scaled(self.re, factor_q30),
            im: scaled(self.im, factor_q30),
        }
    }

    /// Whether drawing it changes a sample: not below an eighth of the unit.
    pub(super) fn leaves_a_trace(self) -> bool {
        self.power() >= 4
    }

    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            re: self.re.saturating_add(other.re),
            im: self.im.saturating_add(other.im),
        }
    }

    pub(super) fn minus(self, other: Self) -> Self {
        Self {
            re: self.re.saturating_sub(other.re),
            im: self.im.saturating_sub(other.im),
        }
    }
}

/// A part times `factor_q30` in Q30, capped with its own sign.
pub(super) fn scaled(part: i32, factor_q30: i64) -> i32 {
    let (whole, low) = (factor_q30 >> 32, factor_q30 & i64::from(u32::MAX));
    // Beyond 2^40 the product is far beyond 32 bits, whatever the low half adds.
    let high = (i64::from(part) * whole).clamp(-1 << 40, 1 << 40);
    let product = (high << 2) + ((i64::from(part) * low) >> 30);
    i32::try_from(product).unwrap_or(if part < 0 { i32::MIN } else { i32::MAX })
}

/// Sequences that tests look into.
#[cfg(test)]
pub(super) mod waves {
    extern crate std;
    use std::vec::Vec;

    /// Samples of a turn with cosines of these orders, sizes and phases.
    pub(in super::super) fn wave(samples: usize, parts: &[(usize, f64, f64)]) -> Vec<i32> {
        (0..samples)
            .map(|j| {
                let theta = core::f64::consts::TAU * j as f64 / samples as f64;
                parts
                    .iter()
                    .map(|&(n, size, phase)| size * (n as f64 * theta + phase).cos())
                    .sum::<f64>()
                    .round() as i32
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::scaled;

    #[test]
    fn parts_are_scaled_as_in_128_bits() {
        let parts = [i32::MIN, -1_234_567, -1, 0, 1, 7_654_321, i32::MAX];
        let ends = [0, 1, 1 << 30, (1 << 32) - 1, 1 << 32, 1 << 41, i64::MAX];
        for factor in ends
            .into_iter()
            .flat_map(|end| [end, !end, end / 3, -(end / 5)])
        {
            for part in parts {
                let product = (i128::from(part) * i128::from(factor)) >> 30;
                let capped = if part < 0 { i32::MIN } else { i32::MAX };
                let expected = i32::try_from(product).unwrap_or(capped);
                assert_eq!(scaled(part, factor), expected, "{part} {factor}");
            }
        }
    }
}

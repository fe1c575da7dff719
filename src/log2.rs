//! Base-2 logarithm and its inverse in Q16, for weighing powers that span many decades.

/// Fraction bits of a logarithm.
pub const LOG2_BITS: u32 = 16;

/// log2 of `value` in Q16, error below 3.5e-5; the logarithm of zero is taken as that of one half.
#[must_use]
#[inline(never)]
pub fn log2(value: u128) -> i32 {
    if value == 0 {
        return -(1 << LOG2_BITS);
    }
    let whole = 127 - value.leading_zeros();
    // Mantissa in [1, 2), Q30.
    let mantissa = if whole >= 30 {
        value >> (whole - 30)
    } else {
        value << (30 - whole)
    };
    #[allow(clippy::cast_possible_truncation)]
    let x = mantissa as i64 - (1 << 30);
    // log2(1 + x) as x times a quartic: a least-maximum fit whose ends are exact, coefficients in Q30.
    let mul = |a: i64, b: i64| (a * b) >> 30;
    let poly = C0 + mul(x, C1 + mul(x, C2 + mul(x, C3 + mul(x, C4))));
    #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)]
    let whole = (whole as i32) << LOG2_BITS;
    #[allow(clippy::cast_possible_truncation)]
    let fraction = (mul(x, poly) >> (30 - LOG2_BITS)) as i32;
    whole + fraction
}

const C0: i64 = q30(1.441_917_5);
const C1: i64 = q30(-0.709_101_3);
const C2: i64 = q30(0.415_621);
const C3: i64 = q30(-0.193_592_7);
const C4: i64 = (1 << 30) - C0 - C1 - C2 - C3;

#[allow(clippy::cast_possible_truncation)]
const fn q30(x: f64) -> i64 {
    (x * 1_073_741_824.0) as i64
}

/// 2^`exponent` (Q16) as an integer, relative error below 1e-5 (and at least one half of an integer step), saturating at 2^63.
#[must_use]
#[inline(never)]
pub fn exp2(exponent: i32) -> u64 {
    let whole = exponent >> LOG2_BITS;
    if whole >= 63 {
        return 1 << 63;
    }
    if whole < -1 {
        return 0;
    }
    let x = i64::from(exponent & ((1 << LOG2_BITS) - 1)) << (30 - LOG2_BITS);
    let mul = |a: i64, b: i64| (a * b) >> 30;
    let mantissa = (1 << 30) + mul(x, E1 + mul(x, E2 + mul(x, E3 + mul(x, E4))));
    let mantissa = mantissa.cast_unsigned();
    if whole >= 30 {
        mantissa << (whole - 30)
    } else {
        (mantissa >> (29 - whole)).div_ceil(2)
    }
}

const E1: i64 = q30(0.693_004);
const E2: i64 = q30(0.241_550_3);
const E3: i64 = q30(0.051_742_8);
const E4: i64 = (1 << 30) - E1 - E2 - E3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn log2_stays_within_its_bound() {
        let mut worst: f64 = 0.0;
        for i in 1..400_000_u64 {
            for value in [
                u128::from(i),
                u128::from(i) << 47,
                u128::from(i * 7919) * u128::from(i),
            ] {
                let exact = (value as f64).log2();
                worst = worst.max((f64::from(log2(value)) / 65536.0 - exact).abs());
            }
        }
        assert!(worst < 3.5e-5, "{worst:e}");
    }

    #[test]
    fn exp2_stays_within_its_bound() {
        let mut worst: f64 = 0.0;
        for exponent in (20 << 16)..(22 << 16) {
            let exact = (f64::from(exponent) / 65536.0).exp2();
            worst = worst.max((exp2(exponent) as f64 / exact - 1.0).abs());
        }
        assert!(worst < 1e-5, "{worst:e}");
        assert_eq!(
            [
                exp2(0),
                exp2(1 << 16),
                exp2(10 << 16),
                exp2(-(5 << 16)),
                exp2(200 << 16)
            ],
            [1, 2, 1024, 0, 1 << 63]
        );
    }
}

//! Long divisions, each once in the code: where the compiler puts one into its caller it takes one to two kilobytes.

/// A quotient; that by one where the divisor is zero.
#[inline(never)]
pub(crate) fn over(value: u128, divisor: u128) -> u128 {
    value / divisor.max(1)
}

/// A quotient, cut off towards zero; that by one where the divisor is zero.
#[inline(never)]
pub(crate) fn over_signed(value: i128, divisor: i128) -> i128 {
    let size = over(value.unsigned_abs(), divisor.unsigned_abs()).cast_signed();
    if (value < 0) == (divisor < 0) {
        size
    } else {
        size.wrapping_neg()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotients_are_cut_off_towards_zero() {
        for value in [
            i128::MIN + 1,
            -(7 << 80),
            -7,
            -1,
            0,
            1,
            7,
            9 << 90,
            i128::MAX,
        ] {
            for divisor in [-(1 << 70), -3, -1, 1, 3, 1 << 70] {
                assert_eq!(over_signed(value, divisor), value / divisor);
            }
            assert_eq!(over_signed(value, 0), value);
        }
        assert_eq!(over(u128::MAX, 1 << 100), u128::MAX >> 100);
        assert_eq!(over(9, 0), 9);
    }
}

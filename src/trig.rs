//! Sine and cosine of a fraction of a turn in integers, for the order spectrum.

use crate::units::Turn32;

/// Fraction bits of [`sin_cos`] results: 1.0 is `1 << 30`.
pub const SINE_BITS: u32 = 30;

const ONE: i64 = 1 << SINE_BITS;

/// `(sin, cos)` in Q30; the error is below 1e-8.
///
/// The angle is folded to the nearest octant, where Taylor series to the tenth power in Q30 suffice.
#[must_use]
pub fn sin_cos(angle: Turn32) -> (i32, i32) {
    // Nearest multiple of a quarter turn, and what is left of it: plus or minus an eighth.
    let quarter = angle.0.wrapping_add(1 << 29) >> 30;
    let rest = i64::from(angle.0.wrapping_sub(quarter << 30).cast_signed());
    // rest is in 2^-32 turn; x in radians, Q30: x = rest * 2 pi / 2^32 * 2^30.
    const TAU_Q29: i64 = 3_373_259_426;
    let x = (rest * TAU_Q29) >> 31;
    let x2 = (x * x) >> SINE_BITS;
    let mul = |a: i64, b: i64| (a * b) >> SINE_BITS;
    let sine = mul(
        x,
        ONE - mul(x2, ONE - mul(x2, ONE - mul(x2, ONE - x2 / 72) / 42) / 20) / 6,
    );
    let cosine = ONE
        - mul(
            x2,
            ONE - mul(x2, ONE - mul(x2, ONE - mul(x2, ONE - x2 / 90) / 56) / 30) / 12,
        ) / 2;
    #[allow(clippy::cast_possible_truncation)]
    let (s, c) = (sine as i32, cosine as i32);
    match quarter & 3 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_stay_within_1e_8_of_f64() {
        let mut worst: f64 = 0.0;
        for i in 0..200_000_u32 {
            let angle = i.wrapping_mul(2_654_435_761);
            let (s, c) = sin_cos(Turn32(angle));
            let x = f64::from(angle) * crate::units::RAD_PER_TURN32;
            let scale = f64::from(1 << SINE_BITS);
            worst = worst
                .max((f64::from(s) / scale - x.sin()).abs())
                .max((f64::from(c) / scale - x.cos()).abs());
        }
        assert!(worst < 1e-8, "{worst:e}");
    }
}

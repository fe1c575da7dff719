//! Sine and cosine of a fraction of a turn in integers, for the order spectrum.

use crate::units::Turn32;

/// Fraction bits of [`sin_cos`] results: 1.0 is `1 << 30`.
pub const SINE_BITS: u32 = 30;

const ONE: i32 = 1 << SINE_BITS;

/// -1/3!, 1/5!, -1/7!, 1/9! and -1/2!, 1/4!, -1/6!, 1/8!, -1/10!, Q30, the last first.
const SINE: [i32; 4] = [2_959, -213_044, 8_947_849, -178_956_971];
const COSINE: [i32; 5] = [-296, 26_630, -1_491_308, 44_739_243, -536_870_912];

/// Q30, rounded.
#[inline]
fn product(a: i32, b: i32) -> i32 {
    #[allow(clippy::cast_possible_truncation)]
    let rounded = ((i64::from(a) * i64::from(b) + (1 << (SINE_BITS - 1))) >> SINE_BITS) as i32;
    rounded
}

/// A polynomial by Horner's rule.
#[inline]
fn series<const N: usize>(square: i32, of: [i32; N]) -> i32 {
    of.iter()
        .fold(0, |sum, factor| product(sum, square) + factor)
}

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
    #[allow(clippy::cast_possible_truncation)]
    let x = ((rest * TAU_Q29) >> 31) as i32;
    let square = product(x, x);
    let s = x + product(x, product(square, series(square, SINE)));
    let c = ONE + product(square, series(square, COSINE));
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

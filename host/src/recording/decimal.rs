//! Decimal numbers read exactly as integers of a smaller unit, with no binary rounding on the way.

/// Why a text is not a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DecimalError {
    /// Not a decimal number.
    Syntax,
    /// NaN or an infinity.
    NotFinite,
    /// More than an `i64` of the unit holds.
    Overflow,
}

/// `text` times 10^`scale` as an integer: `parse(b"1.5e-3", 9)` is the number of nanoseconds in 1.5e-3 s.
///
/// Exact up to the last digit kept; what is finer is rounded to nearest, halves away from zero.
pub(super) fn parse(text: &[u8], scale: i32) -> Result<i64, DecimalError> {
    let (negative, unsigned) = match text {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, text),
    };
    let digits_end = unsigned
        .iter()
        .position(|b| matches!(b, b'e' | b'E'))
        .unwrap_or(unsigned.len());
    let (mantissa, exponent) = unsigned.split_at(digits_end);
    let whole = mantissa
        .iter()
        .position(|&b| b == b'.')
        .unwrap_or(mantissa.len());
    let digits = mantissa.len() - usize::from(whole < mantissa.len());
    let well_formed = mantissa
        .iter()
        .enumerate()
        .all(|(place, b)| b.is_ascii_digit() || place == whole);
    if digits == 0 || !well_formed {
        return Err(if is_not_finite(unsigned) {
            DecimalError::NotFinite
        } else {
            DecimalError::Syntax
        });
    }
    // Digits before this place make up the integer; the one at it decides the rounding.
    let kept = whole as i64 + i64::from(scale) + parse_exponent(exponent)?;
    let magnitude = take_digits(mantissa.iter().filter(|b| b.is_ascii_digit()), kept)?;
    let signed = if negative {
        -i128::from(magnitude)
    } else {
        i128::from(magnitude)
    };
    i64::try_from(signed).map_err(|_| DecimalError::Overflow)
}

/// The first `kept` digits as an integer, padded with zeros or rounded.
fn take_digits<'a>(digits: impl Iterator<Item = &'a u8>, kept: i64) -> Result<u64, DecimalError> {
    let mut value: u64 = 0;
    let mut place = 0;
    let push = |value: u64, digit: u8| {
        value
            .checked_mul(10)
            .and_then(|v| v.checked_add(u64::from(digit)))
            .ok_or(DecimalError::Overflow)
    };
    for digit in digits.map(|b| b - b'0') {
        if place < kept {
            value = push(value, digit)?;
        } else {
            let up = u64::from(place == kept && digit >= 5);
            return value.checked_add(up).ok_or(DecimalError::Overflow);
        }
        place += 1;
    }
    while place < kept && value != 0 {
        value = push(value, 0)?;
        place += 1;
    }
    Ok(value)
}

/// The exponent with its letter, or nothing for 0; saturates far outside of what any time can have.
fn parse_exponent(text: &[u8]) -> Result<i64, DecimalError> {
    let (negative, digits) = match text {
        [] => return Ok(0),
        [_, b'-', rest @ ..] => (true, rest),
        [_, b'+', rest @ ..] | [_, rest @ ..] => (false, rest),
    };
    if digits.is_empty() || !digits.iter().all(u8::is_ascii_digit) {
        return Err(DecimalError::Syntax);
    }
    let value = digits.iter().fold(0i64, |value, b| {
        value
            .saturating_mul(10)
            .saturating_add(i64::from(b - b'0'))
            .min(1 << 40)
    });
    Ok(if negative { -value } else { value })
}

fn is_not_finite(unsigned: &[u8]) -> bool {
    [&b"nan"[..], b"inf", b"infinity"]
        .iter()
        .any(|name| unsigned.eq_ignore_ascii_case(name))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn seconds_become_nanoseconds_exactly() {
        for (text, ns) in [
            ("0.080654", 80_654_000),
            ("-0.5", -500_000_000),
            ("1.5e-3", 1_500_000),
            ("1E+3", 1_000_000_000_000),
            (".25", 250_000_000),
            ("7.", 7_000_000_000),
            ("9223372036.854775807", i64::MAX),
            ("-9223372036.854775808", i64::MIN),
            ("0.0000000005", 1),
            ("-0.0000000005", -1),
            ("0.00000000049999", 0),
            ("0e99999999999999999999999", 0),
            ("5e-99999999999999999999999", 0),
            // An f64 cannot tell these two apart.
            ("9007199.254740993", 9_007_199_254_740_993),
            ("9007199.254740992", 9_007_199_254_740_992),
        ] {
            assert_eq!(parse(text.as_bytes(), 9), Ok(ns), "{text}");
        }
    }

    #[test]
    fn what_is_not_a_time_is_told_apart() {
        for text in [
            "", "-", ".", "e3", "1e", "1e+", "1.2.3", "0x10", "1,5", " 1", "--1", "1e5.5", "naan",
        ] {
            assert_eq!(
                parse(text.as_bytes(), 9),
                Err(DecimalError::Syntax),
                "{text}"
            );
        }
        for text in ["nan", "NaN", "-inf", "+Infinity"] {
            assert_eq!(
                parse(text.as_bytes(), 9),
                Err(DecimalError::NotFinite),
                "{text}"
            );
        }
        for text in ["9223372036.854775808", "1e30", "1e99999999999999999999"] {
            assert_eq!(
                parse(text.as_bytes(), 9),
                Err(DecimalError::Overflow),
                "{text}"
            );
        }
    }

    proptest! {
        #[test]
        fn every_nanosecond_count_survives_being_printed(ns in any::<i64>()) {
            let magnitude = ns.unsigned_abs();
            let sign = if ns < 0 { "-" } else { "" };
            let text = format!("{sign}{}.{:09}", magnitude / 1_000_000_000, magnitude % 1_000_000_000);
            prop_assert_eq!(parse(text.as_bytes(), 9), Ok(ns));
        }

        #[test]
        fn no_bytes_make_it_panic(bytes in proptest::collection::vec(any::<u8>(), 0..40), scale in -3..12) {
            let _ = parse(&bytes, scale);
        }
    }
}

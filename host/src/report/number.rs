//! Numbers as an engineer writes them: SI prefixes, a true minus sign, groups of three digits.

/// The typographic minus sign, as wide as a digit.
pub(super) const MINUS: &str = "\u{2212}";

/// Units that never take a prefix.
const PLAIN: [&str; 14] = [
    "", "%", "deg", "°", "turn", "turns", "r/min", "rpm", "dB", "order", "orders", "ticks", "LSB",
    "edges",
];

/// Whether a unit takes SI prefixes.
pub(super) fn takes_prefix(unit: &str) -> bool {
    !PLAIN.contains(&unit) && !unit.contains(['²', '^'])
}

fn prefix(exponent: i32) -> &'static str {
    match exponent {
        -24 => "y",
        -21 => "z",
        -18 => "a",
        -15 => "f",
        -12 => "p",
        -9 => "n",
        -6 => "\u{b5}",
        -3 => "m",
        3 => "k",
        6 => "M",
        9 => "G",
        12 => "T",
        15 => "P",
        18 => "E",
        21 => "Z",
        24 => "Y",
        _ => "",
    }
}

/// Value and unit apart, to three significant digits: `(120, µrad)` for 1.2e-4 rad. A value that is not finite is a dash.
pub fn si_parts(value: f64, unit: &str) -> (String, String) {
    si_digits(value, unit, 3)
}

/// Value and unit apart, to `digits` significant digits (1 to 9).
pub fn si_digits(value: f64, unit: &str, digits: usize) -> (String, String) {
    let digits = digits.clamp(1, 9) as i32;
    if !value.is_finite() {
        return ("–".to_owned(), unit.to_owned());
    }
    if value == 0.0 {
        return ("0".to_owned(), unit.to_owned());
    }
    // Rounding comes first, so that 999.9 becomes 1.00 k and not 1000.
    let rounded = format!("{value:.*e}", digits as usize - 1);
    let (mantissa, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    let (mantissa, exponent): (f64, i32) = (
        mantissa.parse().unwrap_or(value),
        exponent.parse().unwrap_or(0),
    );
    let decimals = |shift: i32| (digits - 1 - shift).max(0) as usize;
    if takes_prefix(unit) {
        let thousand = (exponent.div_euclid(3) * 3).clamp(-24, 24);
        let shift = exponent - thousand;
        // What is smaller than the smallest prefix is shown as zero, not as a row of them.
        let places = decimals(shift).min(digits as usize - 1);
        let number = grouped(mantissa * power_of_ten(shift), places);
        (number, format!("{}{unit}", prefix(thousand)))
    } else if (-3..6).contains(&exponent) {
        let number = grouped(mantissa * power_of_ten(exponent), decimals(exponent));
        (number, unit.to_owned())
    } else {
        let number = format!(
            "{}×10{}",
            grouped(mantissa, decimals(0)),
            superscript(exponent)
        );
        (number, unit.to_owned())
    }
}

/// `120 µrad` for 1.2e-4 rad: three significant digits, prefix, no-break space.
pub fn si(value: f64, unit: &str) -> String {
    let (number, unit) = si_parts(value, unit);
    match unit.as_str() {
        "" => number,
        "%" => format!("{number}%"),
        _ => format!("{number}\u{a0}{unit}"),
    }
}

/// The power of ten as the nearest double. `powi` may be off in its last digit, and differently so from build to build.
pub(super) fn power_of_ten(exponent: i32) -> f64 {
    format!("1e{exponent}").parse().unwrap_or(f64::NAN)
}

/// The exponent of the first digit: 3 for 1000 and for 9999. 0 for zero and what is not finite.
pub(super) fn decimal_exponent(value: f64) -> i32 {
    let text = format!("{value:e}");
    let exponent = text.split_once('e').map(|(_, exponent)| exponent.parse());
    exponent.and_then(Result::ok).unwrap_or(0)
}

/// Power of ten and unit for an axis that reaches `largest`: `(-6, µrad)`.
pub(super) fn prefixed_unit(largest: f64, unit: &str) -> (i32, String) {
    if largest <= 0.0 || !largest.is_finite() {
        return (0, unit.to_owned());
    }
    let exponent = decimal_exponent(largest * (1.0 + 1e-9));
    let thousand = exponent.div_euclid(3) * 3;
    if takes_prefix(unit) && (-24..=24).contains(&thousand) {
        (thousand, format!("{}{unit}", prefix(thousand)))
    } else if takes_prefix(unit) || !(-3..7).contains(&exponent) {
        let power = format!("×10{}", superscript(thousand));
        let unit = format!("{power} {unit}").trim_end().to_owned();
        (thousand, unit)
    } else {
        (0, unit.to_owned())
    }
}

/// Fixed decimals, digits grouped by thin spaces from 10 000 on, with a true minus sign and no negative zero.
pub(super) fn grouped(value: f64, decimals: usize) -> String {
    let text = format!("{:.*}", decimals.min(12), value.abs());
    let negative = value < 0.0 && text.bytes().any(|b| (b'1'..=b'9').contains(&b));
    let (whole, rest) = text.split_at(text.find('.').unwrap_or(text.len()));
    let mut out = String::from(if negative { MINUS } else { "" });
    for (i, c) in whole.chars().enumerate() {
        if i > 0 && whole.len() > 4 && (whole.len() - i) % 3 == 0 {
            out.push('\u{202f}');
        }
        out.push(c);
    }
    out + rest
}

/// An exponent in superscript figures.
pub(super) fn superscript(exponent: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    exponent
        .to_string()
        .chars()
        .map(|c| c.to_digit(10).map_or('⁻', |d| DIGITS[d as usize]))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_take_the_prefix_that_leaves_one_to_three_digits() {
        assert_eq!(si(1.2e-4, "rad"), "120\u{a0}\u{b5}rad");
        assert_eq!(si(-1.5678, "rad/s"), "−1.57\u{a0}rad/s");
        assert_eq!(si(8.4e7, "Hz"), "84.0\u{a0}MHz");
        assert_eq!(si(0.0, "rad"), "0\u{a0}rad");
        assert_eq!(si(0.9996, "rad"), "1.00\u{a0}rad");
        assert_eq!(si(999.9e-6, "s"), "1.00\u{a0}ms");
        assert_eq!(si(1e-40, "s"), "0.00\u{a0}ys");
    }

    #[test]
    fn powers_of_ten_are_exact_and_exponents_are_the_first_digit_s() {
        assert_eq!(power_of_ten(-24), 1e-24);
        assert_eq!(power_of_ten(22), 1e22);
        for (value, exponent) in [
            (1000.0, 3),
            (999.999, 2),
            (-1e-6, -6),
            (0.0, 0),
            (f64::INFINITY, 0),
        ] {
            assert_eq!(decimal_exponent(value), exponent, "{value}");
        }
    }

    #[test]
    fn plain_units_keep_their_size() {
        assert_eq!(si(98.9, "%"), "98.9%");
        assert_eq!(si(15.0, "r/min"), "15.0\u{a0}r/min");
        assert_eq!(si(123456.0, ""), "123\u{202f}000");
        assert_eq!(si(1.2e-5, ""), "1.20×10⁻⁵");
        assert_eq!(si(f64::NAN, "rad"), "–\u{a0}rad");
    }

    #[test]
    fn grouping_starts_at_five_digits_and_zero_has_no_sign() {
        assert_eq!(grouped(1000.0, 0), "1000");
        assert_eq!(grouped(-1234567.25, 1), "−1\u{202f}234\u{202f}567.2");
        assert_eq!(grouped(-0.001, 1), "0.0");
    }
}

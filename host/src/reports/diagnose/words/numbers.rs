//! Numbers with their units and intervals in words.

use std::collections::BTreeMap;

use crate::diagnose::diagnosis::Parameter;
use crate::report::{Cell, si, si_digits};

/// A unit as numbers are written with: what may take a prefix, and what comes after it unchanged.
fn parts(unit: &str) -> (&str, &str) {
    match unit {
        "1" => ("", ""),
        per if per.starts_with("1/") => ("", per),
        // The prefix is the newton's, so the power does not forbid it.
        squared if squared.starts_with("N ") && squared.ends_with("^2") => {
            (squared.trim_end_matches("^2"), "^2")
        }
        unit => (unit, ""),
    }
}

fn joined(number: &str, rest: &str) -> String {
    let space = if rest.starts_with("1/") { " " } else { "" };
    format!("{}{space}{rest}", number.replace('\u{a0}', " "))
}

/// Value and unit; a unit that counts by one (`1/s`) takes no prefix.
#[must_use]
pub fn value(value: f64, unit: &str) -> String {
    let (prefixed, rest) = parts(unit);
    joined(&si(value, prefixed), rest)
}

/// A parameter and its interval: `500.0 ± 1.2 µrad`, or `500 µrad, 480 µrad to 560 µrad` where it lies askew.
#[must_use]
pub fn with_interval(parameter: &Parameter) -> String {
    let Parameter {
        value: at, unit, ..
    } = parameter;
    let Some([low, high]) = parameter.ci95 else {
        return value(*at, unit);
    };
    let (below, above) = (at - low, high - at);
    let half = (below + above) / 2.0;
    let even = (above - below).abs() < 0.2 * half;
    let (prefixed, rest) = parts(unit);
    match Cell::with_error(*at, half, prefixed) {
        Cell::Number(number) if even && *at != 0.0 => joined(&number, rest),
        _ => format!(
            "{}, {} to {}",
            value(*at, unit),
            value(low, unit),
            value(high, unit)
        ),
    }
}

/// Parameters as they are read: harmonics by their orders, after what has none.
#[must_use]
pub fn in_order(parameters: &BTreeMap<String, Parameter>) -> Vec<(&String, &Parameter)> {
    let order = |name: &str| {
        let (order, _) = name.strip_prefix("order_")?.rsplit_once('.')?;
        order.parse::<f64>().ok()
    };
    let mut all: Vec<_> = parameters.iter().collect();
    all.sort_by(|a, b| {
        let [a, b] = [a, b].map(|(name, _)| order(name).unwrap_or(0.0));
        a.total_cmp(&b)
    });
    all
}

/// The twin's name of a parameter as words, its unit taken off: `b.rise_less_fall_s` is `B: rise less fall`.
#[must_use]
pub fn parameter_name(name: &str, unit: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() { c } else { '_' };
    // Of a twin without an inertia, torques are over it.
    let unit = unit.trim_end_matches("/(kg m^2)");
    let suffix: String = unit
        .replace('^', "")
        .replace("1/", "per_")
        .to_lowercase()
        .chars()
        .map(plain)
        .collect();
    let bare = name
        .strip_suffix(&suffix)
        .and_then(|rest| rest.strip_suffix('_'))
        .filter(|rest| !rest.is_empty())
        .unwrap_or(name);
    match bare.rsplit_once('.') {
        // Both would be a Stribeck.
        None if bare == "stribeck" => match unit {
            "rad/s" => "Stribeck speed".to_owned(),
            _ => "Stribeck friction".to_owned(),
        },
        Some((order, rest)) if order.starts_with("order_") => {
            format!("{}: {}", order.replace('_', " "), rest.replace('_', " "))
        }
        Some((channel, rest)) => format!("{}: {}", channel.to_uppercase(), rest.replace('_', " ")),
        None => bare.replace('_', " "),
    }
}

/// A probability; 0 is what is too small to be told from it.
#[must_use]
pub fn probability(p: f64) -> String {
    match p {
        p if !p.is_finite() => "not known".to_owned(),
        p if p < 1e-15 => "under 1e-15".to_owned(),
        p if p < 1e-3 => format!("{p:.0e}"),
        p => si_digits(p, "", 2).0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(value: f64, unit: &str, ci95: Option<[f64; 2]>) -> Parameter {
        Parameter {
            value,
            unit: unit.to_owned(),
            ci95,
        }
    }

    #[test]
    fn an_interval_decides_the_digits_of_its_value() {
        for (value, unit, ci95, expected) in [
            (5e-4, "rad", [4.988e-4, 5.012e-4], "500.0 ± 1.2 µrad"),
            (3.6879, "rad", [3.6859, 3.6899], "3.6879 ± 0.0020 rad"),
            (-2.0, "N m", [-2.5, -1.5], "−2.00 ± 0.50 N m"),
            (3e-7, "N m s^2", [2e-7, 4e-7], "300 ± 100 nN m s^2"),
            (5e-4, "s", [4e-4, 9e-4], "500 µs, 400 µs to 900 µs"),
            (0.0, "s", [-1e-6, 1e-6], "0 s, −1.00 µs to 1.00 µs"),
            (0.02, "1/s", [0.018, 0.022], "0.0200 ± 0.0020 1/s"),
            (3.5, "1", [3.4, 3.6], "3.50 ± 0.10"),
        ] {
            assert_eq!(with_interval(&parameter(value, unit, Some(ci95))), expected);
        }
        assert_eq!(with_interval(&parameter(100.0, "Hz", None)), "100 Hz");
    }

    #[test]
    fn a_parameter_loses_its_unit() {
        for (name, unit, words) in [
            ("amplitude_rad", "rad", "amplitude"),
            ("b.rise_less_fall_s", "s", "B: rise less fall"),
            ("drag_n_m_s2", "N m s^2", "drag"),
            ("stiffness_n_m_rad", "N m/rad", "stiffness"),
            ("stribeck_rad_s", "rad/s", "Stribeck speed"),
            ("stribeck_n_m", "N m", "Stribeck friction"),
            ("fraction_per_s", "1/s", "fraction"),
            ("order", "1", "order"),
            ("order_1.5.torque_n_m", "N m", "order 1.5: torque"),
            ("torque_n_m", "N m/(kg m^2)", "torque"),
            ("s", "s", "s"),
        ] {
            assert_eq!(parameter_name(name, unit), words);
        }
    }

    #[test]
    fn a_tiny_probability_is_not_nothing() {
        assert_eq!(probability(0.0), "under 1e-15");
        assert_eq!(probability(3.2e-7), "3e-7");
        assert_eq!(probability(0.43), "0.43");
    }
}

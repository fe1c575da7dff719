//! A diagnosis in words, the same in the report and on the terminal.

pub use super::compared::{by_slips, is_noise, judged_on, residual, what_is_left};
use crate::diagnose::diagnosis::{
    Band, Diagnosis, Evidence, Finding, Fit, NextRecording, Parameter, Verdict,
};
use crate::mechanism::Mechanism;
use crate::report::{Cell, si, si_digits};

/// The verdict's name, as in the JSON.
#[must_use]
pub const fn verdict_id(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Complete => "complete",
        Verdict::Explained => "explained",
        Verdict::Partly => "partly",
        Verdict::Ambiguous => "ambiguous",
        Verdict::Unknown => "unknown",
    }
}

/// What the verdict means, as a clause.
#[must_use]
pub const fn meaning(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Complete => "the twin explains the recordings; what is left is noise",
        Verdict::Explained => "with the findings, what is left is noise",
        Verdict::Partly => "the findings have names, and something else is left",
        Verdict::Ambiguous => "these recordings allow more than one mechanism",
        Verdict::Unknown => "something is there, and it is none of the known mechanisms",
    }
}

/// The verdict in a sentence or two.
#[must_use]
pub fn headline(diagnosis: &Diagnosis) -> String {
    let summary = diagnosis.summary.trim();
    if summary.is_empty() {
        let meaning = meaning(diagnosis.verdict);
        return sentence(meaning) + ".";
    }
    summary.to_owned()
}

/// Title and id: `disc off its centre (eccentricity)`.
#[must_use]
pub fn named(mechanism: Mechanism) -> String {
    format!("{} ({mechanism})", mechanism.title())
}

/// A list with "and" before its last.
#[must_use]
pub fn list(names: &[String]) -> String {
    joined_by("and", names)
}

/// A list with "or" before its last.
#[must_use]
pub fn list_or(names: &[String]) -> String {
    joined_by("or", names)
}

fn joined_by(word: &str, names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => one.clone(),
        [rest @ .., last] => format!("{} {word} {last}", rest.join(", ")),
    }
}

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

/// The twin's name of a parameter as words, its unit taken off: `b.rise_less_fall_s` is `B: rise less fall`.
#[must_use]
pub fn parameter_name(name: &str, unit: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() { c } else { '_' };
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
    match bare.split_once('.') {
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

/// The confidence in percent; never a round 100.
#[must_use]
pub fn confidence(finding: &Finding) -> String {
    match 100.0 * finding.confidence {
        percent if percent >= 99.95 => "over 99.9 %".to_owned(),
        percent if percent < 10.0 => format!("{percent:.1} %"),
        percent => format!("{percent:.1} %").replace(".0 %", " %"),
    }
}

/// What speaks for a finding: against what it was held, and what came of it.
#[must_use]
pub fn evidence(evidence: &Evidence) -> Vec<(String, String)> {
    let worse = |delta: f64| match delta {
        delta if delta < 0.0 => format!("{:.1} better by the criterion (BIC)", -delta),
        delta if delta < 10.0 => {
            format!("{delta:.1} worse by the criterion (BIC), which decides nothing")
        }
        delta => format!("{delta:.0} worse by the criterion (BIC), where 10 is strong"),
    };
    let mut rows = vec![("without it".to_owned(), worse(evidence.delta_bic))];
    if let Some(next) = &evidence.runner_up {
        let instead = format!("with the next best instead, {}", named(next.mechanism));
        rows.push((instead, worse(next.delta_bic)));
    }
    rows.push((
        "noise alone".to_owned(),
        format!(
            "shows as much, anywhere that was searched, with probability {}",
            probability(evidence.p_value)
        ),
    ));
    if let Some(ratio) = evidence.held_out_rms_ratio {
        let ratio = si_digits(ratio, "", 2).0;
        rows.push((
            "turns not fitted on".to_owned(),
            format!("with it the RMS is {ratio} of that without it"),
        ));
    }
    rows
}

/// The parameters that say how large it is, in a line: no phases and no places in it.
#[must_use]
pub fn size(finding: &Finding) -> String {
    const MOST: usize = 3;
    const NO_SIZE: [&str; 5] = ["phase_rad", "at_s", "from_s", "until_s", "phase_s"];
    let place = |name: &str| {
        let local = finding.mechanism == Mechanism::LocalDefect;
        NO_SIZE.contains(&name) || (local && name == "angle_rad")
    };
    let sizes = finding.parameters.iter().filter(|(name, _)| !place(name));
    let text = |(name, parameter): (&String, &Parameter)| {
        let name = parameter_name(name, &parameter.unit);
        format!("{name} {}", with_interval(parameter))
    };
    sizes.take(MOST).map(text).collect::<Vec<_>>().join("; ")
}

/// With a capital first letter.
#[must_use]
pub fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}

/// A recording to make, and what a simulation says that it would decide.
#[must_use]
pub fn next(next: &NextRecording) -> String {
    sentence(next.text.trim())
}

/// The other parts of the residual, named.
#[must_use]
pub const fn bands(fit: &Fit) -> [(&'static str, &Band); 2] {
    [
        ("slower than two turns", &fit.slow),
        ("from edge to edge", &fit.edge_to_edge),
    ]
}

/// Whether the findings change it.
#[must_use]
pub fn changes(band: &Band) -> bool {
    const PART: f64 = 0.02;
    let both = band.rms_before_rad.zip(band.rms_after_rad);
    both.is_some_and(|(before, after)| (before - after).abs() > PART * before)
}

/// Share of what could be removed that was, in percent.
#[must_use]
pub fn removed(diagnosis: &Diagnosis) -> Option<f64> {
    let share = diagnosis.fit.held_out.reducible_removed?;
    share.is_finite().then_some(100.0 * share)
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
            ("stribeck_rad_s", "rad/s", "stribeck"),
            ("fraction_per_s", "1/s", "fraction"),
            ("order", "1", "order"),
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

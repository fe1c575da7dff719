//! A diagnosis in words, the same in the report and on the terminal.

mod numbers;

use crate::diagnose::diagnosis::{Diagnosis, Evidence, Finding, NextRecording, Parameter, Verdict};
use crate::mechanism::Mechanism;
use crate::report::si_digits;
pub use numbers::{in_order, parameter_name, probability, value, with_interval};

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
        Verdict::Complete => "nothing was found that the twin lacks",
        Verdict::Explained => "everything that was found has a name",
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
        delta if delta < 1e6 => {
            format!("{delta:.0} worse by the criterion (BIC), where 10 is strong")
        }
        delta => format!(
            "{} worse by the criterion (BIC), where 10 is strong",
            si_digits(delta, "", 2).0
        ),
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
        NO_SIZE.contains(&name) || name.starts_with("order_") || (local && name == "angle_rad")
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

/// Whether something was found that a twin can have: else there is no residual after it.
#[must_use]
pub fn mended(diagnosis: &Diagnosis) -> bool {
    let mut found = diagnosis.findings.iter();
    found.any(|finding| finding.mechanism != Mechanism::Unknown)
}

/// Share of what the findings make on turns not fitted on that they foretell, in percent.
#[must_use]
pub fn removed(diagnosis: &Diagnosis) -> Option<f64> {
    let share = diagnosis.fit.held_out.reducible_removed?;
    share.is_finite().then_some(100.0 * share)
}

//! The verdict, what it says of the rest, and the order in which findings are told.

use super::diagnosis::{Finding, Fit, Verdict};
use crate::mechanism::Mechanism;

/// Probability that noise alone leaves as much, under which what is left is not called noise.
pub const NO_NOISE: f64 = 0.01;
/// Confidence that is as good as certain: from there on the evidence orders findings, not the last digits.
const CERTAIN: f64 = 0.9995;

/// What is left beside the findings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rest {
    /// Noise.
    Noise,
    /// More than noise, which leaves as much with this probability.
    More(f64),
    /// The residual does not show what was found, and so nothing of the rest either.
    Hidden,
}

impl Rest {
    /// The rest of a fit; `found` is whether there are findings.
    #[must_use]
    pub fn of(fit: &Fit, found: bool) -> Self {
        // What changes nothing there is not in it: a resonance or another course is told from the whole of a recording.
        let same = |before: Option<f64>, after: Option<f64>| before == after;
        let hidden = same(fit.rms_before_rad, fit.rms_after_rad)
            && same(
                fit.edge_to_edge.rms_before_rad,
                fit.edge_to_edge.rms_after_rad,
            );
        match fit.whiteness_p {
            Some(p) if p >= NO_NOISE => Self::Noise,
            Some(p) if !(found && hidden) => Self::More(p),
            _ => Self::Hidden,
        }
    }
}

/// The verdict on findings.
#[must_use]
pub fn verdict(findings: &[Finding]) -> Verdict {
    let strongest = findings
        .iter()
        .max_by(|a, b| a.evidence.delta_bic.total_cmp(&b.evidence.delta_bic));
    let nameless = |finding: &Finding| finding.mechanism == Mechanism::Unknown;
    match strongest {
        None => Verdict::Complete,
        Some(strongest) if nameless(strongest) => Verdict::Unknown,
        _ if findings.iter().any(nameless) => Verdict::Partly,
        _ if findings.iter().any(Finding::is_open) => Verdict::Ambiguous,
        _ => Verdict::Explained,
    }
}

/// Puts the surest first. Of those that are certain the one with the strongest evidence comes first; what has no name comes first where
/// it is most of what was found, else last.
pub fn order(findings: &mut [Finding], verdict: Verdict) {
    let rank = |finding: &Finding| {
        let nameless = finding.mechanism == Mechanism::Unknown;
        let first = nameless == (verdict == Verdict::Unknown);
        (!first, finding.confidence.min(CERTAIN))
    };
    findings.sort_by(|a, b| {
        let ((a_later, a_sure), (b_later, b_sure)) = (rank(a), rank(b));
        a_later
            .cmp(&b_later)
            .then(b_sure.total_cmp(&a_sure))
            .then(b.evidence.delta_bic.total_cmp(&a.evidence.delta_bic))
    });
}

/// The verdict in a sentence or two, on so many recordings.
#[must_use]
pub fn summary(verdict: Verdict, findings: &[Finding], fit: &Fit, recordings: usize) -> String {
    let rest = Rest::of(fit, !findings.is_empty());
    let names = names(findings);
    let (these, allow, lack) = match recordings {
        1 => ("the recording", "this recording allows", "lacks"),
        _ => ("the recordings", "these recordings allow", "lack"),
    };
    match (verdict, rest) {
        (Verdict::Complete, Rest::Noise | Rest::Hidden) => {
            format!("The twin explains {these}: what is left is noise.")
        }
        (Verdict::Complete, Rest::More(p)) => format!(
            "Nothing stands out that the twin lacks, but {}.",
            more_than_noise(p)
        ),
        (Verdict::Explained, Rest::Noise) if findings.iter().all(Finding::takes_away) => {
            format!(
                "The twin has what {these} {lack}: {names}. Without that, what is left is noise."
            )
        }
        (Verdict::Explained, Rest::Noise) => {
            format!("The twin lacked: {names}. With that, what is left is noise.")
        }
        (Verdict::Explained, Rest::More(p)) => format!(
            "The twin lacked: {names}. With that nothing more stands out, but {}.",
            more_than_noise(p)
        ),
        (Verdict::Explained, Rest::Hidden) => format!("The twin lacked: {names}."),
        (Verdict::Partly, _) => {
            format!("The twin lacked: {names}; something without a name is left.")
        }
        (Verdict::Ambiguous, _) => format!("The twin lacked: {names}; {allow} other names for it."),
        (Verdict::Unknown, _) => {
            "Something is there that none of the known mechanisms makes.".to_owned()
        }
    }
}

/// That more than noise is left.
#[must_use]
pub fn more_than_noise(p: f64) -> String {
    let chance = match p {
        p if p < 1e-15 => "under 1e-15".to_owned(),
        p => format!("{p:.0e}"),
    };
    format!("what is left is more than noise makes (probability {chance})")
}

/// What has a name, each once.
#[must_use]
pub fn names(findings: &[Finding]) -> String {
    let mut all: Vec<(Mechanism, usize)> = Vec::new();
    for finding in findings {
        let known = all.iter_mut().find(|(one, _)| *one == finding.mechanism);
        match known {
            _ if finding.mechanism == Mechanism::Unknown => {}
            Some((_, count)) => *count += 1,
            None => all.push((finding.mechanism, 1)),
        }
    }
    let each = all.into_iter().map(|(mechanism, count)| {
        let title = mechanism.title().to_lowercase();
        match count {
            1 => title,
            count => format!("{title} ({count} of them)"),
        }
    });
    each.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests;

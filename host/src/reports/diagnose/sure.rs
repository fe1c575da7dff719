//! How sure a finding is, never more than its evidence carries.

use crate::diagnose::diagnosis::{Evidence, Finding, Parameter};
use crate::report::si_digits;
use crate::reports::diagnose::words::probability;

/// Difference of Schwarz's criterion from which on evidence is strong (R. Kass and A. Raftery, JASA 90, 1995).
pub const STRONG: f64 = 10.0;
/// Confidence from which on it is as good as certain.
const CERTAIN: f64 = 0.999;
/// Probability of noise above which evidence is not strong.
const NOISE: f64 = 1e-3;
/// Half of an interval, rad, from which on a phase or place says nothing.
const VAGUE_RAD: f64 = 1.0;

/// How many times as much as in white noise lines beside one explain that it is hard to tell from.
const CROWDED: f64 = 2.0;
/// Part of the RMS on turns not fitted on to which it hardly falls.
const HARDLY: f64 = 0.99;

/// The confidence that the evidence carries: that of the finding, or less where a criterion of its own says less.
#[must_use]
pub fn carried(finding: &Finding) -> f64 {
    let odds = |delta_bic: f64| 1.0 / (1.0 + (-0.5 * delta_bic).exp());
    let evidence = &finding.evidence;
    let mut least = finding
        .confidence
        .min(odds(evidence.delta_bic))
        .min(1.0 - evidence.p_value);
    if let Some(next) = &evidence.runner_up {
        least = least.min(odds(next.delta_bic));
    }
    match finding.confidence.is_finite() {
        true => least.clamp(0.0, 1.0),
        false => 0.0,
    }
}

/// Whether everything that speaks for a finding is strong.
#[must_use]
pub fn strong(evidence: &Evidence) -> bool {
    let next = evidence.runner_up.as_ref();
    evidence.delta_bic >= STRONG
        && evidence.p_value < NOISE
        && next.is_none_or(|next| next.delta_bic >= STRONG)
        && evidence.held_out_rms_ratio.is_none_or(|ratio| ratio < 1.0)
}

/// The confidence in percent, rounded down.
#[must_use]
pub fn confidence(finding: &Finding) -> String {
    if !finding.confidence.is_finite() {
        return "not known".to_owned();
    }
    match carried(finding) {
        sure if sure >= CERTAIN && strong(&finding.evidence) => "over 99.9 %".to_owned(),
        sure if sure >= CERTAIN => "at most 99.9 %".to_owned(),
        sure => {
            let tenths = (1000.0 * sure + 1e-9).floor() / 10.0;
            format!("{tenths:.1} %").replace(".0 %", " %")
        }
    }
}

/// The confidence and what it rests on.
#[must_use]
pub fn sure(finding: &Finding) -> String {
    let evidence = &finding.evidence;
    let rests = match &evidence.runner_up {
        Some(next) if next.delta_bic < 0.0 => format!(
            "{} fits better, by {} of Schwarz's criterion",
            next.mechanism.title(),
            points(-next.delta_bic)
        ),
        Some(next) if next.delta_bic < STRONG => format!(
            "{} fits nearly as well, {} of Schwarz's criterion behind, which decides nothing",
            next.mechanism.title(),
            points(next.delta_bic)
        ),
        Some(next) => format!(
            "the next best, {}, is {} worse by Schwarz's criterion, where 10 is strong",
            next.mechanism.title(),
            points(next.delta_bic)
        ),
        None if evidence.delta_bic < STRONG => format!(
            "without it Schwarz's criterion is {} worse, which decides nothing",
            points(evidence.delta_bic)
        ),
        None => format!(
            "without it Schwarz's criterion is {} worse, where 10 is strong",
            points(evidence.delta_bic)
        ),
    };
    let mut text = format!("{}: {rests}.", confidence(finding));
    if let Some(ratio) = evidence.held_out_rms_ratio {
        let ratio_text = si_digits(ratio, "", 2).0;
        text += &match ratio {
            ..HARDLY => {
                format!(" On turns not fitted on the RMS falls to {ratio_text} of that without it.")
            }
            HARDLY..1.0 => " On turns not fitted on the RMS falls by less than 1 %.".to_owned(),
            _ => format!(
                " On turns not fitted on it foretells nothing: the RMS is {ratio_text} of that without it."
            ),
        };
    }
    if let Some(times) = evidence.lines_beside.filter(|times| *times >= CROWDED) {
        let times = si_digits(times, "", 2).0;
        text += &format!(" Lines beside it explain {times} times as much as in white noise.");
    }
    if evidence.p_value >= NOISE {
        text += &format!(
            " Noise alone shows as much with probability {}.",
            probability(evidence.p_value)
        );
    }
    text
}

/// A difference of the criterion, short.
fn points(delta: f64) -> String {
    match delta.abs() {
        size if !size.is_finite() => "an unknown amount".to_owned(),
        size if size < STRONG => format!("{delta:.1}").replace('-', "\u{2212}"),
        size if size < 1e5 => format!("{delta:.0}").replace('-', "\u{2212}"),
        _ => si_digits(delta, "", 2).0,
    }
}

/// Whether the recordings determine a parameter: none where it is exact.
#[must_use]
pub fn determined(name: &str, parameter: &Parameter) -> Option<bool> {
    let [low, high] = parameter.ci95?;
    let half = 0.5 * (high - low);
    let bare = name.rsplit('.').next().unwrap_or(name);
    Some(match bare {
        "at_s" | "from_s" | "until_s" => half.is_finite(),
        "phase_rad" | "phase_s" => half < VAGUE_RAD,
        _ => half.is_finite() && (low > 0.0 || high < 0.0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::diagnosis::RunnerUp;
    use crate::mechanism::Mechanism;
    use crate::reports::diagnose::example::ripple;

    fn finding(confidence: f64, delta_bic: f64, next: Option<f64>) -> Finding {
        let mut finding = ripple();
        finding.confidence = confidence;
        finding.evidence = Evidence {
            delta_bic,
            p_value: 0.0,
            held_out_rms_ratio: Some(0.4),
            lines_beside: None,
            runner_up: next.map(|delta_bic| RunnerUp {
                mechanism: Mechanism::GearMesh,
                delta_bic,
            }),
        };
        finding
    }

    #[test]
    fn confidence_is_rounded_down_and_capped_by_the_evidence() {
        for (given, delta_bic, next, said) in [
            (1.0, 2000.0, None, "over 99.9 %"),
            (0.999, 2000.0, Some(60.0), "over 99.9 %"),
            (0.99899, 2000.0, None, "99.8 %"),
            (0.71, 2000.0, None, "71 %"),
            (0.029, 2000.0, None, "2.9 %"),
            // 1 / (1 + exp(-0.9)) of a runner-up 1.8 behind.
            (1.0, 2000.0, Some(1.8), "71 %"),
            (1.0, 2.0, None, "73.1 %"),
            (1.0, 2000.0, Some(-4.0), "11.9 %"),
            (f64::NAN, 2000.0, None, "not known"),
        ] {
            let finding = finding(given, delta_bic, next);
            assert_eq!(confidence(&finding), said, "{given} {delta_bic} {next:?}");
        }
    }

    #[test]
    fn what_foretells_nothing_is_never_over_999_in_1000() {
        let mut one = finding(1.0, 2000.0, Some(60.0));
        one.evidence.held_out_rms_ratio = Some(1.02);
        assert_eq!(confidence(&one), "at most 99.9 %");
        assert!(sure(&one).contains("foretells nothing"), "{}", sure(&one));
    }

    #[test]
    fn the_confidence_says_what_it_rests_on() {
        for (next, part) in [
            (
                None,
                "without it Schwarz's criterion is 2210 worse, where 10 is strong",
            ),
            (
                Some(1.8),
                "fits nearly as well, 1.8 of Schwarz's criterion behind",
            ),
            (Some(-4.0), "fits better, by 4.0 of Schwarz's criterion"),
            (
                Some(61.0),
                "is 61 worse by Schwarz's criterion, where 10 is strong",
            ),
        ] {
            let text = sure(&finding(1.0, 2210.4, next));
            assert!(text.contains(part), "{text}");
        }
    }

    #[test]
    fn an_interval_over_zero_determines_no_size_but_may_be_a_phase() {
        let of = |value: f64, half: f64| Parameter {
            value,
            unit: "rad".to_owned(),
            ci95: Some([value - half, value + half]),
        };
        assert_eq!(determined("amplitude_rad", &of(2.0, 1.0)), Some(true));
        assert_eq!(determined("amplitude_rad", &of(1.0, 2.0)), Some(false));
        assert_eq!(determined("phase_rad", &of(0.1, 0.2)), Some(true));
        assert_eq!(determined("phase_rad", &of(0.1, 2.0)), Some(false));
        let exact = Parameter {
            ci95: None,
            ..of(1.0, 0.0)
        };
        assert_eq!(determined("count", &exact), None);
    }
}

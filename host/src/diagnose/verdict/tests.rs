//! One threshold decides what is called noise, and the surest finding comes first.

use super::*;
use crate::diagnose::beside::plain;
use crate::diagnose::diagnosis::NextRecording;

fn finding(mechanism: Mechanism, confidence: f64, delta_bic: f64) -> Finding {
    Finding {
        confidence,
        ..plain(mechanism, String::new(), delta_bic)
    }
}

/// A fit with a residual that changes with the probability that it is noise.
fn fit(before: f64, after: f64) -> Fit {
    Fit {
        whiteness_p_before: Some(before),
        whiteness_p: Some(after),
        rms_before_rad: Some(before.hypot(1.0)),
        rms_after_rad: Some(after.hypot(1.0)),
        ..Fit::default()
    }
}

fn ordered(mut findings: Vec<Finding>) -> Vec<(Mechanism, f64)> {
    let verdict = verdict(&findings);
    order(&mut findings, verdict);
    let each = findings.iter();
    each.map(|f| (f.mechanism, f.confidence)).collect()
}

#[test]
fn the_surest_finding_comes_first() {
    use Mechanism::{Eccentricity, EdgeDelay, GearMesh, Unknown, WidthError};
    assert_eq!(
        ordered(vec![
            finding(WidthError, 0.49988, 900.0),
            finding(EdgeDelay, 0.50002, 800.0),
            finding(Eccentricity, 0.9999, 20.0),
            finding(GearMesh, 0.9998, 5000.0),
        ]),
        [
            // Both are certain: the evidence decides.
            (GearMesh, 0.9998),
            (Eccentricity, 0.9999),
            (EdgeDelay, 0.50002),
            (WidthError, 0.49988),
        ]
    );
    // What has no name is told first where it is the most of it, and then the verdict says so.
    let partly = vec![finding(Unknown, 1.0, 50.0), finding(EdgeDelay, 0.6, 80.0)];
    assert_eq!(verdict(&partly), Verdict::Partly);
    assert_eq!(ordered(partly), [(EdgeDelay, 0.6), (Unknown, 1.0)]);
    let unknown = vec![finding(EdgeDelay, 1.0, 50.0), finding(Unknown, 1.0, 80.0)];
    assert_eq!(verdict(&unknown), Verdict::Unknown);
    assert_eq!(ordered(unknown), [(Unknown, 1.0), (EdgeDelay, 1.0)]);
}

#[test]
fn what_no_noise_makes_is_not_called_noise() {
    let found = [finding(Mechanism::DiscTilt, 1.0, 100.0)];
    let said = |p: f64| summary(Verdict::Explained, &found, &fit(0.9, p), 1);
    assert!(said(0.01).ends_with("what is left is noise."));
    let more = said(0.0012);
    assert!(
        more.contains("more than noise makes (probability 1e-3)"),
        "{more}"
    );
    assert!(!said(0.00999).contains("is noise"));
    let nothing = |p: f64| summary(Verdict::Complete, &[], &fit(p, p), 2);
    assert_eq!(
        nothing(0.5),
        "The twin explains the recordings: what is left is noise."
    );
    assert!(!nothing(0.005).contains("is noise"), "{}", nothing(0.005));
    // A residual that the finding changes nothing of says nothing of the rest.
    let hidden = summary(Verdict::Explained, &found, &fit(1e-9, 1e-9), 1);
    assert!(!hidden.contains("noise"), "{hidden}");
}

#[test]
fn each_name_is_said_once() {
    use Mechanism::{TorqueRipple, TorqueTone};
    let each = [TorqueRipple, TorqueTone, TorqueRipple, TorqueRipple];
    let findings = each.map(|one| finding(one, 1.0, 100.0));
    let said = summary(Verdict::Ambiguous, &findings, &fit(0.0, 1.0), 1);
    assert_eq!(said.matches("torque ripple").count(), 1, "{said}");
    assert!(said.contains("(3 of them)"), "{said}");
    assert!(said.contains("this recording allows other names"), "{said}");
    let mut next = findings.to_vec();
    next[0].look_alikes = vec![TorqueTone];
    next[0].next_recording = Some(NextRecording {
        text: String::new(),
        expected_delta_bic: None,
        expected: Vec::new(),
    });
    assert_eq!(verdict(&next), Verdict::Ambiguous);
}

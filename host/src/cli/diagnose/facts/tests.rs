use super::*;
use crate::reports::diagnose::example::{complete, full};

#[test]
fn a_finding_is_printed_with_its_size_its_evidence_and_what_to_do_next() {
    let text = facts(&full().diagnosis).to_string();
    let lines: Vec<String> = text
        .lines()
        .map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "))
        .collect();
    for line in [
        "Verdict ambiguous: these recordings allow more than one mechanism",
        "Finding 1 disc off its centre (eccentricity), confidence 71 %",
        "amplitude_rad 498.1 ± 2.3 µrad",
        "evidence without it: 2210 worse by the criterion (BIC), where 10 is strong",
        "turns not fitted on: with it the RMS is 0.38 of that without it",
        "looks the same torque ripple of the motor (torque_ripple)",
        "rise_less_fall_s 1.339 ± 0.041 µs",
        "Residual, RMS 372 µrad before, 12.3 µrad after, noise alone 11.9 µrad",
        "from edge to edge 4.10 µrad before, 3.20 µrad after, noise alone 3.20 µrad",
        "Record next 44 s at 30 r/min would tell eccentricity from torque_ripple: Schwarz's criterion would differ by about 180",
        "is noise, probability under 1e-15 before, 0.31 after",
    ] {
        assert!(lines.iter().any(|found| found == line), "{line}:\n{text}");
    }
    // What the findings do not change is not told.
    assert!(!text.contains("slower than two turns"), "{text}");
}

#[test]
fn nothing_missing_is_said_in_few_lines() {
    let text = facts(&complete().diagnosis).to_string();
    assert!(
        text.contains("complete: nothing was found that the twin lacks"),
        "{text}"
    );
    assert!(
        !text.contains("Finding") && !text.contains(" after"),
        "{text}"
    );
    assert_eq!(text.lines().count(), 6, "{text}");
}

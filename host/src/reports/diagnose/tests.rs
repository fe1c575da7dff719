use std::collections::BTreeSet;

use serde_json::Value;

use super::*;
use crate::mechanism::Mechanism;
use crate::reports::diagnose::example::{complete, full};

const DOC: &str = include_str!("../../../../docs/diagnose-json.md");

fn page(diagnosed: &Diagnosed) -> String {
    let footer = Footer {
        version: "quadcal 1".to_owned(),
        command: "quadcal diagnose".to_owned(),
        inputs: Vec::new(),
    };
    report(diagnosed, footer).render()
}

#[test]
fn the_page_says_what_where_how_large_and_what_to_record_next() {
    let page = page(&full());
    roxmltree::Document::parse(&page.replace("<!DOCTYPE html>", "")).unwrap();
    for part in [
        "these recordings can't tell",
        "1. Disc off its centre",
        "largest at 121.3 degrees",
        "498.1 ± 2.3",
        "Evidence: 71 % that it is disc off its centre (eccentricity)",
        "With the next best instead, torque ripple of the motor (torque_ripple)",
        "1.8 worse by the criterion (BIC), which decides nothing",
        "The recording named at the top would tell.",
        "would tell eccentricity from torque_ripple",
        "2. Rise and fall delayed unequally",
        "1.339 ± 0.041 µs",
        "seen at more than one speed, and its angle goes with its power of 1.",
        "What is left of fast.csv",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(!page.contains("NaN"));
    // A figure each of two findings, four bars, and two of each of two recordings, every one for wide and narrow pages.
    assert_eq!(page.matches("<figure>").count(), 10);
}

#[test]
fn a_complete_twin_has_neither_findings_nor_a_recording_to_make() {
    let page = page(&complete());
    assert!(page.contains("Nothing was found that the twin lacks."));
    assert!(!page.contains("Record next") && !page.contains("Residual after"));
}

#[test]
fn what_has_no_name_is_in_no_twin_and_leaves_nothing_after() {
    let mut diagnosed = full();
    let diagnosis = &mut diagnosed.diagnosis;
    diagnosis.verdict = Verdict::Unknown;
    diagnosis.findings.truncate(1);
    diagnosis.findings[0].mechanism = Mechanism::Unknown;
    let page = page(&diagnosed);
    assert!(!page.contains("Residual after") && !page.contains("with the findings"));
}

#[test]
fn what_is_no_noise_is_not_headed_as_well_explained() {
    let mut diagnosed = full();
    let diagnosis = &mut diagnosed.diagnosis;
    diagnosis.verdict = Verdict::Explained;
    for (p, expected) in [(0.01, Level::Good), (0.0012, Level::Warn)] {
        diagnosis.fit.whiteness_p = Some(p);
        assert_eq!(level(diagnosis), expected, "{p}");
    }
}

#[test]
fn an_engine_without_curves_still_gets_a_page() {
    let mut bare = full();
    bare.shown = crate::diagnose::shown::Shown::default();
    let page = page(&bare);
    assert!(page.contains("1. Disc off its centre") && page.contains("Noise"));
    assert_eq!(page.matches("<figure>").count(), 4);
}

/// Every path to a value, as the documentation writes it.
fn paths(value: &Value, path: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(fields) => {
            for (name, value) in fields {
                let name = match path.ends_with(".parameters") {
                    true => "NAME",
                    false => name.as_str(),
                };
                let separator = if path.is_empty() { "" } else { "." };
                paths(value, &format!("{path}{separator}{name}"), found);
            }
        }
        Value::Array(items) if items.iter().any(Value::is_object) => {
            for item in items {
                paths(item, &format!("{path}[]"), found);
            }
        }
        Value::Null => {}
        _ => {
            found.insert(path.to_owned());
        }
    }
}

/// What stands in backticks in the first column of the tables under a heading.
fn documented(heading: &str) -> BTreeSet<String> {
    let (_, rest) = DOC.split_once(heading).unwrap();
    let section = rest.split("\n## ").next().unwrap_or_default();
    let rows = section.lines().filter_map(|row| row.strip_prefix("| `"));
    rows.filter_map(|row| Some(row.split_once('`')?.0.to_owned()))
        .collect()
}

#[test]
fn the_documentation_names_every_field_and_no_other() {
    let value = serde_json::to_value(full().diagnosis).unwrap();
    let mut found = BTreeSet::new();
    paths(&value, "", &mut found);
    assert_eq!(documented("## Fields"), found);
}

#[test]
fn the_documentation_names_every_verdict_and_mechanism() {
    let verdicts = [
        Verdict::Complete,
        Verdict::Explained,
        Verdict::Partly,
        Verdict::Ambiguous,
        Verdict::Unknown,
    ];
    let ids = verdicts.map(|verdict| words::verdict_id(verdict).to_owned());
    assert_eq!(documented("## Verdicts"), BTreeSet::from(ids));
    for verdict in verdicts {
        let json = serde_json::to_value(verdict).unwrap();
        assert_eq!(json, words::verdict_id(verdict));
    }
    let mechanisms = Mechanism::ALL.map(|mechanism| mechanism.id().to_owned());
    assert_eq!(
        documented("## Parameters of each mechanism"),
        BTreeSet::from(mechanisms)
    );
}

/// A row of the table of parameters, as the documentation writes it.
fn row(mechanism: Mechanism) -> String {
    let card = mechanism.card();
    let numbers = card
        .parameters
        .iter()
        .map(|one| format!("`{}` ({}): {}", one.name, one.unit, one.what));
    let numbers = numbers.collect::<Vec<_>>().join("; ");
    let twin = if card.twin.is_empty() {
        String::new()
    } else {
        format!(" `{}`", card.twin)
    };
    format!("| `{mechanism}` | {numbers} |{twin} |")
}

#[test]
fn the_documentation_has_the_parameters_of_each_mechanism() {
    let missing: Vec<String> = Mechanism::ALL
        .into_iter()
        .map(row)
        .filter(|row| !DOC.lines().any(|line| line == row))
        .collect();
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}

#[test]
fn the_json_reads_back_the_same() {
    let diagnosis = full().diagnosis;
    let text = serde_json::to_string(&diagnosis).unwrap();
    let mut read: Diagnosis = serde_json::from_str(&text).unwrap();
    for (read, written) in read.findings.iter_mut().zip(&diagnosis.findings) {
        for (name, parameter) in &mut read.parameters {
            let written = &written.parameters[name];
            // The reader may be off by the last bit.
            let [low, high] = parameter.ci95.unwrap();
            let [wanted, _] = written.ci95.unwrap();
            assert!((low / wanted - 1.0).abs() < 1e-15 && high > parameter.value);
            *parameter = written.clone();
        }
    }
    for (read, written) in read.recordings.iter_mut().zip(&diagnosis.recordings) {
        assert!((read.seconds / written.seconds - 1.0).abs() < 1e-15);
        *read = written.clone();
    }
    assert_eq!(read, diagnosis);
}

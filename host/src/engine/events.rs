//! What happened once: edges lost, pulses that no edge made, an index that moved.

use std::collections::BTreeMap;

use crate::diagnose::diagnosis::{Evidence, Finding, Parameter, Place};
use crate::diagnose::events::Event;
use crate::mechanism::Mechanism;

/// Findings of the events that the twins do not declare, one a kind; an index slip each.
#[must_use]
pub fn findings(events: &[Event]) -> Vec<Finding> {
    let mut all = Vec::new();
    for mechanism in [Mechanism::LostEdges, Mechanism::ExtraEdges] {
        let those: Vec<&Event> = events
            .iter()
            .filter(|event| event.mechanism == mechanism)
            .collect();
        if those.is_empty() {
            continue;
        }
        let exact = |value: f64| Parameter {
            value,
            unit: "1".to_owned(),
            ci95: None,
        };
        let parameters = BTreeMap::from([("count".to_owned(), exact(those.len() as f64))]);
        let mut channels: Vec<usize> = those.iter().filter_map(|event| event.channel).collect();
        channels.sort_unstable();
        channels.dedup();
        let word = if mechanism == Mechanism::LostEdges {
            "edges are missing"
        } else {
            "pulses came that no edge made"
        };
        let place = Place {
            times_s: those.iter().map(|event| event.time_s).collect(),
            channels: channels
                .iter()
                .map(|channel| ["A", "B", "C"][*channel.min(&2)].to_owned())
                .collect(),
            ..Place::default()
        };
        all.push(finding(
            mechanism,
            parameters,
            place,
            format!("{word} at {} instants", those.len()),
        ));
    }
    for event in events
        .iter()
        .filter(|event| event.mechanism == Mechanism::IndexSlip)
    {
        let parameters = BTreeMap::from([
            (
                "at_s".to_owned(),
                Parameter {
                    value: event.time_s,
                    unit: "s".to_owned(),
                    ci95: Some(event.between_s),
                },
            ),
            (
                "edges".to_owned(),
                Parameter {
                    value: f64::from(event.edges),
                    unit: "1".to_owned(),
                    ci95: None,
                },
            ),
        ]);
        let place = Place {
            times_s: vec![event.time_s],
            ..Place::default()
        };
        let text = format!(
            "the index is {} edges further from {:.4} s on",
            event.edges, event.time_s
        );
        all.push(finding(Mechanism::IndexSlip, parameters, place, text));
    }
    all
}

/// A finding that is counted, not fitted.
fn finding(
    mechanism: Mechanism,
    parameters: BTreeMap<String, Parameter>,
    place: Place,
    text: String,
) -> Finding {
    Finding {
        mechanism,
        text,
        confidence: 0.999,
        parameters,
        place,
        evidence: Evidence {
            delta_bic: 1e3,
            p_value: 0.0,
            held_out_rms_ratio: None,
            runner_up: None,
        },
        look_alikes: Vec::new(),
        next_recording: None,
    }
}

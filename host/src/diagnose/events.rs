//! What happened once: edges lost, pulses that no edge made, an index that moved.

use std::collections::BTreeMap;

use quadcal::edge::Levels;

use super::edges::{CountEvent, CountKind};
use super::noise::FAR;
use super::rig::Recorded;
use crate::diagnose::diagnosis::{Finding, Parameter, Place};
use crate::mechanism::Mechanism;
use crate::twin::IndexSlip;

/// Rows of a glitch: its start and its end.
pub const ROWS_A_GLITCH: i32 = 2;

/// Findings of the events that the twins do not declare, one a kind; an index slip each.
pub fn findings(rig: &[Recorded]) -> Vec<Finding> {
    let events: Vec<CountEvent> = rig.iter().flat_map(undeclared).collect();
    let of = |kind: CountKind| events.iter().filter(move |event| event.kind == kind);
    let mut all = Vec::new();
    let missing = (CountKind::Lost, Mechanism::LostEdges, "edges are missing");
    let added = "pulses came that no edge made";
    let added = (CountKind::Extra, Mechanism::ExtraEdges, added);
    for (kind, mechanism, word) in [missing, added] {
        let instants = of(kind).count();
        if instants == 0 {
            continue;
        }
        let count: i32 = of(kind).map(|event| event.edges).sum();
        let parameters = BTreeMap::from([("count".to_owned(), Parameter::exact(f64::from(count)))]);
        let mut channels: Vec<String> = of(kind).map(|event| letter(event.channel)).collect();
        channels.sort_unstable();
        channels.dedup();
        let place = Place {
            times_s: of(kind).map(|event| event.time_s).collect(),
            channels,
            ..Place::default()
        };
        let text = format!("{word}: {count}, at {instants} instants");
        all.push(finding(mechanism, parameters, place, text));
    }
    for event in of(CountKind::IndexSlip) {
        let ends = [event.after_s, event.time_s];
        let at = Parameter::between(0.5 * (ends[0] + ends[1]), "s", ends);
        let parameters = BTreeMap::from([
            ("at_s".to_owned(), at),
            ("edges".to_owned(), Parameter::exact(f64::from(event.edges))),
        ]);
        let place = Place {
            times_s: vec![event.time_s],
            ..Place::default()
        };
        let since = match ends[0] == ends[1] {
            true => "than in the twin, all along".to_owned(),
            false => format!("from {:.4} s on", event.time_s),
        };
        let text = format!("the index is {} edges further {since}", event.edges);
        all.push(finding(Mechanism::IndexSlip, parameters, place, text));
    }
    all
}

/// Whether findings of a mechanism are counted, whatever else is left.
pub const fn counted(mechanism: Mechanism) -> bool {
    matches!(
        mechanism,
        Mechanism::LostEdges | Mechanism::ExtraEdges | Mechanism::IndexSlip
    )
}

/// What happened in a recording and its twin does not declare.
fn undeclared(one: &Recorded) -> Vec<CountEvent> {
    let declared = &one.twin.faults;
    let slips = &one.twin.index_slip;
    let mut events = one.edges.events.clone();
    events.retain(|event| {
        let declared = |slip: &IndexSlip| {
            slip.edges == event.edges && (event.after_s..=event.time_s).contains(&slip.at_s)
        };
        event.kind != CountKind::IndexSlip || !slips.iter().any(declared)
    });
    let mut events = in_order(events, one.edges.classes);
    let lost = (declared.lost_probability, declared.lost_edges.len(), 1);
    let extra = (declared.glitch_probability, 0, ROWS_A_GLITCH);
    for (kind, (probability, listed, rows)) in [(CountKind::Lost, lost), (CountKind::Extra, extra)]
    {
        let of = events.iter().filter(|event| event.kind == kind);
        let count: i32 = of.map(|event| event.edges).sum();
        let expected = probability * one.edges.len() as f64;
        let most = expected + FAR * expected.sqrt() + listed as f64;
        if expected + listed as f64 > 0.0 && f64::from(count) <= most * f64::from(rows) {
            events.retain(|event| event.kind != kind);
        }
    }
    events
}

/// Events without edges that came out of their order: one that is lost where it belongs and too many beside it was stamped far out.
fn in_order(events: Vec<CountEvent>, classes: u32) -> Vec<CountEvent> {
    let one_edge = |one: &CountEvent, other: &CountEvent| {
        one.kind != other.kind
            && one.kind != CountKind::IndexSlip
            && other.kind != CountKind::IndexSlip
            && (one.channel, one.edges) == (other.channel, other.edges)
            && one.place.abs_diff(other.place) <= u64::from(classes)
    };
    let alone = |event: &&CountEvent| !events.iter().any(|other| one_edge(event, other));
    events.iter().filter(alone).copied().collect()
}

/// The channel of a level bit.
fn letter(bit: u8) -> String {
    match bit {
        Levels::A => "A",
        Levels::B => "B",
        _ => "C",
    }
    .to_owned()
}

/// A finding that is counted, not fitted.
fn finding(
    mechanism: Mechanism,
    parameters: BTreeMap<String, Parameter>,
    place: Place,
    text: String,
) -> Finding {
    let mut finding = Finding {
        confidence: 0.999,
        parameters,
        place,
        ..Finding::of(mechanism, text, 1e3)
    };
    finding.evidence.p_value = 0.0;
    finding
}

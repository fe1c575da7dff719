//! Where a finding shows: orders, frequencies, times, places of the disc, and the edges that it is on.

use std::collections::BTreeMap;

use super::basis::{Basis, Change, change_of};
use super::conclude::Name;
use super::diagnosis::{Parameter, Place};
use super::settle::Settled;
use crate::mechanism::Shows;

const CHANNELS: [&str; 3] = ["A", "B", "C"];

/// Where a named finding shows.
#[must_use]
pub fn place(settled: &Settled, name: &Name, parameters: &BTreeMap<String, Parameter>) -> Place {
    let mut place = Place::default();
    let value = |name: &str| parameters.get(name).map(|p| p.value);
    place.orders.extend(value("order"));
    place
        .frequencies_hz
        .extend(value("f_hz").or(value("task_hz")));
    place.times_s.extend(value("from_s"));
    place.times_s.extend(value("until_s"));
    if let Basis::Round { order } = name.hypothesis.bases[0]
        && place.orders.is_empty()
    {
        place.orders.push(order);
    }
    let Some(first) = settled.given.benches.first() else {
        return place;
    };
    let names = settled.class_names();
    let hit: Vec<usize> = (0..first.seen.classes as usize)
        .filter(|class| {
            hits(
                name.hypothesis.bases[0],
                change_of(*class, first.seen.classes),
            )
        })
        .collect();
    if hit.len() < names.len() {
        place.edge_classes = hit.iter().map(|class| names[*class].to_owned()).collect();
    }
    match name.hypothesis.bases[0] {
        Basis::Bump {
            angle_rad, channel, ..
        } => {
            place.angles_deg = vec![value("angle_rad").unwrap_or(angle_rad).to_degrees()];
            place
                .channels
                .extend(channel.map(|c| CHANNELS[c].to_owned()));
        }
        Basis::LevelTone { channel, .. } => {
            place
                .channels
                .extend(channel.map(|c| CHANNELS[c].to_owned()));
        }
        Basis::Shift { channel } | Basis::Late { channel } => {
            place.channels.push(CHANNELS[channel].to_owned());
        }
        _ => {}
    }
    place
}

/// Whether a pattern is on an edge.
fn hits(basis: Basis, change: Change) -> bool {
    match basis {
        Basis::Bump { channel, rises, .. } => {
            channel.is_none_or(|c| c == change.channel) && rises.is_none_or(|r| r == change.rises)
        }
        Basis::LevelTone { channel, .. } => channel.is_none_or(|c| c == change.channel),
        Basis::Width { channel } => !change.rises && channel.is_none_or(|c| c == change.channel),
        Basis::RiseLate { channel } => change.rises && channel.is_none_or(|c| c == change.channel),
        Basis::Shift { channel } | Basis::Late { channel } => channel == change.channel,
        _ => true,
    }
}

/// The same in a sentence.
#[must_use]
pub fn text(name: &Name, place: &Place) -> String {
    let edges = if place.edge_classes.is_empty() {
        "all edges alike".to_owned()
    } else {
        place.edge_classes.join(", ")
    };
    let edges = edges.as_str();
    (name.hypothesis.mechanism.card().handling.text)(Shows { place, edges })
}

//! Where a finding shows: orders, frequencies, times, places of the disc, and the edges that it is on.

use std::collections::BTreeMap;

use super::basis::{Basis, Change, change_of};
use super::conclude::Name;
use super::diagnosis::{Parameter, Place};
use super::estimate::Estimate;
use super::moved::moved;
use super::settle::Settled;
use crate::mechanism::{Mechanism, Shows};

const CHANNELS: [&str; 3] = ["A", "B", "C"];

/// Where a named finding shows.
#[must_use]
pub fn place(
    settled: &Settled,
    name: &Name,
    estimate: &Estimate,
    parameters: &BTreeMap<String, Parameter>,
) -> Place {
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
    if let Basis::Bump { angle_rad, .. } = name.hypothesis.bases[0] {
        place.angles_deg = vec![value("angle_rad").unwrap_or(angle_rad).to_degrees()];
    }
    place.speed_exponent = speed_exponent(settled, name);
    let Some(first) = settled.given.benches.first() else {
        return place;
    };
    let (names, classes) = (settled.class_names(), first.seen.classes);
    let moved = moved(estimate);
    let on = |change: Change| moved.iter().any(|moved| moved.has(change));
    let hit: Vec<usize> = (0..names.len())
        .filter(|class| on(change_of(*class, classes)))
        .collect();
    if hit.len() < names.len() {
        place.edge_classes = hit.iter().map(|class| names[*class].to_owned()).collect();
    }
    let mut channels: Vec<usize> = hit
        .iter()
        .map(|class| change_of(*class, classes).channel)
        .collect();
    channels.sort_unstable();
    channels.dedup();
    let named = channels.into_iter().map(|channel| CHANNELS[channel]);
    place.channels = named.map(str::to_owned).collect();
    place
}

/// Speeds that are two: a look-alike of another exponent would differ by as much.
const TWO_SPEEDS: f64 = 1.25;

/// The power of the speed that its angle goes with, as far as these recordings tell it: one size fits all of their speeds, and what fits
/// as well goes with the same power.
fn speed_exponent(settled: &Settled, name: &Name) -> Option<f64> {
    let exponent = |mechanism: Mechanism| mechanism.card().speed_exponent;
    let own = exponent(name.hypothesis.mechanism)?;
    let tied = name.hypothesis.bases.iter().all(|basis| !basis.timed());
    let alike = name.alike.iter().all(|other| exponent(*other) == Some(own));
    let (least, most) = settled
        .given
        .benches
        .iter()
        .flat_map(|bench| bench.seen.speeds.iter().map(|speed| speed.abs()))
        .fold((f64::INFINITY, 0.0), |(least, most), speed| {
            (f64::min(least, speed), f64::max(most, speed))
        });
    (tied && alike && most > TWO_SPEEDS * least).then(|| f64::from(own))
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

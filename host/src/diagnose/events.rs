//! What happened in a recording once: edges lost, pulses that no edge made, an index that moved.

use super::index::Moved;
use super::mend::{Fault, FaultKind};
use super::track::Track;
use crate::mechanism::Mechanism;
use crate::twin::Twin;

/// Standard deviations of a number of events that chance seldom reaches.
const SURE: f64 = 4.0;

/// Something that happened at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// [`Mechanism::LostEdges`], [`Mechanism::ExtraEdges`] or [`Mechanism::IndexSlip`].
    pub mechanism: Mechanism,
    /// When, s: of an index slip the middle of where it may lie.
    pub time_s: f64,
    /// Where it lies for certain, s: an index slip between two passes of the index, others at their time, within an edge.
    pub between_s: [f64; 2],
    /// Edges that the index moved by, forward positive; edges missing from the recording, or changes too many in it.
    pub edges: i32,
    /// Channel of the edge, 0 to 2 for A to C; none for the index.
    pub channel: Option<usize>,
}

/// All events of a recording, by time.
#[must_use]
pub fn events(track: &Track) -> Vec<Event> {
    let faults: Vec<&Fault> = track.faults.iter().collect();
    of(track, &faults, &track.moved)
}

/// Those that its twin does not declare.
#[must_use]
pub fn undeclared(track: &Track, twin: &Twin) -> Vec<Event> {
    let declared = &twin.faults;
    let has = |number: u64| declared.lost_edges.contains(&number);
    let listed = |fault: &Fault| {
        let first = fault.number.filter(|_| fault.kind == FaultKind::Lost);
        // A recording may begin with a row that no edge made.
        let from = |first: u64| (first..first + u64::from(fault.edges)).all(has);
        first.is_some_and(|first| from(first) || first > 0 && from(first - 1))
    };
    let edges: usize = track.stretches.iter().map(|one| one.marks.len()).sum();
    let mut faults: Vec<&Fault> = track.faults.iter().filter(|one| !listed(one)).collect();
    for (kind, probability) in [
        (FaultKind::Lost, declared.lost_probability),
        (FaultKind::Extra, declared.glitch_probability),
    ] {
        let count = faults.iter().filter(|fault| fault.kind == kind).count();
        let expected = probability * edges as f64;
        if expected > 0.0 && (count as f64) < expected + SURE * expected.sqrt() + 1.0 {
            faults.retain(|fault| fault.kind != kind);
        }
    }
    let slipped = |moved: &Moved| {
        twin.index_slip.iter().any(|slip| {
            let [from_s, until_s] = moved.between_s;
            slip.edges == moved.edges && (from_s..=until_s).contains(&slip.at_s)
        })
    };
    let moved: Vec<Moved> = track
        .moved
        .iter()
        .filter(|one| !slipped(one))
        .cloned()
        .collect();
    of(track, &faults, &moved)
}

fn of(track: &Track, faults: &[&Fault], moved: &[Moved]) -> Vec<Event> {
    let faults = faults.iter().map(|fault| {
        let time_s = fault.ticks as f64 * track.tick_s;
        Event {
            mechanism: match fault.kind {
                FaultKind::Lost => Mechanism::LostEdges,
                FaultKind::Extra => Mechanism::ExtraEdges,
            },
            time_s,
            between_s: [time_s; 2],
            edges: i32::try_from(fault.edges).unwrap_or(i32::MAX),
            channel: Some(fault.channel),
        }
    });
    let moved = moved.iter().map(|moved| Event {
        mechanism: Mechanism::IndexSlip,
        time_s: 0.5 * (moved.between_s[0] + moved.between_s[1]),
        between_s: moved.between_s,
        edges: moved.edges,
        channel: None,
    });
    let mut all: Vec<Event> = faults.chain(moved).collect();
    all.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    all
}

#[cfg(test)]
mod tests;

//! What happened in a recording once: edges lost, pulses that no edge made, an index that moved.

use super::mend::FaultKind;
use super::track::Track;
use crate::mechanism::Mechanism;

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
    let faults = track.faults.iter().map(|fault| {
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
    let moved = track.moved.iter().map(|moved| Event {
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

//! Places against the truth of simulated shafts, and against what is known of real recordings.

mod real;
mod simulated;
mod wheels;

use super::*;

/// Tooth places of steps, in pitches.
fn teeth(steps: &[usize]) -> Vec<bool> {
    let places = steps
        .iter()
        .flat_map(|&step| (0..step).map(|place| place == 0));
    places.collect()
}

/// Edges lost or too many, in events of one kind, before a time.
fn events(edges: &Edges, kind: CountKind, before_s: f64) -> Vec<CountEvent> {
    let events = edges.events.iter().copied();
    events
        .filter(|event| event.kind == kind && event.time_s < before_s)
        .collect()
}

#[test]
fn sensors_without_edges_are_refused() {
    let rows = [];
    let none = Sensor::Quadrature {
        lines: 0,
        index: None,
    };
    assert_eq!(place(&none, 1, &rows), Err(PlaceError::Edges(0)));
    let toothless = Sensor::Wheel {
        present: vec![false; 4],
        both_edges: true,
    };
    assert_eq!(place(&toothless, 1, &rows), Err(PlaceError::NoTeeth));
    let huge = Sensor::Hall {
        pole_pairs: u32::MAX,
    };
    let edges = 6 * u64::from(u32::MAX);
    assert_eq!(place(&huge, 1, &rows), Err(PlaceError::Edges(edges)));
    let hall = Sensor::Hall { pole_pairs: 2 };
    assert_eq!(place(&hall, 1, &rows), Err(PlaceError::NoEdges(0)));
    assert_eq!(find_wheel(&rows, true), None);
}

//! `lost_edges`: edges that the capture missed.
//!
//! A capture that is read too late, or a signal that is too weak for a moment, leaves an edge out. Counting from edge to edge is then
//! behind by one step for good:
//! `e steps by -2 pi / N for each edge missed, N edges a turn`
//! A and B take turns, so a missing edge breaks the order of the quadrature code: `diagnose/mend.rs` finds it there, or by the interval
//! of two, puts the count right and tells it as an event. Simulated in `sim/capture.rs`.
//!
//! Source: order of a reflected binary code, one channel changing at a time (F. Gray, US patent 2632058, 1953).

use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "lost edges",
    physics: "The capture is read too late, or a signal is too weak for a moment: an edge is missing, and a count from edge to edge is \
              behind by one step for good.",
    equation: "e steps by -2 pi / N for each edge missed, N edges a turn",
    source: "order of a reflected binary code, one channel changing at a time (F. Gray, US patent 2632058, 1953)",
    twin: "faults.lost_edges",
    parameters: &[Quantity::new(
        "count",
        "1",
        [1.0, 1e9],
        "places at which edges are missing",
    )],
    locked_to: &[LockedTo::Instants],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::OftenOne,
    look_alikes: &[Mechanism::IndexSlip, Mechanism::LocalDefect],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A slower recording with an index, of some ten turns: lost edges become fewer, a slip of the index stays, a defect \
                   returns at its angle.",
};

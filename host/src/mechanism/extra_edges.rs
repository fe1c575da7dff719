//! `extra_edges`: edges that no mark made.
//!
//! A pick-up pulse crosses the comparator's level twice: two changes of one channel where none should be. Taken for edges, they put the
//! count ahead for as long as the pulse lasts, or for good where one of the two is lost:
//! `e steps by +2 pi / N for each edge too many, N edges a turn`
//! `diagnose/mend.rs` finds both by the order of the quadrature code and by intervals that are far too short, and takes them out.
//! Simulated in `sim/capture.rs`.
//!
//! Source: order of a reflected binary code, one channel changing at a time (F. Gray, US patent 2632058, 1953).

use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "extra edges",
    physics: "A pick-up pulse crosses the comparator's level: a channel changes where no mark is, and changes back. Taken for edges, they \
              put the count ahead.",
    equation: "e steps by +2 pi / N for each edge too many, N edges a turn",
    source: "order of a reflected binary code, one channel changing at a time (F. Gray, US patent 2632058, 1953)",
    twin: "faults.glitch_probability",
    parameters: &[Quantity::new(
        "count",
        "1",
        [1.0, 1e9],
        "places at which pulses were taken out",
    )],
    locked_to: &[LockedTo::Instants],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::OftenOne,
    look_alikes: &[Mechanism::LocalDefect, Mechanism::IndexSlip],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A recording with the drive's power stage off, shaft turned by another motor or by hand: pick-up goes, a defect of the \
                   disc returns at its angle.",
};

//! `index_slip`: the coupling or the index moves against the disc.
//!
//! From some instant on the index comes n steps of the grid further along, with no edge lost or added between two passes of it:
//! `index at edge k0 before, k0 + n after`
//! so everything told by the angle of the disc is turned by 2 pi n / N. `diagnose/index.rs` sees the index move between two passes.
//! Simulated in `sim/shift.rs`.
//!
//! Source: count of edges between two passes of the index, a whole number of turns' edges unless it slipped.

use super::card::INSTANT_S;
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "index slipped against the disc",
    physics: "The coupling slips, or the index moves against the disc: from some instant on the index comes some edges further along, \
              with no edge lost or added.",
    equation: "index at edge k0 before, k0 + n after",
    source: "count of edges between two passes of the index, a whole number of turns' edges unless it slipped",
    twin: "index_slip",
    parameters: &[
        Quantity::new(
            "at_s",
            "s",
            INSTANT_S,
            "when, between two passes of the index",
        ),
        Quantity::new(
            "edges",
            "1",
            [-1e7, 1e7],
            "n, steps of the grid, forward positive",
        ),
    ],
    locked_to: &[LockedTo::Instants],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[Mechanism::LostEdges, Mechanism::ExtraEdges],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A recording with an index and several changes of load: a slip moves the index for good with no edge lost or added \
                   between two channels, lost edges break the order of A and B.",
};

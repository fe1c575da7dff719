//! `unknown`: none of the catalogue's mechanisms.
//!
//! Something is there that no mechanism of the table explains, or that only resembles one: not the same throughout, one of a crowd of
//! rhythms, or with numbers that no rig has. The finding says where it lives and how much of it there is. It has no equation, so no
//! section of a twin: `none` stands for it.
//!
//! Source: none.

use super::{Card, EdgeClasses, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "none of the known mechanisms",
    physics: "Something is there that no mechanism of the catalogue explains, or that only resembles one: not the same throughout, one of \
              a crowd of rhythms, or with numbers that no rig has.",
    equation: "none",
    source: "none",
    twin: "",
    parameters: &[
        Quantity::new(
            "repeats_each_turn",
            "1",
            [0.0, 1.0],
            "share of its squares above noise that one half of the turns foretells in the other, edge by edge",
        ),
        Quantity::new(
            "share",
            "1",
            [0.0, 1.0],
            "share of the time, where noise comes in bursts, or of the edges, where few are far off",
        ),
        Quantity::new(
            "times_as_wide",
            "1",
            [1.0, 1e6],
            "how much wider edges spread in bursts, or those few",
        ),
    ],
    locked_to: &[],
    speed_exponent: None,
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "Recordings at another speed, in the other direction, and with the load disconnected show what it keeps step with.",
};

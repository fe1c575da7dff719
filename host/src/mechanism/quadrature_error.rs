//! `quadrature_error`: a channel lies off its place against channel A.
//!
//! The photo elements, or Hall sensors, of the other channels are not exactly where they should be against those of A:
//! `e(k) = p on both edges of channel B, 0 on those of A`
//! for all lines alike and at every speed; a third channel has a p of its own. Simulated in `sim/disc.rs`.
//!
//! Source: Yin, Guo et al., Chinese Journal of Scientific Instrument, doi 10.19650/j.cnki.cjsi.J2210801, eq. (16).

use super::card::ERROR_RAD;
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Either way.
const RANGE: [f64; 2] = [-ERROR_RAD, ERROR_RAD];
/// Its numbers where there are three channels.
const OF_CHANNELS: [&str; 3] = ["shift_a_rad", "shift_b_rad", "shift_c_rad"];

/// Its card.
pub const CARD: Card = Card {
    title: "quadrature error",
    physics: "The photo elements or Hall sensors of a channel are off their place against those of A, so all its edges are shifted by \
              the same angle.",
    equation: "e(k) = p on both edges of channel B, 0 on those of A",
    source: "Yin, Guo et al., Chinese Journal of Scientific Instrument, doi 10.19650/j.cnki.cjsi.J2210801, eq. (16)",
    twin: "errors",
    parameters: &[
        Quantity::new("quadrature_rad", "rad", RANGE, "p of B against A"),
        Quantity::new(
            OF_CHANNELS[1],
            "rad",
            RANGE,
            "shift of the second Hall sensor",
        ),
        Quantity::new(
            OF_CHANNELS[2],
            "rad",
            RANGE,
            "shift of the third Hall sensor",
        ),
    ],
    locked_to: &[LockedTo::Angle],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::ChannelAgainstChannel,
    look_alikes: &[Mechanism::ChannelSkew],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "Two recordings at speeds a factor of two apart: a quadrature error keeps its size in angle, unequal delays of the \
                   channels grow with the speed.",
};

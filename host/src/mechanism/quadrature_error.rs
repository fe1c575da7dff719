//! `quadrature_error`: a channel lies off its place against channel A.
//!
//! The photo elements, or Hall sensors, of the other channels are not exactly where they should be against those of A:
//! `e(k) = p on both edges of channel B, 0 on those of A`
//! for all lines alike and at every speed; a third channel has a p of its own. Simulated in `sim/disc.rs`.
//!
//! Source: Yin, Guo et al., Chinese Journal of Scientific Instrument, doi 10.19650/j.cnki.cjsi.J2210801, eq. (16).

use super::card::ERROR_RAD;
use super::width_error::of_channels;
use super::{Card, EdgeClasses, Handling, LockedTo, Mechanism, Quantity};
use crate::diagnose::basis::Basis;
use crate::diagnose::classes::by_edge;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::named::{Named, Numbers};
use crate::diagnose::seen::Seen;
use crate::diagnose::shaft::ShaftLaw;

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
    handling: Handling {
        makes: |basis| matches!(basis, Basis::Shift { .. }),
        columns,
        proposed: |board| of_channels(board).map_or_else(Vec::new, all),
        instead_of: |found, setting| match found.bases.first() {
            Some(Basis::Late { .. }) if found.bases.len() < setting.channels => {
                all(setting.channels)
            }
            _ => Vec::new(),
        },
        values,
        text: |shows| {
            format!(
                "{} against the others, the same angle throughout",
                shows.edges
            )
        },
        mends: |mended, basis, sizes| {
            if let Basis::Shift { channel } = basis {
                mended.add_disc(|_, on, _| if channel == on { sizes[0] } else { 0.0 });
            }
        },
        ..Handling::NONE
    },
};

fn all(channels: usize) -> Vec<Hypothesis> {
    let each = (1..channels).map(|channel| Basis::Shift { channel });
    Hypothesis::by_all(each.collect()).into_iter().collect()
}

fn columns(basis: Basis, seen: &Seen, _: &ShaftLaw) -> Vec<Vec<f64>> {
    let Basis::Shift { channel } = basis else {
        return Vec::new();
    };
    by_edge(seen, |_, change| {
        f64::from(u8::from(change.channel == channel))
    })
}

fn values(numbers: &Numbers<'_>) -> Named {
    let alone = numbers.patterns() == 1;
    let each = numbers.bases().filter_map(|(at, basis)| match basis {
        Basis::Shift { .. } if alone => Some(("quadrature_rad".to_owned(), Numbers::size(at))),
        Basis::Shift { channel } => Some((OF_CHANNELS[channel].to_owned(), Numbers::size(at))),
        _ => None,
    });
    each.collect()
}

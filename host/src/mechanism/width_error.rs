//! `width_error`: the falling edges of a channel lie off its rising ones.
//!
//! Slits and bars of unequal width, or a comparator level off the middle of the signal, make high and low times unequal, for all
//! lines alike:
//! `e(k) = xi_c on falling edges of channel c, 0 on rising ones`
//! at every speed. It is linear in xi, so it is fitted as columns of 0 and 1, one for all channels or one each. Simulated in
//! `sim/disc.rs`.
//!
//! Source: Yin, Guo et al., Chinese Journal of Scientific Instrument, doi 10.19650/j.cnki.cjsi.J2210801, eq. (1).

use super::card::ERROR_RAD;
use super::{Card, EdgeClasses, Handling, LockedTo, Mechanism, Quantity};
use crate::diagnose::basis::Basis;
use crate::diagnose::board::Board;
use crate::diagnose::classes::{by_edge, channels};
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::named::{Named, Numbers};
use crate::diagnose::seen::Seen;
use crate::diagnose::shaft::ShaftLaw;

/// Either way.
const RANGE: [f64; 2] = [-ERROR_RAD, ERROR_RAD];
/// Its numbers where each channel has its own.
const OF_CHANNELS: [&str; 3] = ["width_a_rad", "width_b_rad", "width_c_rad"];

/// Its card.
pub const CARD: Card = Card {
    title: "signal width error",
    physics: "Slits and bars of unequal width, or a comparator level off the middle of the signal, put the falling edges of a channel \
              off its rising ones by the same angle at every line.",
    equation: "e(k) = xi_c on falling edges of channel c, 0 on rising ones",
    source: "Yin, Guo et al., Chinese Journal of Scientific Instrument, doi 10.19650/j.cnki.cjsi.J2210801, eq. (1)",
    twin: "errors",
    parameters: &[
        Quantity::new(
            "width_rad",
            "rad",
            RANGE,
            "xi where all channels have the same",
        ),
        Quantity::new(
            OF_CHANNELS[0],
            "rad",
            RANGE,
            "xi of A, its falling edges against its rising ones",
        ),
        Quantity::new(OF_CHANNELS[1], "rad", RANGE, "xi of B"),
        Quantity::new(OF_CHANNELS[2], "rad", RANGE, "xi of C"),
    ],
    locked_to: &[LockedTo::Angle],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::RiseAgainstFall,
    look_alikes: &[
        Mechanism::EdgeDelay,
        Mechanism::ThresholdDrift,
        Mechanism::Hysteresis,
    ],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "Two recordings at speeds a factor of two apart: a width error keeps its size in angle, unequal delays of rise and \
                   fall grow with the speed.",
    handling: Handling {
        makes: |basis| matches!(basis, Basis::Width { .. }),
        columns,
        proposed: |board| of_channels(board).map_or_else(Vec::new, proposed),
        instead_of: |found, setting| {
            let own = found.bases.len() <= setting.channels;
            match found.bases.first() {
                Some(Basis::RiseLate { .. } | Basis::FallEarly { .. }) if own => {
                    both(setting.channels)
                }
                _ => Vec::new(),
            }
        },
        values,
        text: |shows| {
            format!(
                "{} against the others, the same angle throughout",
                shows.edges
            )
        },
        mends: |mended, basis, sizes| {
            if let Basis::Width { channel } = basis {
                mended.add_disc(|_, on, rises| {
                    if !rises && channel.is_none_or(|channel| channel == on) {
                        sizes[0]
                    } else {
                        0.0
                    }
                });
            }
        },
        ..Handling::NONE
    },
};

/// Channels of a sensor that tells edges apart.
pub(super) fn of_channels(board: &Board) -> Option<usize> {
    let classes = board.benches.first()?.seen.classes;
    (classes > 1).then(|| channels(classes))
}

/// Of one channel there is only its own.
fn proposed(channels: usize) -> Vec<Hypothesis> {
    let mut all = both(channels);
    all.truncate(channels);
    all
}

/// One width for all channels, and one each.
fn both(channels: usize) -> Vec<Hypothesis> {
    let each = (0..channels).map(|c| Basis::Width { channel: Some(c) });
    let mut all = vec![Hypothesis::by(Basis::Width { channel: None })];
    all.extend(Hypothesis::by_all(each.collect()));
    all
}

fn columns(basis: Basis, seen: &Seen, _: &ShaftLaw) -> Vec<Vec<f64>> {
    let Basis::Width { channel } = basis else {
        return Vec::new();
    };
    by_edge(seen, |_, change| {
        f64::from(u8::from(!change.rises && change.on(channel)))
    })
}

fn values(numbers: &Numbers<'_>) -> Named {
    let each = numbers.bases().filter_map(|(at, basis)| match basis {
        Basis::Width { channel: None } => Some(("width_rad".to_owned(), Numbers::size(at))),
        Basis::Width { channel: Some(c) } => Some((OF_CHANNELS[c].to_owned(), Numbers::size(at))),
        _ => None,
    });
    each.collect()
}

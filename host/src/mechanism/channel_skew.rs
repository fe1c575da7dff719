//! `channel_skew`: the channels are captured with unequal delays.
//!
//! Filters, cables or comparators of the channels differ, so all edges of one come d later than those of A:
//! `e = -w d on both edges of channel B, 0 on those of A`
//! with w the signed speed. At one speed that is a quadrature error; it grows with the speed as no quadrature error does. Simulated
//! in `sim/signal.rs`.
//!
//! Source: kinematics, first order in the delay: the shaft goes on by w d until the stamp.

use super::card::DELAY_S;
use super::edge_delay::widths_and_shifts;
use super::width_error::of_channels;
use super::{Card, EdgeClasses, Handling, LockedTo, Mechanism, Quantity};
use crate::diagnose::basis::Basis;
use crate::diagnose::classes::by_edge;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::mended::Mended;
use crate::diagnose::named::{Named, Numbers};
use crate::diagnose::seen::Seen;
use crate::diagnose::shaft::ShaftLaw;

/// Either way.
const RANGE: [f64; 2] = [-DELAY_S, DELAY_S];
/// Its numbers by channel.
const OF_CHANNELS: [&str; 3] = ["a_less_a_s", "b_less_a_s", "c_less_a_s"];

/// Its card.
pub const CARD: Card = Card {
    title: "channels delayed unequally",
    physics: "Filters, cables or comparators of the channels differ, so all edges of one come later than those of A. The shaft turns \
              on meanwhile, so the shift grows with the speed.",
    equation: "e = -w d on both edges of channel B, 0 on those of A",
    source: "kinematics, first order in the delay: the shaft goes on by w d until the stamp",
    twin: "channel_skew",
    parameters: &[
        Quantity::new(OF_CHANNELS[1], "s", RANGE, "d of B, against A"),
        Quantity::new(OF_CHANNELS[2], "s", RANGE, "d of C, against A"),
    ],
    locked_to: &[LockedTo::Angle],
    speed_exponent: Some(1),
    edge_classes: EdgeClasses::ChannelAgainstChannel,
    look_alikes: &[Mechanism::QuadratureError],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "Two recordings at speeds a factor of two apart: unequal delays of the channels grow with the speed, a quadrature error \
                   does not.",
    handling: Handling {
        makes: |basis| matches!(basis, Basis::Late { .. }),
        columns,
        proposed: |board| of_channels(board).map_or_else(Vec::new, all),
        instead_of: |found, setting| match found.bases.first() {
            Some(Basis::Shift { .. }) => all(setting.channels),
            _ => Vec::new(),
        },
        beside: |_, channels| widths_and_shifts(channels),
        values,
        text: |shows| {
            format!(
                "{} against the others, the same time throughout",
                shows.edges
            )
        },
        mends,
        ..Handling::NONE
    },
};

fn all(channels: usize) -> Vec<Hypothesis> {
    let each = (1..channels).map(|channel| Basis::Late { channel });
    Hypothesis::by_all(each.collect()).into_iter().collect()
}

fn columns(basis: Basis, seen: &Seen, _: &ShaftLaw) -> Vec<Vec<f64>> {
    let Basis::Late { channel } = basis else {
        return Vec::new();
    };
    by_edge(seen, |at, change| {
        if change.channel == channel {
            -seen.true_speed(at)
        } else {
            0.0
        }
    })
}

fn values(numbers: &Numbers<'_>) -> Named {
    let each = numbers.bases().filter_map(|(at, basis)| match basis {
        Basis::Late { channel } => Some((OF_CHANNELS[channel].to_owned(), Numbers::size(at))),
        _ => None,
    });
    each.collect()
}

fn mends(mended: &mut Mended, basis: Basis, sizes: &[f64]) {
    let Basis::Late { channel } = basis else {
        return;
    };
    let mut skew = mended.twin.channel_skew.unwrap_or_default();
    let mut all = [skew.a_s, skew.b_s, skew.c_s];
    all[channel.min(2)] += sizes[0];
    // No delay is negative: the others wait instead.
    let least = all.into_iter().fold(0.0, f64::min);
    let there = mended.channels();
    all.iter_mut().take(there).for_each(|late| *late -= least);
    [skew.a_s, skew.b_s, skew.c_s] = all;
    mended.twin.channel_skew = Some(skew);
}

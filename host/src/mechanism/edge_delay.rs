//! `edge_delay`: rising and falling levels are captured with unequal delays.
//!
//! A comparator, an optocoupler or a filter answers a rising level later, or sooner, than a falling one. What is stamped d late is read
//! w d behind, w being the signed speed:
//! `e = -w (d_rise - d_fall) on rising levels, 0 on falling ones`
//! as only the difference shows; or, where the rises of one channel stay with those of the others,
//! `e = w (d_rise - d_fall) on its falling levels, 0 on all others`. Passed in reverse, a mark at which the level rises makes it fall. At one speed that is a width error;
//! it grows with the speed as no width does. Simulated in `sim/signal.rs`.
//!
//! Source: kinematics, first order in the delay: the shaft goes on by w d until the stamp.

use super::card::DELAY_S;
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
/// Its numbers where each channel has its own.
const OF_CHANNELS: [&str; 3] = [
    "a.rise_less_fall_s",
    "b.rise_less_fall_s",
    "c.rise_less_fall_s",
];

/// Its card.
pub const CARD: Card = Card {
    title: "rise and fall delayed unequally",
    physics: "A comparator, an optocoupler or a filter passes a rising level later than a falling one, or sooner. The shaft turns on \
              meanwhile, so the shift grows with the speed.",
    equation: "e = -w (d_rise - d_fall) on rising levels, 0 on falling ones",
    source: "kinematics, first order in the delay: the shaft goes on by w d until the stamp",
    twin: "edge_delay",
    parameters: &[
        Quantity::new(
            "rise_less_fall_s",
            "s",
            RANGE,
            "d_rise - d_fall, where all channels have the same",
        ),
        Quantity::new(OF_CHANNELS[0], "s", RANGE, "the same of A"),
        Quantity::new(OF_CHANNELS[1], "s", RANGE, "the same of B"),
        Quantity::new(OF_CHANNELS[2], "s", RANGE, "the same of C"),
    ],
    locked_to: &[LockedTo::Angle],
    speed_exponent: Some(1),
    edge_classes: EdgeClasses::RiseAgainstFall,
    look_alikes: &[Mechanism::WidthError, Mechanism::ThresholdDrift],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "Two recordings at speeds a factor of two apart: unequal delays of rise and fall grow with the speed, width errors do not.",
    handling: Handling {
        makes: |basis| matches!(basis, Basis::RiseLate { .. } | Basis::FallEarly { .. }),
        columns,
        proposed: |board| of_channels(board).map_or_else(Vec::new, proposed),
        instead_of: |found, setting| match found.bases.first() {
            Some(Basis::Width { .. }) => ways(setting.channels),
            _ => Vec::new(),
        },
        beside: |_, channels| widths_and_shifts(channels),
        values,
        text: |shows| {
            format!(
                "{} later than the others, by the same time throughout",
                shows.edges
            )
        },
        mends,
        ..Handling::NONE
    },
};

/// Of one channel there is only its own.
fn proposed(channels: usize) -> Vec<Hypothesis> {
    let mut all = ways(channels);
    if channels == 1 {
        all.truncate(1);
    }
    all
}

/// One difference for all channels, and one each: of its rises, or of its falls, against the edges of the others.
fn ways(channels: usize) -> Vec<Hypothesis> {
    let rises = (0..channels).map(|c| Basis::RiseLate { channel: Some(c) });
    let falls = (0..channels).map(|channel| Basis::FallEarly { channel });
    let mut all = vec![Hypothesis::by(Basis::RiseLate { channel: None })];
    all.extend(Hypothesis::by_all(rises.collect()));
    all.extend(Hypothesis::by_all(falls.collect()));
    all
}

/// What an unknown disc has for all edges of a class alike.
pub(super) fn widths_and_shifts(channels: usize) -> Vec<Basis> {
    let widths = (0..channels).map(|c| Basis::Width { channel: Some(c) });
    let shifts = (1..channels).map(|channel| Basis::Shift { channel });
    widths.chain(shifts).collect()
}

fn columns(basis: Basis, seen: &Seen, _: &ShaftLaw) -> Vec<Vec<f64>> {
    let (channel, rises) = match basis {
        Basis::RiseLate { channel } => (channel, true),
        Basis::FallEarly { channel } => (Some(channel), false),
        _ => return Vec::new(),
    };
    by_edge(seen, |at, change| {
        // Backwards a rise is passed as a fall.
        let reverse = seen.speeds[at] < 0.0;
        let its = change.on(channel) && (change.rises != reverse) == rises;
        match (its, rises) {
            (false, _) => 0.0,
            (true, true) => -seen.true_speed(at),
            (true, false) => seen.true_speed(at),
        }
    })
}

fn values(numbers: &Numbers<'_>) -> Named {
    let each = numbers.bases().filter_map(|(at, basis)| match basis {
        Basis::RiseLate { channel: None } => {
            Some(("rise_less_fall_s".to_owned(), Numbers::size(at)))
        }
        Basis::RiseLate { channel: Some(c) } | Basis::FallEarly { channel: c } => {
            Some((OF_CHANNELS[c].to_owned(), Numbers::size(at)))
        }
        _ => None,
    });
    each.collect()
}

fn mends(mended: &mut Mended, basis: Basis, sizes: &[f64]) {
    let (channel, rises) = match basis {
        Basis::RiseLate { channel } => (channel, true),
        Basis::FallEarly { channel } => (Some(channel), false),
        _ => return,
    };
    let mut delay = mended.twin.edge_delay.unwrap_or_default();
    // Of channels that this encoder has.
    let channels = mended.channels();
    let mut each = [&mut delay.a, &mut delay.b, &mut delay.c];
    let there = &mut each[..channels.min(3)];
    for (number, one) in there.iter_mut().enumerate() {
        if channel.is_none_or(|channel| channel == number) {
            if rises {
                one.rise_s += sizes[0];
            } else {
                one.fall_s -= sizes[0];
            }
        }
    }
    // No delay is negative: all the others wait instead, as an earlier rise of one channel is no later fall of it.
    let all = there.iter().map(|one| one.rise_s.min(one.fall_s));
    let least = all.fold(0.0, f64::min);
    for one in there {
        one.rise_s -= least;
        one.fall_s -= least;
    }
    mended.twin.edge_delay = Some(delay);
}

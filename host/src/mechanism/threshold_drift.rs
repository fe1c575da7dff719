//! `threshold_drift`: the comparator's level drifts.
//!
//! A lamp ages, a head warms up: level or signal settle slowly, and rises and falls move against each other as with
//! [`Mechanism::ThresholdRipple`],
//! `e = -+ a (1 - exp(-(t - t0) / tau)) from t0 on: - on rising edges, + on falling ones`
//! Linear in a; t0 and tau are searched for, from some starts. Simulated in `sim/shift.rs`.
//!
//! Source: first-order lag of a temperature, and the crossing's shift by the level's change over the signal's slope (P. Horowitz,
//! W. Hill, The Art of Electronics, comparators).

use super::card::{ERROR_RAD, INSTANT_S};
use super::{Card, EdgeClasses, Handling, LockedTo, Mechanism, Quantity};
use crate::diagnose::basis::Basis;
use crate::diagnose::board::Board;
use crate::diagnose::classes::{by_edge, channels};
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::mended::{Mended, channel};
use crate::diagnose::named::{Named, Numbers};
use crate::diagnose::seen::Seen;
use crate::diagnose::shaft::ShaftLaw;
use crate::twin::ThresholdDrift;

/// Time constants that are tried, in the recording's length.
const TAUS: [f64; 3] = [0.08, 0.2, 0.5];

/// Its card.
pub const CARD: Card = Card {
    title: "drift of the comparator's level",
    physics: "A lamp ages or a head warms up: the comparator's level, or the signal under it, settles slowly, and rising and falling \
              edges move against each other.",
    equation: "e = -+ a (1 - exp(-(t - t0) / tau)) from t0 on: - on rising edges, + on falling ones",
    source: "first-order lag of a temperature, and the crossing's shift by the level's change over the signal's slope (P. Horowitz, \
             W. Hill, The Art of Electronics, comparators)",
    twin: "threshold_drift",
    parameters: &[
        Quantity::new(
            "angle_rad",
            "rad",
            [-ERROR_RAD, ERROR_RAD],
            "a, where it settles",
        ),
        Quantity::new("tau_s", "s", [1e-6, 1e7], "its time constant"),
        Quantity::new("from_s", "s", INSTANT_S, "t0, when it begins"),
    ],
    locked_to: &[LockedTo::SlowTime],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::RiseAgainstFall,
    look_alikes: &[
        Mechanism::WidthError,
        Mechanism::EdgeDelay,
        Mechanism::SpeedDrift,
    ],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A recording from cold that lasts several times as long, at one speed: a drifting level settles, width errors and delays \
                   are there from the start.",
    handling: Handling {
        makes: |basis| matches!(basis, Basis::LevelDrift { .. }),
        columns,
        proposed,
        values,
        text: |shows| {
            let from = shows.place.times_s.first().copied().unwrap_or(0.0);
            match shows.place.channels.as_slice() {
                [one] => format!("rising against falling edges of {one}, from {from:.3} s on"),
                _ => format!("rising against falling edges, from {from:.3} s on"),
            }
        },
        mends,
        ..Handling::NONE
    },
};

/// From several starts, with several time constants.
fn proposed(board: &Board) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    if board.benches[0].seen.classes < 2 {
        return all;
    }
    for bench in &board.benches {
        let first = bench.seen.times_s.first().copied().unwrap_or(0.0);
        let long = bench.seen.seconds();
        let channels = channels(bench.seen.classes);
        for start in 0..8 {
            let from_s = first + f64::from(start) / 12.0 * long;
            let drift = |tau: f64, channel| Basis::LevelDrift {
                from_s,
                tau_s: tau * long,
                channel,
            };
            all.extend(TAUS.map(|tau| Hypothesis::by(drift(tau, None))));
            let alone = (0..channels).filter(|_| channels > 1);
            all.extend(alone.map(|channel| Hypothesis::by(drift(TAUS[1], Some(channel)))));
        }
    }
    all
}

fn columns(basis: Basis, seen: &Seen, _: &ShaftLaw) -> Vec<Vec<f64>> {
    let Basis::LevelDrift {
        from_s,
        tau_s,
        channel,
    } = basis
    else {
        return Vec::new();
    };
    by_edge(seen, |at, change| {
        let since = (seen.times_s[at] - from_s).max(0.0);
        let size = -(-since / tau_s).exp_m1();
        match change.on(channel) {
            false => 0.0,
            true if change.rises => -size,
            true => size,
        }
    })
}

fn values(numbers: &Numbers<'_>) -> Named {
    let Basis::LevelDrift { from_s, tau_s, .. } = numbers.basis() else {
        return Named::new();
    };
    vec![
        ("angle_rad".to_owned(), Numbers::size(numbers.strongest())),
        ("from_s".to_owned(), numbers.searched(from_s, 0)),
        ("tau_s".to_owned(), numbers.scaled(tau_s, 1)),
    ]
}

fn mends(mended: &mut Mended, basis: Basis, sizes: &[f64]) {
    if let Basis::LevelDrift {
        from_s,
        tau_s,
        channel: on,
    } = basis
    {
        mended.twin.threshold_drift.push(ThresholdDrift {
            angle_rad: sizes[0],
            tau_s,
            from_s: from_s.max(0.0),
            channel: on.map(channel),
        });
    }
}

//! `speed_drift`: the drive's speed changes slowly.
//!
//! A motor warms up, a supply sags: the speed that an open-loop drive asks for grows by a share r of it every second,
//! `w*(t) = w0(t) (1 + r t)`
//! and the drive pushes what the shaft needs to follow, J dw/dt and damping times what it asks for on top. Linear in r. Simulated in
//! `sim/profile.rs`.
//!
//! Source: first order of a slow change of the drive's speed in time, and Newton's law for the shaft.

use super::{Card, EdgeClasses, Handling, LockedTo, Mechanism, Quantity};
use crate::diagnose::basis::Basis;
use crate::diagnose::board::{Bench, Board};
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::named::Numbers;
use crate::diagnose::response::pushed;
use crate::diagnose::seen::Seen;
use crate::diagnose::shaft::ShaftLaw;
use crate::twin::SpeedDrift;

/// Its card.
pub const CARD: Card = Card {
    title: "slow change of the drive's speed",
    physics: "A motor warms up, a supply sags: the speed that an open-loop drive asks for changes by a small share of it every second.",
    equation: "w*(t) = w0(t) (1 + r t)",
    source: "first order of a slow change of the drive's speed in time, and Newton's law for the shaft",
    twin: "speed_drift",
    parameters: &[Quantity::new(
        "fraction_per_s",
        "1/s",
        [-10.0, 10.0],
        "r, change over the speed and second",
    )],
    locked_to: &[LockedTo::SlowTime],
    speed_exponent: None,
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[
        Mechanism::Friction,
        Mechanism::LoadStep,
        Mechanism::ThresholdDrift,
    ],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A recording several times as long at one speed, load disconnected: a drift goes on or settles slowly, a load step comes \
                   at once, a drifting level moves rises against falls.",
    handling: Handling {
        makes: |basis| matches!(basis, Basis::Drift),
        columns,
        proposed,
        instead_of: |found, _| match found.bases.first() {
            Some(Basis::Load { .. }) => vec![Hypothesis::by(Basis::Drift)],
            _ => Vec::new(),
        },
        values: |numbers| {
            let size = Numbers::size(numbers.strongest());
            vec![("fraction_per_s".to_owned(), size)]
        },
        text: |_| "the speed changes evenly from beginning to end".to_owned(),
        mends: |mended, _, sizes| {
            mended.twin.speed_drift = Some(SpeedDrift {
                fraction_per_s: Some(sizes[0]),
                fraction: None,
                tau_s: None,
            });
        },
        ..Handling::NONE
    },
};

/// Where any drive is on.
fn proposed(board: &Board) -> Vec<Hypothesis> {
    let driven = |bench: &Bench| {
        let first_s = bench.seen.times_s.first().copied().unwrap_or(0.0);
        bench.law.driven(first_s)
    };
    let any = board.benches.iter().any(driven);
    any.then(|| Hypothesis::by(Basis::Drift))
        .into_iter()
        .collect()
}

fn columns(_: Basis, seen: &Seen, law: &ShaftLaw) -> Vec<Vec<f64>> {
    vec![pushed(seen, &|at, end| {
        // What the drive adds to follow: J dw/dt and damping times what it asks for on top.
        let h = seen.readings[at].leap.after_s;
        let time = seen.times_s[at] - (1.0 - end) * h;
        if !law.driven(time) {
            return 0.0;
        }
        let speed = seen.speeds[at];
        speed + law.damping(time, speed) * speed * time
    })]
}

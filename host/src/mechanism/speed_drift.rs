//! `speed_drift`: the drive's speed changes slowly.
//!
//! A motor warms up, a supply sags: the speed that an open-loop drive asks for grows by a share r of it every second, or settles at a
//! share f more,
//! `w*(t) = w0(t) (1 + r t), or w0(t) (1 + f (1 - exp(-t / tau))) where it settles`
//! and the drive pushes what the shaft needs to follow, J dw/dt and damping times what it asks for on top. Linear in r and f. Simulated
//! in `sim/profile.rs`.
//!
//! Source: first order of a slow change of the drive's speed in time, the first-order lag of a temperature, and Newton's law for the
//! shaft.

use super::{Card, EdgeClasses, Handling, LockedTo, Mechanism, Quantity};
use crate::diagnose::basis::Basis;
use crate::diagnose::board::{Bench, Board};
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::named::{Named, Numbers};
use crate::diagnose::response::pushed;
use crate::diagnose::seen::Seen;
use crate::diagnose::shaft::ShaftLaw;
use crate::twin::SpeedDrift;

/// Its card.
pub const CARD: Card = Card {
    title: "slow change of the drive's speed",
    physics: "A motor warms up, a supply sags: the speed that an open-loop drive asks for changes by a small share of it every second.",
    equation: "w*(t) = w0(t) (1 + r t), or w0(t) (1 + f (1 - exp(-t / tau))) where it settles",
    source: "first order of a slow change of the drive's speed in time, the first-order lag of a temperature, and Newton's law for the \
             shaft",
    twin: "speed_drift",
    parameters: &[
        Quantity::new(
            "fraction_per_s",
            "1/s",
            [-10.0, 10.0],
            "r, change over the speed and second, where it goes on evenly",
        ),
        Quantity::new(
            "fraction",
            "1",
            [-0.9, 0.9],
            "f, change over the speed in the end, where it settles",
        ),
        Quantity::new(
            "tau_s",
            "s",
            [1e-3, 1e7],
            "tau, its time constant, where it settles",
        ),
    ],
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
        makes: |basis| matches!(basis, Basis::Drift | Basis::Warming { .. }),
        columns,
        proposed,
        instead_of: |found, _| match found.bases.first() {
            Some(Basis::Load { .. }) => vec![Hypothesis::by(Basis::Drift)],
            _ => Vec::new(),
        },
        values,
        text: |_| "the speed changes evenly, or settles, from the beginning on".to_owned(),
        mends: |mended, basis, sizes| {
            mended.twin.speed_drift = Some(match basis {
                Basis::Warming { tau_s } => SpeedDrift {
                    fraction_per_s: None,
                    fraction: Some(sizes[0]),
                    tau_s: Some(tau_s),
                },
                _ => SpeedDrift {
                    fraction_per_s: Some(sizes[0]),
                    fraction: None,
                    tau_s: None,
                },
            });
        },
        ..Handling::NONE
    },
};

/// Where any drive is on: evenly, and with several time constants.
fn proposed(board: &Board) -> Vec<Hypothesis> {
    let driven = |bench: &Bench| {
        let first_s = bench.seen.times_s.first().copied().unwrap_or(0.0);
        bench.law.driven(first_s)
    };
    if !board.benches.iter().any(driven) {
        return Vec::new();
    }
    let longest_s = board.benches.iter().map(|bench| bench.seen.seconds());
    let longest_s = longest_s.fold(0.0, f64::max);
    let parts = [0.08, 0.2, 0.5].into_iter();
    let settling = parts.map(|part| Basis::Warming {
        tau_s: part * longest_s,
    });
    let all = std::iter::once(Basis::Drift).chain(settling);
    all.map(Hypothesis::by).collect()
}

fn columns(basis: Basis, seen: &Seen, law: &ShaftLaw) -> Vec<Vec<f64>> {
    // How far it has grown, and by how much a second.
    let grown = |time: f64| match basis {
        Basis::Warming { tau_s } => {
            let left = (-time / tau_s).exp();
            (1.0 - left, left / tau_s)
        }
        _ => (time, 1.0),
    };
    vec![pushed(seen, &|at, end| {
        // What the drive adds to follow: J dw/dt and damping times what it asks for on top.
        let h = seen.readings[at].leap.after_s;
        let time = seen.times_s[at] - (1.0 - end) * h;
        if !law.driven(time) {
            return 0.0;
        }
        let speed = seen.speeds[at];
        let (grown, rate) = grown(time);
        speed * rate + law.damping(time, speed) * speed * grown
    })]
}

fn values(numbers: &Numbers<'_>) -> Named {
    let size = Numbers::size(numbers.strongest());
    match numbers.basis() {
        Basis::Warming { tau_s } => vec![
            ("fraction".to_owned(), size),
            ("tau_s".to_owned(), numbers.scaled(tau_s, 0)),
        ],
        _ => vec![("fraction_per_s".to_owned(), size)],
    }
}

//! `load_step`: a torque that comes and goes.
//!
//! A tool bites, a clutch closes: a constant torque from one time to another,
//! `J dw/dt = T from t1 to t2, 0 else`
//! The shaft falls behind until the drive's stiffness and friction hold it. Both times are searched for, from where innovations have a
//! mean (`diagnose/scan.rs`); the torque is linear. Simulated in `sim/load.rs`.
//!
//! Source: Newton's law for the shaft, linear about its course.

use super::card::{INSTANT_S, TORQUE_N_M};
use super::{Card, EdgeClasses, Handling, LockedTo, Mechanism, Quantity};
use crate::diagnose::basis::Basis;
use crate::diagnose::mended::Mended;
use crate::diagnose::named::{Named, Numbers};
use crate::diagnose::response::pushed;
use crate::diagnose::seen::Seen;
use crate::diagnose::shaft::ShaftLaw;
use crate::twin::LoadStep;

/// Its card.
pub const CARD: Card = Card {
    title: "load step",
    physics: "A tool bites, a clutch closes: a constant torque comes at one time and goes at another. The shaft gives way until the drive \
              and friction hold it.",
    equation: "J dw/dt = T from t1 to t2, 0 else",
    source: "Newton's law for the shaft, linear about its course",
    twin: "load_step",
    parameters: &[
        Quantity::new(
            "torque_n_m",
            "N m",
            [-TORQUE_N_M, TORQUE_N_M],
            "T, positive forward",
        ),
        Quantity::new(
            "count",
            "1",
            [0.0, 1e9],
            "pushes while no drive is on, the torque being their mean: only told, in `where` too, and not put into the twin",
        ),
        Quantity::new(
            "from_s",
            "s",
            INSTANT_S,
            "t1, left out where it is there from the beginning",
        ),
        Quantity::new(
            "until_s",
            "s",
            INSTANT_S,
            "t2, left out where it is there to the end",
        ),
    ],
    locked_to: &[LockedTo::Instants],
    speed_exponent: None,
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[Mechanism::SpeedDrift, Mechanism::Friction],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "The same run once more: a load step comes at another time or not at all, friction and the drive's own profile do not move.",
    handling: Handling {
        makes: |basis| matches!(basis, Basis::Load { .. }),
        columns,
        values,
        text: |shows| match shows.place.times_s.as_slice() {
            [from, until] => format!("a push from {from:.4} to {until:.4} s"),
            _ => "a push from beginning or to the end".to_owned(),
        },
        mends,
        ..Handling::NONE
    },
};

fn columns(basis: Basis, seen: &Seen, law: &ShaftLaw) -> Vec<Vec<f64>> {
    let Basis::Load { from_s, until_s } = basis else {
        return Vec::new();
    };
    vec![pushed(seen, &|at, _| {
        let now = seen.times_s[at];
        let before = now - seen.readings[at].leap.after_s;
        // The part of the interval under load pushes as much as the whole would in part.
        let under = (now.min(until_s) - before.max(from_s)).max(0.0);
        if now > before {
            under / (now - before) / law.inertia
        } else {
            0.0
        }
    })]
}

fn values(numbers: &Numbers<'_>) -> Named {
    let Basis::Load { from_s, until_s } = numbers.basis() else {
        return Named::new();
    };
    let mut all = vec![("torque_n_m".to_owned(), Numbers::size(numbers.strongest()))];
    if from_s.is_finite() {
        all.push(("from_s".to_owned(), numbers.searched(from_s, 0)));
    }
    if until_s.is_finite() {
        all.push(("until_s".to_owned(), numbers.searched(until_s, 1)));
    }
    all
}

fn mends(mended: &mut Mended, basis: Basis, sizes: &[f64]) {
    if let Basis::Load { from_s, until_s } = basis {
        mended.twin.load_step.push(LoadStep {
            torque_n_m: sizes[0],
            from_s: from_s.max(0.0),
            until_s: until_s.is_finite().then_some(until_s),
        });
    }
}

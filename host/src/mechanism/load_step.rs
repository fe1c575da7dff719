//! `load_step`: a torque that comes and goes.
//!
//! A tool bites, a clutch closes: a constant torque from one time to another,
//! `J dw/dt = T from t1 to t2, 0 else`
//! The shaft falls behind until the drive's stiffness and friction hold it. Both times are searched for, from where innovations have a
//! mean (`diagnose/scan.rs`); the torque is linear. Simulated in `sim/load.rs`.
//!
//! Source: Newton's law for the shaft, linear about its course.

use super::card::{INSTANT_S, TORQUE_N_M};
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

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
};

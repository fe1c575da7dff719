//! `torque_ripple`: cogging or commutation torque at the motor's orders.
//!
//! Teeth against magnets, and current against back-EMF, push and brake in turn, n times a turn with n whole:
//! `J dw/dt = T sin(n theta + phi), so e = -T / (J (n w)^2) sin(n theta + phi) at speed w`
//! for a shaft that nothing holds; stiffness of the drive and friction make it smaller. It falls with the square of the speed, where
//! errors of the disc keep their size. The response is integrated along the recording (`diagnose/response.rs`), so it is right on ramps
//! and reversals as well; n is a whole number near a peak of the spectrum along the turn. A [`Mechanism::GearMesh`] may have such an order
//! too, and is named beside it. Simulated in `sim/taylor.rs`.
//!
//! Source: Newton's law for the shaft, linear about its mean speed; orders of the pole pairs as in section 4 of Yin, Guo et al.,
//! doi 10.19650/j.cnki.cjsi.J2210801.

use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "torque ripple of the motor",
    physics: "Teeth against magnets (cogging), current against back-EMF (commutation), or an unbalanced mass push and brake the shaft in \
              turn, a whole number of times a turn.",
    equation: "J dw/dt = T sin(n theta + phi), so e = -T / (J (n w)^2) sin(n theta + phi) at speed w",
    source: "Newton's law for the shaft, linear about its mean speed; orders of the pole pairs as in section 4 of Yin, Guo et al., \
             doi 10.19650/j.cnki.cjsi.J2210801",
    twin: "ripple",
    parameters: &[
        Quantity::new("order", "1", [1.0, 1e5], "n, cycles a turn, a whole number"),
        Quantity::torque("T, its amplitude"),
        Quantity::phase("phi, its phase at angle 0"),
    ],
    locked_to: &[LockedTo::WholeOrders],
    speed_exponent: Some(-2),
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[
        Mechanism::Eccentricity,
        Mechanism::DiscTilt,
        Mechanism::LineError,
        Mechanism::TorqueTone,
        Mechanism::GearMesh,
        Mechanism::Bearing,
        Mechanism::ClosedLoop,
    ],
    same_mark: &[],
    told_by_rig: &[Mechanism::GearMesh],
    separated_by: "Two recordings at speeds a factor of two apart, in torque or voltage mode: torque falls with the square of the speed, \
                   errors of the disc keep their size in angle, a torque tone keeps its frequency.",
};

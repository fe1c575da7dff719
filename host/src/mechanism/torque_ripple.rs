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

use super::{Card, EdgeClasses, Handling, LockedTo, Mechanism, Quantity, Shows};
use crate::diagnose::basis::Basis;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::mended::wave;
use crate::diagnose::named::{Named, Numbers, Value};
use crate::diagnose::response::pushed_round;
use crate::diagnose::seen::Seen;
use crate::diagnose::shaft::ShaftLaw;
use crate::twin::Ripple;

/// Part of a cycle by which the order of a tone at the mean speed may be off a whole one for it to be a ripple's.
const NEAR: f64 = 0.05;

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
    handling: Handling {
        makes: |basis| torque_order(basis).is_some_and(|order| order.fract() == 0.0),
        columns,
        of_rhythm: |rhythm| {
            let order = rhythm.whole()?;
            Some(Basis::TorqueOrder { order })
        },
        instead_of: |found, setting| match found.bases.first() {
            Some(&Basis::Round { order }) if order.fract() == 0.0 => {
                vec![Hypothesis::by(Basis::TorqueOrder { order })]
            }
            Some(&Basis::TorqueTone { f_hz }) => {
                let cycles = std::f64::consts::TAU * f_hz / setting.speed_rad_s;
                let order = cycles.round();
                let near = order >= 1.0 && (cycles - order).abs() < NEAR;
                let whole = near.then_some(Basis::TorqueOrder { order });
                whole.into_iter().map(Hypothesis::by).collect()
            }
            _ => Vec::new(),
        },
        // The disc has an error of that order as well, as long as it is unknown; what was learned as the disc's and is the torque's goes
        // with the true angle.
        beside: |basis, _| {
            let order = torque_order(basis);
            order
                .map(|order| Basis::Lagged { order })
                .into_iter()
                .collect()
        },
        values: |numbers| {
            let order = torque_order(numbers.basis()).unwrap_or(0.0);
            named(Box::new(move |_| order))
        },
        text,
        mends: |mended, basis, sizes| mended.twin.ripple.extend(declared(basis, sizes)),
        ..Handling::NONE
    },
};

/// The order of a pattern that is a torque locked to the shaft.
pub(super) fn torque_order(basis: Basis) -> Option<f64> {
    match basis {
        Basis::TorqueOrder { order } => Some(order),
        _ => None,
    }
}

/// The shaft's answer to cos and sin of an order of its true angle.
pub(super) fn columns(basis: Basis, seen: &Seen, law: &ShaftLaw) -> Vec<Vec<f64>> {
    let Some(order) = torque_order(basis) else {
        return Vec::new();
    };
    let theta: Vec<f64> = (0..seen.len()).map(|at| seen.true_theta(at)).collect();
    pushed_round(seen, law, &|at, share| {
        // Where the shaft turned round in between, it was just past the place.
        let came = theta[at] - theta[at.saturating_sub(1)];
        order * (theta[at] + share * came)
    })
}

/// Order, torque and phase.
pub(super) fn named(order: Value) -> Named {
    vec![
        ("order".to_owned(), order),
        ("torque_n_m".to_owned(), Numbers::amplitude(0)),
        ("phase_rad".to_owned(), Numbers::phase(0)),
    ]
}

/// A torque of an order in words.
pub(super) fn text(shows: Shows<'_>) -> String {
    format!(
        "order {}, {}, smaller the faster it turns",
        shows.order_in_words(),
        shows.edges
    )
}

/// As a twin declares it.
pub(super) fn declared(basis: Basis, sizes: &[f64]) -> Option<Ripple> {
    let (torque_n_m, phase_rad) = wave(sizes);
    Some(Ripple {
        order: torque_order(basis)?,
        phase_rad,
        torque_n_m: Some(torque_n_m),
        speed_fraction: None,
    })
}

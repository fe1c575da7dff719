//! `torque_tone`: torque at a fixed frequency.
//!
//! An unbalanced machine on the same frame, or a drive's current ripple, pushes and brakes at its own rate, whatever the shaft does:
//! `J dw/dt = T sin(2 pi f t + phi), so e = -T / (J (2 pi f)^2) sin(2 pi f t + phi)`
//! for a shaft that nothing holds: the same angle at any speed, at a frequency that stays. Nothing ties the times of two recordings, so
//! each has a size and a phase of its own. Simulated in `sim/tone.rs`.
//!
//! Source: Newton's law for the shaft, linear about its mean speed.

use super::card::FREQUENCIES_HZ;
use super::{Card, EdgeClasses, Handling, LockedTo, Mechanism, Quantity, Setting};
use crate::diagnose::basis::Basis;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::mended::{Mended, wave};
use crate::diagnose::named::{Named, Numbers};
use crate::diagnose::response::pushed_round;
use crate::diagnose::seen::Seen;
use crate::diagnose::shaft::ShaftLaw;
use crate::twin::TorqueTone;

/// Its card.
pub const CARD: Card = Card {
    title: "torque at a fixed frequency",
    physics: "An unbalanced machine on the same frame, or a drive's current ripple, pushes and brakes the shaft at a rate of its own, \
              whatever the shaft does.",
    equation: "J dw/dt = T sin(2 pi f t + phi), so e = -T / (J (2 pi f)^2) sin(2 pi f t + phi)",
    source: "Newton's law for the shaft, linear about its mean speed",
    twin: "torque_tone",
    parameters: &[
        Quantity::new("f_hz", "Hz", FREQUENCIES_HZ, "f, its frequency"),
        Quantity::torque("T, its amplitude"),
        Quantity::phase("phi, its phase at the recording's time 0"),
    ],
    locked_to: &[LockedTo::Frequency],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[
        Mechanism::GearMesh,
        Mechanism::Bearing,
        Mechanism::TorqueRipple,
        Mechanism::TorsionalResonance,
        Mechanism::ThresholdRipple,
        Mechanism::StickSlip,
    ],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A recording at a speed that differs by a tenth or more: the frequency stays, that of an order moves with the speed.",
    handling: Handling {
        makes: |basis| matches!(basis, Basis::TorqueTone { .. }),
        columns,
        of_rhythm: |rhythm| Some(Basis::TorqueTone { f_hz: rhythm.f_hz }),
        instead_of,
        values,
        text: |shows| format!("{:.4} Hz, {}", shows.f_hz(), shows.edges),
        mends,
        ..Handling::NONE
    },
};

/// At the frequency that an order has at the mean speed.
fn instead_of(found: &Hypothesis, setting: Setting) -> Vec<Hypothesis> {
    match found.bases.first() {
        Some(&Basis::Lagged { order } | &Basis::TorqueOrder { order }) if order.fract() != 0.0 => {
            let f_hz = order * setting.speed_rad_s / std::f64::consts::TAU;
            vec![Hypothesis::by(Basis::TorqueTone { f_hz })]
        }
        _ => Vec::new(),
    }
}

fn columns(basis: Basis, seen: &Seen, law: &ShaftLaw) -> Vec<Vec<f64>> {
    let Basis::TorqueTone { f_hz } = basis else {
        return Vec::new();
    };
    pushed_round(seen, law, &|at, share| {
        let time_s = seen.times_s[at] + share * seen.readings[at].leap.after_s;
        std::f64::consts::TAU * f_hz * time_s
    })
}

fn values(numbers: &Numbers<'_>) -> Named {
    let Basis::TorqueTone { f_hz } = numbers.basis() else {
        return Named::new();
    };
    let at = numbers.strongest();
    vec![
        ("f_hz".to_owned(), numbers.searched(f_hz, 0)),
        ("torque_n_m".to_owned(), Numbers::amplitude(at)),
        ("phase_rad".to_owned(), Numbers::phase(at)),
    ]
}

fn mends(mended: &mut Mended, basis: Basis, sizes: &[f64]) {
    if let Basis::TorqueTone { f_hz } = basis {
        let (torque_n_m, phase_rad) = wave(sizes);
        mended.twin.torque_tone.push(TorqueTone {
            f_hz,
            phase_rad,
            torque_n_m: Some(torque_n_m),
            speed_fraction: None,
        });
    }
}

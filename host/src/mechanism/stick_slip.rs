//! `stick_slip`: a limit cycle of friction and spring at low speed.
//!
//! A drive pulls the shaft through a spring; friction that falls with speed holds it until the spring is wound up, then lets it slip:
//! `J u'' = K (w t - u) + Fs (1 - exp(-(u' / ws)^2)) - b u'`
//! with u the way since the shaft broke away. It is another motion altogether, so it is recognised by its standstills and fitted slip by
//! slip before anything small is looked for: `diagnose/motion/stick_slip.rs`, `diagnose/motion/slip.rs`. Coulomb friction is in none
//! of it and only winds up the spring. Simulated in `sim/spring.rs` and `sim/extended.rs`.
//!
//! Source: Stribeck friction against a spring (B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, A survey of models, analysis
//! tools and compensation methods for the control of machines with friction, Automatica 30, 1994, section 2).

use super::card::TORQUE_N_M;
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "stick-slip",
    physics: "A drive pulls the shaft through a spring. Friction that falls with speed holds it until the spring is wound up, then lets \
              it slip, again and again.",
    equation: "J u'' = K (w t - u) + Fs (1 - exp(-(u' / ws)^2)) - b u'",
    source: "Stribeck friction against a spring (B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, A survey of models, analysis \
             tools and compensation methods for the control of machines with friction, Automatica 30, 1994, section 2)",
    twin: "stick_slip",
    parameters: &[
        Quantity::new(
            "stiffness_n_m_rad",
            "N m/rad",
            [0.0, TORQUE_N_M],
            "K, stiffness of the spring",
        ),
        Quantity::new(
            "stribeck_n_m",
            "N m",
            [0.0, TORQUE_N_M],
            "Fs, Stribeck friction",
        ),
        Quantity::new(
            "stribeck_rad_s",
            "rad/s",
            [0.0, 1e6],
            "ws, speed over which it falls",
        ),
        Quantity::new(
            "coulomb_n_m",
            "N m",
            [0.0, TORQUE_N_M],
            "least Coulomb friction that holds the shaft: more of it looks the same, so there is no interval",
        ),
    ],
    locked_to: &[LockedTo::Speed],
    speed_exponent: None,
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[Mechanism::TorqueTone, Mechanism::TorsionalResonance],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A recording at several times the speed: stick-slip ends above a critical speed, tones and resonances stay.",
};

//! `friction`: what shapes a run-down.
//!
//! Dry, viscous, Stribeck and air friction brake a shaft that nothing drives:
//! `J dw/dt = -(Fc + Fs exp(-(w / ws)^2)) sgn(w) - b w - D w |w|`
//! Where a drive is on it balances friction, so only what comes after it goes off says anything. Each term is a pattern by itself, a
//! change against what the twin declares; ws is searched for, from some shares of the highest speed. Simulated in `sim/extended.rs`.
//!
//! Source: Coulomb, viscous and Stribeck terms (B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, A survey of models, analysis
//! tools and compensation methods for the control of machines with friction, Automatica 30, 1994, section 2); drag of turbulent air
//! with the square of the speed.

use super::card::TORQUE_N_M;
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Changes go either way.
const RANGE: [f64; 2] = [-TORQUE_N_M, TORQUE_N_M];

/// Its card.
pub const CARD: Card = Card {
    title: "friction",
    physics: "Dry, viscous, Stribeck and air friction brake a shaft that nothing drives and shape its run-down. What a drive that is on \
              balances can't be seen.",
    equation: "J dw/dt = -(Fc + Fs exp(-(w / ws)^2)) sgn(w) - b w - D w |w|",
    source: "Coulomb, viscous and Stribeck terms (B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, A survey of models, analysis \
             tools and compensation methods for the control of machines with friction, Automatica 30, 1994, section 2); drag of turbulent \
             air with the square of the speed",
    twin: "shaft",
    parameters: &[
        Quantity::new(
            "coulomb_n_m",
            "N m",
            RANGE,
            "Fc, Coulomb friction, change against the twin",
        ),
        Quantity::new(
            "viscous_n_m_s",
            "N m s",
            RANGE,
            "b, viscous friction, change against the twin",
        ),
        Quantity::new(
            "drag_n_m_s2",
            "N m s^2",
            RANGE,
            "D, drag, change against the twin",
        ),
        Quantity::new(
            "stribeck_n_m",
            "N m",
            RANGE,
            "Fs, Stribeck friction, change against the twin",
        ),
        Quantity::new(
            "stribeck_rad_s",
            "rad/s",
            [1e-6, 1e6],
            "ws, speed over which it falls",
        ),
    ],
    locked_to: &[LockedTo::Speed],
    speed_exponent: None,
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[Mechanism::SpeedDrift, Mechanism::LoadStep],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A run-down from the highest speed to rest, load disconnected: friction gives the same deceleration at the same speed \
                   each time, a drift of the drive or a load step does not.",
};

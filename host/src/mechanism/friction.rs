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
use super::{Card, EdgeClasses, Handling, LockedTo, Mechanism, Quantity};
use crate::diagnose::basis::Basis;
use crate::diagnose::board::Board;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::mended::Mended;
use crate::diagnose::named::{Named, Numbers};
use crate::diagnose::response::braked;
use crate::diagnose::seen::Seen;
use crate::diagnose::shaft::ShaftLaw;

/// Changes go either way.
const RANGE: [f64; 2] = [-TORQUE_N_M, TORQUE_N_M];
/// Terms that are one number each.
const TERMS: [Basis; 3] = [Basis::Coulomb, Basis::Viscous, Basis::Drag];
/// Shares of the highest speed that Stribeck's speed is looked for at.
const STRIBECK_SHARES: [f64; 9] = [0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8];

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
    handling: Handling {
        makes: |basis| {
            matches!(
                basis,
                Basis::Coulomb | Basis::Viscous | Basis::Drag | Basis::Stribeck { .. }
            )
        },
        columns,
        proposed,
        instead_of: |found, _| match found.bases.first() {
            Some(Basis::Coulomb | Basis::Viscous | Basis::Drag) => TERMS.map(Hypothesis::by).into(),
            _ => Vec::new(),
        },
        values,
        text: |_| "the course of the run-down".to_owned(),
        mends,
        ..Handling::NONE
    },
};

/// Where any drive goes off.
fn proposed(board: &Board) -> Vec<Hypothesis> {
    let off = |law: &ShaftLaw| !law.driven(f64::MAX);
    if !board.benches.iter().any(|bench| off(&bench.law)) {
        return Vec::new();
    }
    let [low, high] = board.benches[0].seen.speed_range();
    let top = high.abs().max(low.abs());
    let stribeck = STRIBECK_SHARES.map(|share| Basis::Stribeck { rad_s: share * top });
    TERMS
        .into_iter()
        .chain(stribeck)
        .map(Hypothesis::by)
        .collect()
}

fn columns(basis: Basis, seen: &Seen, law: &ShaftLaw) -> Vec<Vec<f64>> {
    braked(seen, law, &|speed| match basis {
        Basis::Coulomb => speed.signum(),
        Basis::Viscous => speed,
        Basis::Drag => speed * speed.abs(),
        Basis::Stribeck { rad_s } => speed.signum() * (-(speed / rad_s).powi(2)).exp(),
        _ => 0.0,
    })
}

fn values(numbers: &Numbers<'_>) -> Named {
    let size = |name: &str| (name.to_owned(), Numbers::size(0));
    match numbers.basis() {
        Basis::Coulomb => vec![size("coulomb_n_m")],
        Basis::Viscous => vec![size("viscous_n_m_s")],
        Basis::Drag => vec![size("drag_n_m_s2")],
        Basis::Stribeck { rad_s } => vec![
            size("stribeck_n_m"),
            ("stribeck_rad_s".to_owned(), numbers.scaled(rad_s, 0)),
        ],
        _ => Named::new(),
    }
}

fn mends(mended: &mut Mended, basis: Basis, sizes: &[f64]) {
    let shaft = &mut mended.twin.shaft;
    match basis {
        Basis::Coulomb => shaft.coulomb_n_m = (shaft.coulomb_n_m + sizes[0]).max(0.0),
        Basis::Viscous => shaft.viscous_n_m_s = (shaft.viscous_n_m_s + sizes[0]).max(0.0),
        Basis::Drag => shaft.drag_n_m_s2 = (shaft.drag_n_m_s2 + sizes[0]).max(0.0),
        Basis::Stribeck { rad_s } => {
            shaft.stribeck_n_m = (shaft.stribeck_n_m + sizes[0]).max(0.0);
            shaft.stribeck_rad_s = rad_s;
        }
        _ => {}
    }
}

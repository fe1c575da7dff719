//! `torsional_resonance`: a lightly damped mode of two masses and a spring.
//!
//! A share s of the inertia J swings behind a spring; torque noise, or an order that passes by, excites it. The near side, where encoder
//! and drive are, answers a torque with the dynamic stiffness
//! `Z(w) / J = i w b - (1 - s) w^2 - s w^2 K / (K - s w^2), K = s (1 - s) ((2 pi f)^2 + 2 i zeta (2 pi f) w)`
//! against i w b - w^2 of a stiff shaft, so torque noise has a dip at f sqrt(1 - s) and a peak at f. It moves no edge in the mean, so it
//! is no pattern: `diagnose/noise/resonance.rs` fits the spectrum of what is left, `diagnose/noise/two_mass.rs` has the equation.
//! Simulated in `sim/spring.rs`.
//!
//! Source: two masses and a spring (J. P. Den Hartog, Mechanical Vibrations, 1956, ch. 3); P. Whittle's likelihood of a spectrum
//! (Arkiv foer Matematik 2, 1953).

use super::card::FREQUENCIES_HZ;
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "torsional resonance",
    physics: "A share of the inertia swings behind a spring, a coupling or a long shaft, with little damping. Torque noise, or an order \
              that passes by, excites it.",
    equation: "Z(w) / J = i w b - (1 - s) w^2 - s w^2 K / (K - s w^2), K = s (1 - s) ((2 pi f)^2 + 2 i zeta (2 pi f) w)",
    source: "two masses and a spring (J. P. Den Hartog, Mechanical Vibrations, 1956, ch. 3); P. Whittle's likelihood of a spectrum \
             (Arkiv foer Matematik 2, 1953)",
    twin: "torsional_resonance",
    parameters: &[
        Quantity::new(
            "f_hz",
            "Hz",
            FREQUENCIES_HZ,
            "f, of the free, undamped mode",
        ),
        Quantity::new(
            "damping_ratio",
            "1",
            [0.0, 1.0],
            "zeta, 1 is critical damping",
        ),
        Quantity::new(
            "inertia_share",
            "1",
            [1e-6, 0.999],
            "s, share of the inertia behind the spring",
        ),
        Quantity::new(
            "load_psd_n2_m2_s",
            "N^2 m^2 s",
            [0.0, 1e6],
            "density of the torque noise behind it",
        ),
    ],
    locked_to: &[LockedTo::FrequencyBand],
    speed_exponent: Some(0),
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[Mechanism::TorqueTone, Mechanism::StickSlip],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A slow ramp through the speeds at which an order meets the band: a resonance swells where they meet, a torque tone does \
                   not. One more with the load disconnected moves the band.",
};

//! `closed_loop`: a speed loop that chases the encoder's own errors.
//!
//! A loop that samples the speed of the last interval holds the measured speed, so the shaft swings by the errors of the disc below its
//! bandwidth, and the residual shows the loop in their place:
//! `J dw/dt = kp (w* - seen) + ki / f sum(w* - seen), held from sample to sample at f`
//! What it saw is in the recording, errors and stamps with it, so its push is known but for gains and rate, and linear in the gains:
//! `diagnose/motion/closed_loop.rs`, `diagnose/motion/sampled.rs`. It is another motion altogether and is put into the twin before
//! anything small is looked for. Simulated in `sim/drive.rs`.
//!
//! Source: direct method of closed-loop identification (L. Ljung, System Identification, 2nd ed., section 13.4).

use super::card::TORQUE_N_M;
use super::{Card, EdgeClasses, LockedTo, Mechanism, Quantity};

/// Its card.
pub const CARD: Card = Card {
    title: "speed loop that follows the encoder's own error",
    physics: "A speed loop holds the speed that the encoder shows, so the shaft swings by the encoder's own errors at all orders below \
              the loop's bandwidth.",
    equation: "J dw/dt = kp (w* - seen) + ki / f sum(w* - seen), held from sample to sample at f",
    source: "direct method of closed-loop identification (L. Ljung, System Identification, 2nd ed., section 13.4)",
    twin: "drive.speed_loop",
    parameters: &[
        Quantity::new("kp_n_m_s", "N m s", [0.0, TORQUE_N_M], "proportional gain"),
        Quantity::new("ki_n_m", "N m", [0.0, TORQUE_N_M], "integral gain"),
        Quantity::new("f_hz", "Hz", [1e-2, 1e6], "its sampling rate"),
    ],
    locked_to: &[LockedTo::Angle],
    speed_exponent: None,
    edge_classes: EdgeClasses::Alike,
    look_alikes: &[
        Mechanism::TorqueRipple,
        Mechanism::Eccentricity,
        Mechanism::DiscTilt,
        Mechanism::LineError,
    ],
    same_mark: &[],
    told_by_rig: &[],
    separated_by: "A recording in torque or voltage mode, or with another bandwidth of the loop: what the loop makes goes or moves with \
                   its bandwidth, errors of the disc stay.",
};

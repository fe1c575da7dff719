//! Blind cases for the diagnosis: rigs, effects and an integrator that share no code with the side that diagnoses.
//!
//! The equation of motion is J dw/dt = drive - friction(w) + torques(theta, t) + noise(t). A Dormand-Prince step of order 5 with
//! a quintic as dense output integrates it between the instants at which something changes suddenly; edges are roots of the
//! quintic. What an effect does to angle, torque or capture is in `effect`; what size of it could be seen at all, in `ideal`.
#![forbid(unsafe_code)]
#![allow(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss
)]

pub mod capture;
pub mod draw;
pub mod effect;
pub mod encoder;
pub mod ideal;
pub mod motion;
pub mod pieces;
pub mod random;
pub mod rig;
pub mod step;
#[cfg(test)]
mod testing;
pub mod turning;
pub mod whiten;
pub mod write;

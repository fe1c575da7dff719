//! A recording under a live speed loop, turned into the one that a free-running shaft would have made.
//!
//! A speed loop holds the speed that it measures, the encoder's errors in it. So the shaft swings the other way at every order below
//! the loop's bandwidth, and the edges hide what the encoder does there. Yet the loop's torque is known: it was recorded, or it follows
//! from the edges and the gains ([`command`]). Its double integral over time is how far it moved the shaft ([`motion`]). With
//! theta(t) the shaft's angle and d(t) that displacement, theta - d is a shaft that no loop holds: but for torque noise and ripple it
//! moves as a free shaft does, f(t). So an edge captured at t, where the grid says theta + e, stands for d(t) + f(t) + e. Each time
//! becomes the one at which a shaft of constant acceleration, the nearest to the recording, has come as far as d(t) + f(t). That
//! is linear in d, so that torque locked to the shaft stays locked to it.
//!
//! What the start leaves open (speed, friction, what the integrator held) is in f and found by least squares ([`trend`]). Both parts
//! must be there: a loop that still settles at the start moves the shaft by d and f alike, and either alone would be scaled by the
//! wrong speed. Gains that are known within some ten percent only are measured on the recording itself ([`fit`]). What they
//! are off then repeats every turn; its size counts in the standard error of the table (`repeat`).
//!
//! Taken as given: the loop sees the very edges that were recorded, its sample clock and the capture timer are one, and each torque
//! acts from the sample that asks for it to the next.

pub mod command;
mod course;
pub mod crossing;
mod error;
pub mod fit;
pub mod hidden;
pub mod model;
pub mod motion;
pub mod phase;
mod push;
mod recover;
mod repeat;
mod rows;
#[cfg(test)]
mod tests;
pub mod torque;
pub mod trend;
mod whiten;

pub use crate::twin::Gains;
pub use error::FreeRunError;
pub use hidden::{HiddenOrders, hidden_orders};
pub use model::LoopModel;
pub use push::Push;
pub use recover::{FreeRun, Knowledge};
pub use rows::{FreeRows, rows};

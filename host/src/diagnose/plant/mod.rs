//! The shaft's law of motion about its course: what a torque does to the angle at each edge, and how noise spreads between edges.
//!
//! J dw/dt = drive + torques - friction, linear about the course: a small acceleration f makes dy/dt = v, dv/dt = -b v + f, with b the
//! slope of all friction and of the drive at the course's own speed. Torques are evaluated at the angles and times that the edges
//! give, so any size of them is exact to first order in the stamps' errors.

mod law;
mod leaps;
mod response;

pub use crate::effect::Here;
pub use law::{Hold, Law, Swing, sign};
pub use leaps::{Gains, Jolt, Leaps, free};
pub use response::{Motion, Plant};

//! Learning an encoder again in the field, by command.

mod figures;
mod options;
mod stage;

pub use figures::{Figures, Scatter};
pub use options::{Limits, Options, PROOF_TURNS_LEAST, SpeedWindow, TURNS_LEAST};
pub use stage::{Failure, Obstacle, Stage, Waiting, WriteFailure};

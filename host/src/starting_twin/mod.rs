//! A starting twin: what recordings alone say of a rig, each number with its interval, each guess marked as one.
//!
//! The sensor comes first, as nothing can be placed without it. Then the diagnosis' own filter, beside a twin that knows the sensor and
//! the clock only, gives the noise, the delays and the disc's pattern. The course of the speed is the recordings' own.
#![allow(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss
)]

mod delays;
mod disc;
mod estimate;
mod lines;
mod list;
mod noise;
mod rhythm;
mod sensor;
mod torques;
mod write;

use thiserror::Error;

use crate::diagnose::rig::DiagnoseError;
use crate::twin::TwinError;

pub use delays::ClassDelay;
pub use disc::DiscFound;
pub use estimate::{Placed, Starting, bare, estimate};
pub use lines::lines_of;
pub use list::errors_csv;
pub use rhythm::{Rhythm, find as rhythms};
pub use sensor::{Found, Given, SensorUnknown, Source, find};
pub use write::{Number, bare_text, numbers, text};

/// A number with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The likeliest.
    pub value: f64,
    /// Where it is with a probability of 95 %.
    pub ci95: [f64; 2],
}

/// Deviations of a normal number within which it is with a probability of 95 %.
const NORMAL_95: f64 = 1.96;

impl Estimate {
    /// Of a value with a normal error.
    #[must_use]
    pub fn normal(value: f64, error: f64) -> Self {
        Self {
            value,
            ci95: [value - NORMAL_95 * error, value + NORMAL_95 * error],
        }
    }

    /// Of a positive value whose logarithm has a normal error.
    #[must_use]
    pub fn of_log(value: f64, error: f64) -> Self {
        let by = (NORMAL_95 * error).exp();
        Self {
            value,
            ci95: [value / by, value * by],
        }
    }

    /// The same put through a rising function.
    #[must_use]
    pub fn map(self, through: impl Fn(f64) -> f64) -> Self {
        Self {
            value: through(self.value),
            ci95: self.ci95.map(through),
        }
    }
}

/// Why there is no starting twin.
#[derive(Debug, Error)]
pub enum StartingError {
    /// What is left can't be compared.
    #[error(transparent)]
    Diagnose(#[from] DiagnoseError),
    /// A twin that can't be.
    #[error(transparent)]
    Twin(#[from] TwinError),
}

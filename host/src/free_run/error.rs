//! Why a free run can't be found.

use thiserror::Error;

use crate::recording::ReadError;
use crate::sensor::PlanError;

/// Why a free run can't be found.
#[derive(Debug, Error)]
pub enum FreeRunError {
    /// The recording can't be read.
    #[error(transparent)]
    Read(Box<ReadError>),
    /// The core can't take such an encoder.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The shaft does not get on.
    #[error(
        "the loop can't be undone: the recording holds no run in one direction; record three turns or more at one speed"
    )]
    NoRun,
    /// Too little to measure gains on.
    #[error(
        "the loop's gains can't be measured on less than three turns; record more, or take the gains as exact"
    )]
    TooShort,
}

impl From<ReadError> for FreeRunError {
    fn from(error: ReadError) -> Self {
        Self::Read(Box::new(error))
    }
}

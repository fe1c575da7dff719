//! What can go wrong in a trial.

use std::io;

use quadcal::recalibrate::{Failure, Stage};
use quadcal::wire::TableInfo;
use quadcal_host::device::DeviceError;
use quadcal_host::twin::TwinError;

use super::WAIT;
use crate::firmware::FirmwareError;

/// Why a trial came to nothing.
#[derive(Debug, thiserror::Error)]
pub enum TrialError {
    /// The image can't be built or started.
    #[error(transparent)]
    Firmware(#[from] FirmwareError),
    /// The encoder can't be simulated.
    #[error(transparent)]
    Twin(#[from] TwinError),
    /// The device refused, or does not answer.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// A file or socket failed.
    #[error("{what}: {source}")]
    Io {
        /// What was tried.
        what: &'static str,
        /// The system's reason.
        source: io::Error,
    },
    /// The image ended.
    #[error("the image ended; it said `{0}`")]
    Ended(String),
    /// The index was not seen.
    #[error("no index was seen in {limit} s", limit = WAIT.as_secs())]
    NoIndex,
    /// The shaft does not turn.
    #[error("the shaft stands still")]
    Standstill,
    /// A device with empty flash has a table.
    #[error("a table is in use before any was learned: {0:?}")]
    TableAlready(TableInfo),
    /// The calibration came to no table.
    #[error("the calibration failed: {0:?}")]
    Calibration(Failure),
    /// It did not come to its end.
    #[error("the calibration was still at stage {stage:?} after {limit} s", limit = WAIT.as_secs())]
    Stuck {
        /// Where it stands.
        stage: Stage,
    },
    /// What a calibration should leave is not there.
    #[error("the device has no {0}")]
    Missing(&'static str),
    /// After the reboot another table is in use, or none.
    #[error("{committed:?} was committed, but after the reboot {found:?} is in use")]
    Lost {
        /// The table committed.
        committed: TableInfo,
        /// The one found.
        found: Option<TableInfo>,
    },
}

/// Maps the system's reason.
pub(super) fn io(what: &'static str) -> impl FnOnce(io::Error) -> TrialError {
    move |source| TrialError::Io { what, source }
}

//! Failures from the errors of the library.

use std::path::Path;

use super::Failure;
use crate::calibrate::CalibrateError;
use crate::cli::output::Target;
use crate::device::{DeviceError, Fault};
use crate::locate::LocateError;
use crate::recording::ReadError;
use crate::recording::write::WriteError;
use crate::verify::VerifyError;

impl From<ReadError> for Failure {
    fn from(error: ReadError) -> Self {
        Self::Read(Box::new(error))
    }
}

impl From<DeviceError> for Failure {
    fn from(error: DeviceError) -> Self {
        Self::Device(Box::new(error))
    }
}

impl Failure {
    /// An error while a table was handed over.
    #[must_use]
    pub fn loading(table: &Path, error: DeviceError) -> Self {
        match error.fault {
            Fault::Mismatch(source) => Self::Load {
                table: table.to_owned(),
                source,
            },
            _ => error.into(),
        }
    }

    /// A calibration's error, on `recording` as `twin` declares it.
    #[must_use]
    pub fn calibrating(recording: &Path, twin: Option<&Path>, error: CalibrateError) -> Self {
        match error {
            CalibrateError::Read(error) => Self::Read(error),
            source => Self::Calibrate {
                recording: recording.to_owned(),
                twin: twin.map(Path::to_owned),
                source,
            },
        }
    }

    /// A check's error.
    #[must_use]
    pub fn verifying(recording: &Path, table: &Path, error: VerifyError) -> Self {
        match error {
            VerifyError::Read(error) => Self::Read(error),
            source => Self::Verify {
                recording: recording.to_owned(),
                table: table.to_owned(),
                source,
            },
        }
    }

    /// A search's error.
    #[must_use]
    pub fn locating(recording: &Path, table: &Path, source: LocateError) -> Self {
        Self::Locate {
            recording: recording.to_owned(),
            table: table.to_owned(),
            source,
        }
    }

    /// Sorts a writer's error into the system's part and the format's.
    #[must_use]
    pub fn writing(target: &Target, error: WriteError) -> Self {
        let target = target.clone();
        match error {
            WriteError::Io(source) => Self::Write { target, source },
            source => Self::Unwritable { target, source },
        }
    }
}

//! What comes of the command to commit a table: whether it goes through or not, the results so far are to be shown.

use quadcal::recalibrate::{Failure as Reason, Limits, Stage};
use quadcal::wire::TableInfo;

use crate::device::{DeviceError, Fault};

use super::super::failure::Failure;
use super::super::output::Facts;
use super::facts;
use super::line::AnyClient;

/// How long a table waits to be committed, minutes, where the firmware sets no other time.
pub(super) fn waits_min() -> u32 {
    Limits::default().commit_ms / 60_000
}

/// How a table that waits is called for.
pub(super) fn waits_text() -> String {
    format!(
        "the new table waits, {} min; 'quadcal device commit' makes it count, 'abort' gives it up",
        waits_min()
    )
}

/// What became of the table.
pub(super) enum Committed {
    /// In flash and in use, as the device describes it.
    InFlash(Option<TableInfo>),
    /// Held back; it still waits.
    Waits(DeviceError),
    /// Not written, and gone.
    Failed(Option<Reason>, DeviceError),
    /// The device did not say.
    Unknown(DeviceError),
}

/// Commits the table that waits.
pub(super) fn commit(client: &mut AnyClient) -> Committed {
    let error = match client.commit() {
        Ok(table) => return Committed::InFlash(table),
        Err(error) => error,
    };
    if let Fault::Failed(reason) = error.fault {
        return Committed::Failed(Some(reason), error);
    }
    match client.status().map(|status| status.stage) {
        Ok(Stage::ReadyToCommit) => Committed::Waits(error),
        Ok(Stage::Failed(reason)) => Committed::Failed(Some(reason), error),
        Ok(Stage::Idle) => Committed::Failed(None, error),
        _ => Committed::Unknown(error),
    }
}

impl Committed {
    /// Its name in JSON.
    pub const fn outcome(&self) -> &'static str {
        match self {
            Self::InFlash(_) => "committed",
            Self::Waits(_) => "waiting",
            Self::Failed(..) => "failed",
            Self::Unknown(_) => "unknown",
        }
    }

    /// The table in use, where it is this one.
    pub const fn table(&self) -> Option<&TableInfo> {
        match self {
            Self::InFlash(table) => table.as_ref(),
            _ => None,
        }
    }

    /// Why it came to nothing.
    pub const fn reason(&self) -> Option<&Reason> {
        match self {
            Self::Failed(reason, _) => reason.as_ref(),
            _ => None,
        }
    }

    /// Says it in words.
    pub fn describe(&self, facts: &mut Facts) {
        match self {
            Self::InFlash(table) => {
                facts.push("Outcome", "the new table is in flash and in use");
                facts::table(facts, table.as_ref());
            }
            Self::Waits(_) => {
                facts.push("Outcome", waits_text());
            }
            Self::Failed(..) => {
                facts.push("Outcome", "the new table is not in flash, and gone");
            }
            Self::Unknown(_) => {
                let text = "not known; 'quadcal device status' says whether the table is in use";
                facts.push("Outcome", text);
            }
        }
    }

    /// How the command ends.
    ///
    /// # Errors
    /// Why the table is not in flash.
    pub fn end(self) -> Result<(), Failure> {
        match self {
            Self::InFlash(_) => Ok(()),
            Self::Waits(error) => Err(Failure::Waits {
                source: Box::new(error),
                minutes: waits_min(),
            }),
            Self::Failed(_, error) | Self::Unknown(error) => Err(error.into()),
        }
    }
}

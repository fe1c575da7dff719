//! A fresh table at work on its own recording, for a report to show.

use quadcal::slot::{Slot, SlotError};
use quadcal::table::TableError;

use crate::calibrate::{Calibration, RecordingUse};
use crate::recording::{ReadError, Row};
use crate::table_file;
use crate::verify::{Verdict, Verification, VerifyError, verify};

/// What a table does, and on which turns.
#[derive(Clone, Debug)]
pub struct Showcase {
    /// Scatter and speeds, before and after.
    pub check: Verification,
    /// Whether the turns are later ones than those learned from. If not, there were no later ones, and the table looks a little
    /// better than it is.
    pub later: bool,
}

impl Showcase {
    /// Whether the table does harm on later turns: they run at speeds for which it does not hold.
    #[must_use]
    pub fn worse_later(&self) -> bool {
        self.later && self.check.verdict() == Verdict::Worse
    }
}

/// Runs a calibration's table over a recording that it came from: on the turns after those learned from, or on all if there are
/// none. `used` is what the recording gave; `open` may be called twice.
///
/// # Errors
/// [`VerifyError`] when the recording can't be read again or holds no whole turn.
pub fn showcase<I>(
    calibration: &Calibration,
    used: &RecordingUse,
    mut open: impl FnMut() -> Result<I, ReadError>,
) -> Result<Showcase, VerifyError>
where
    I: Iterator<Item = Result<Row, ReadError>>,
{
    // Any number but 0 tells the check that the recording is the one learned from.
    const SOURCE: u32 = 1;
    let mut check_after = |tick| {
        let mut header = calibration.slot_header(SOURCE);
        header.learned_until = tick;
        let bytes = table_file::bytes_with(calibration, &header);
        let slot = Slot::parse(&bytes).map_err(|error| {
            // Bytes just written fail at most in what the solution itself holds.
            VerifyError::Table(match error {
                SlotError::Table(error) => error,
                _ => TableError::Length(bytes.len()),
            })
        })?;
        let clock_hz = calibration.clock_hz;
        verify(&slot, calibration.plan, SOURCE, clock_hz, open()?, None)
    };
    let later = match check_after(used.learned_until) {
        Ok(check) => Some(check).filter(|check| check.check_whole_turn().is_ok()),
        Err(VerifyError::NothingLeft) => None,
        Err(error) => return Err(error),
    };
    Ok(match later {
        Some(check) => Showcase { check, later: true },
        None => Showcase {
            check: check_after(0)?,
            later: false,
        },
    })
}

//! A calibration on the device, followed from its start to its end.

use std::thread;
use std::time::{Duration, Instant};

use quadcal::recalibrate::{Failure, Figures, Options, PROOF_TURNS_LEAST, Stage};
use quadcal::wire::{Learned, Request, Status, TableInfo};

use super::client::Client;
use super::error::{DeviceError, Fault};
use super::port::Port;

/// Time between two looks at the status.
const LOOK: Duration = Duration::from_millis(100);

/// Time that a device may take to write flash; many chips halt and are silent meanwhile.
const WRITING: Duration = Duration::from_secs(30);

/// Longest time that fresh turns are waited for: five turns at 15 r/min.
const COMPARING: Duration = Duration::from_secs(20);

/// How often a table that was held back is committed again.
const HELD_BACK_MOST: u32 = 3;

/// What messages call the command to commit.
const COMMIT: &str = "commit";

/// Whether to go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Watching {
    /// Look again.
    GoOn,
    /// Abort the calibration.
    Stop,
}

/// How a calibration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Calibrated {
    /// A table waits to be committed.
    Waiting,
    /// No table came of it.
    Failed(Failure),
    /// It was stopped, and the device told to abort.
    Stopped,
}

/// What came of a calibration.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// How it ended.
    pub end: Calibrated,
    /// What was learned, if it came that far.
    pub learned: Option<Learned>,
    /// New table against old, if it came that far.
    pub figures: Option<Figures>,
}

impl<P: Port> Client<P> {
    /// Starts a calibration and follows it until a table waits to be committed or it has failed; `watch` sees every status.
    ///
    /// # Errors
    /// [`DeviceError`]. The calibration goes on where only the connection is gone.
    pub fn calibrate(
        &mut self,
        options: &Options,
        mut watch: impl FnMut(&Status) -> Watching,
    ) -> Result<Calibration, DeviceError> {
        self.calibrate_with(options, |_, status| Ok(watch(status)))
    }

    /// The same, where `watch` may ask the device more in between.
    ///
    /// # Errors
    /// [`DeviceError`], and what `watch` returns.
    pub fn calibrate_with(
        &mut self,
        options: &Options,
        mut watch: impl FnMut(&mut Self, &Status) -> Result<Watching, DeviceError>,
    ) -> Result<Calibration, DeviceError> {
        self.change("recalibrate", &Request::Start(*options))?;
        let end = loop {
            let status = self.status()?;
            let watching = watch(self, &status)?;
            match status.stage {
                Stage::ReadyToCommit => break Calibrated::Waiting,
                Stage::Failed(failure) => break Calibrated::Failed(failure),
                Stage::Idle | Stage::Committing | Stage::Done => {
                    return Err(self.fault(Fault::Gone));
                }
                _ => {}
            }
            if watching == Watching::Stop {
                self.change("abort", &Request::Abort)?;
                break Calibrated::Stopped;
            }
            thread::sleep(LOOK);
        };
        let ended = end != Calibrated::Stopped;
        Ok(Calibration {
            end,
            learned: if ended { self.result()? } else { None },
            figures: if ended { self.preview()? } else { None },
        })
    }

    /// What fresh turns say of the table that was handed over, against the one in use. While the shaft turns, waits for
    /// [`PROOF_TURNS_LEAST`] of them, 20 s at the longest; none where it stands still. `progress` sees turns done and turns in all.
    ///
    /// # Errors
    /// [`DeviceError`].
    pub fn compare(
        &mut self,
        mut progress: impl FnMut(u32, u32),
    ) -> Result<Option<Figures>, DeviceError> {
        let wanted = PROOF_TURNS_LEAST.into();
        let deadline = Instant::now() + COMPARING;
        loop {
            let figures = self.preview()?;
            let turns = figures.map_or(0, |figures| figures.turns);
            progress(turns.min(wanted), wanted);
            let enough = turns >= wanted || Instant::now() > deadline;
            if enough || self.live()?.speed_raw == 0 {
                return Ok(figures);
            }
            thread::sleep(LOOK);
        }
    }

    /// Commits the table that waits, and waits until it is in flash. What the device says of it then. Where a reply is lost, the
    /// status tells whether the command arrived.
    ///
    /// # Errors
    /// [`DeviceError`], [`Fault::Failed`] where it is not in flash; [`Fault::Refused`] where the interlock holds it back, and
    /// then it still waits.
    pub fn commit(&mut self) -> Result<Option<TableInfo>, DeviceError> {
        // Only if there was a table can its stage afterwards be known from that of another before.
        let waited = self.status()?.stage == Stage::ReadyToCommit;
        self.order_commit(waited)?;
        let mut held_back = 0;
        let deadline = Instant::now() + WRITING;
        loop {
            match self.status() {
                Ok(status) => match status.stage {
                    Stage::Committing if Instant::now() > deadline => {
                        let (what, wait) = (COMMIT, WRITING);
                        return Err(self.fault(Fault::Unanswered { what, wait }));
                    }
                    Stage::Committing => {}
                    // The interlock said no between command and writing: asked once more, it says why.
                    Stage::ReadyToCommit if held_back < HELD_BACK_MOST => {
                        held_back += 1;
                        self.order_commit(waited)?;
                    }
                    Stage::ReadyToCommit => return Err(self.fault(Fault::HeldBack)),
                    Stage::Failed(failure) => return Err(self.fault(Fault::Failed(failure))),
                    Stage::Done => return Ok(status.table),
                    _ => return Err(self.fault(Fault::Gone)),
                },
                Err(error) => {
                    let silent = matches!(error.fault, Fault::Silent { .. });
                    if !silent || Instant::now() > deadline {
                        return Err(error);
                    }
                }
            }
            thread::sleep(LOOK);
        }
    }

    /// Sends the command to commit. That its reply is lost is no error where the status can tell what came of it.
    fn order_commit(&mut self, status_tells: bool) -> Result<(), DeviceError> {
        match self.change(COMMIT, &Request::Commit) {
            Err(error) if status_tells && matches!(error.fault, Fault::Unanswered { .. }) => Ok(()),
            done => done.map(|_| ()),
        }
    }
}

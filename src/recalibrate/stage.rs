//! Where a calibration stands, and what can be wrong with it.

use serde::{Deserialize, Serialize};

/// A state of the machine; the [module's](super) head draws them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Stage {
    /// Nothing to do.
    #[default]
    Idle,
    /// Started; the shaft stands still.
    WaitingForMotion,
    /// The shaft turns; its speed has to stay in the window for a while.
    CheckingSpeed,
    /// Turns are learned from.
    Learning,
    /// The table is worked out.
    Solving,
    /// The table is held against the one in use, on turns that it was not learned from.
    Proving,
    /// A table waits for the command to commit it.
    ReadyToCommit,
    /// The table is written to flash.
    Committing,
    /// The table is in flash and in use.
    Done,
    /// No table came of it; the one from before is in use.
    Failed(Failure),
}

/// Why a calibration came to nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Failure {
    /// What was waited for did not come in time.
    TimedOut(Waiting),
    /// The interlock no longer allows it.
    Interlock(Obstacle),
    /// Too few turns for a table; how many there were.
    TooFewTurns(u32),
    /// On fresh turns the new table is not better than the one in use; the preview has the figures.
    NotBetter,
    /// The table is not in flash.
    NotWritten(WriteFailure),
}

/// What was waited for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Waiting {
    /// The shaft to turn.
    Motion,
    /// A speed within the window.
    Speed,
    /// A turn that can be learned from.
    Turn,
    /// The solver.
    Solver,
    /// A fresh turn to prove the table on.
    Proof,
    /// The command to commit.
    Commit,
    /// The table, counted from the start to where it is solved for.
    Table,
}

/// Why the firmware does not allow it now.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Obstacle {
    /// The shaft turns.
    Moving,
    /// The drive is not enabled.
    Disabled,
    /// The drive has a fault.
    Fault,
    /// The supply is too low for the flash, or not sure to stay.
    Supply,
    /// Too hot or too cold.
    Temperature,
    /// The machine is at work.
    Working,
    /// A reason of the firmware's own.
    Other(u8),
}

/// Why a table is not in flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum WriteFailure {
    /// The flash failed.
    Flash,
    /// It does not fit its place.
    TooLong,
    /// Its place was erased as often as it may be.
    WornOut,
    /// What was written does not read back.
    Verify,
    /// There is no table to write.
    Missing,
}

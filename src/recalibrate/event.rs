//! What comes into the machine and what comes out.

use super::{Figures, Obstacle, Options, Stage, WriteFailure};
use crate::estimate::Advice;

/// Work on a table that is done in slices of bounded length, so that edges are served in between.
pub trait SolveInSlices {
    /// Does one slice. After the last one it says the same again, without work.
    fn slice(&mut self) -> Solving;
}

/// How far a table is solved for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Solving {
    /// There is more to do; how much is done, per cent.
    Working(u8),
    /// The table is there.
    Solved,
    /// There is none, from so many turns.
    TooFewTurns(u32),
}

/// How learning goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Taken {
    /// Turns taken since the calibration began.
    pub turns: u32,
    /// Whether more would help, when that was found out; it takes a while after a turn.
    pub advice: Option<Advice>,
}

/// What happens to a calibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Event {
    /// Command: begin.
    Start(Options),
    /// Command: end, or give up the table that waits. At rest, what the calibration before came to is forgotten: so too when the table in
    /// use was exchanged by hand.
    Abort,
    /// Command: write the table that waits.
    Commit,
    /// A whole table was handed over.
    Loaded,
    /// Time has passed.
    Tick,
    /// The shaft's speed either way, thousandths of a revolution a minute; 0: it stands still.
    Motion(u32),
    /// A turn was taken to learn from, or it was found out whether more help.
    Turn(Taken),
    /// The solver did a slice.
    Slice(Solving),
    /// A fresh turn was held against both tables.
    Proof(Figures),
    /// The table was not begun to be written: the interlock no longer allowed it when its turn came.
    HeldBack,
    /// The table was written, or not.
    Written(Result<(), WriteFailure>),
}

/// Which table waits to be committed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Candidate {
    /// The one that was learned.
    Learned,
    /// The one that was handed over.
    Loaded,
}

/// What the machine's owner has to do next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Action {
    /// Forget what was learned and get ready to learn, but don't yet.
    Prepare(Options),
    /// Learn from the edges that come.
    Learn,
    /// Stop learning; what was learned stays.
    Hold,
    /// Stop learning, and from now on solve slice by slice.
    Solve,
    /// Hold the new table against the one in use.
    Prove,
    /// The table that was handed over waits; hold it against the one in use, on the turns that come.
    Compare,
    /// The new table waits: hold it, and do nothing with edges.
    Keep,
    /// Write this table to flash and use it; [`Event::Written`] says how it went.
    Write(Candidate),
    /// Give up what was learned or handed over.
    Release,
}

/// Why a command is not followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refused {
    /// Not in this stage.
    Stage(Stage),
    /// The firmware does not allow it now.
    Interlock(Obstacle),
    /// No speed is both in the window asked for and in the device's.
    Window,
}

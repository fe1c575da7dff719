//! Learns the encoder's own errors from intervals, turn by turn (rotation-domain averaging, eq. (20), on intervals).
//!
//! Each interval is scaled by the duration of the turn before, so that a perfect encoder on a steady shaft gives exactly
//! one step (`1 << STEP_FRACTION_BITS`) an edge. The deviation is kept for one turn; a turn that turns out whole is then
//! folded, one entry an edge while the next turn comes in, into
//!
//! - `sum`: the sum over turns, which holds the encoder's error, and
//! - a *contrast*: the same turns with signs that cancel whatever repeats. What is left there is what the estimate does
//!   not know, and [`solve`] weighs every order by it.
//!
//! A turn is closed over exactly one revolution, so its mean speed is free of encoder error, and its curvature (a steady
//! acceleration) follows from the durations of its neighbours. Both are scalars a turn; they are taken out in the end.
//!
//! Work an edge is constant, without division or search; the library's head has what it costs.

mod buffers;
mod close;
mod fold;
mod learn;
mod lockstep;
mod modulation;
mod order;
mod power;
mod ripple;
mod scale;
mod solution;
mod solve;
mod spectrum;
mod turn;
mod weigh;

#[cfg(test)]
mod tests;

pub use buffers::{EdgeBuffers, StaticBuffers};
pub use order::{LockedOrder, ORDERS_MAX};
pub use solution::{Solution, SolveError};

use crate::edge::Direction;
use crate::shape::{EncoderShape, ShapeError};
use crate::step::Flags;
use fold::Fold;
use lockstep::Lockstep;
use turn::{Turn, TurnRate};

/// Flags of a step that make its interval or its place in the turn uncertain.
const BROKEN: Flags = Flags::TURN_SUSPECT
    .with(Flags::ILLEGAL)
    .with(Flags::ABRUPT)
    .with(Flags::SPIKE);

/// Turns at the most, so that no sum can overflow.
pub const TURNS_MAX: u32 = 1 << 15;

/// Where edge 0 is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Anchor {
    /// At the index or a wheel's gap: nothing is learned before it is seen.
    Index,
    /// Where counting began: the sensor has no index, and its table holds until power goes.
    FirstEdge,
}

/// Why a turn was not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Rejection {
    /// Edges missing, out of order or reported faulty, or the direction changed.
    Broken,
    /// An interval more than one step away from the grid, or of 2^32 ticks or more, or time that ran backward: the shaft
    /// stopped, or an edge is in the wrong place by a whole step.
    Irregular,
    /// The turn took more than an eighth longer or shorter than the one before.
    SpeedChange,
}

/// What an edge did to the estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Progress {
    /// Within a turn, or waiting for one to start.
    Running,
    /// A turn is whole and taken; the number taken so far.
    TurnTaken(u32),
    /// A turn is over and not used.
    TurnRejected(Rejection),
}

/// Counts over a calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Totals {
    /// Turns taken.
    pub turns: u32,
    /// Turns not used for broken edges.
    pub broken: u32,
    /// Turns not used for irregular intervals.
    pub irregular: u32,
    /// Turns not used for a change of speed.
    pub speed_change: u32,
    /// Shortest turn taken, ticks.
    pub shortest: u64,
    /// Longest turn taken, ticks.
    pub longest: u64,
    sign_sum: i32,
    excess: i64,
    bend: i64,
    bend_contrast: i64,
}

/// Learns eps, xi and p of one encoder; see the module's head.
pub struct Estimator<B> {
    lockstep: Lockstep,
    shape: EncoderShape,
    anchor: Anchor,
    inverse_edges_q32: u32,
    buffers: B,
    totals: Totals,
    turn: Option<Turn>,
    rate: Option<TurnRate>,
    duration_before: Option<u64>,
    unbent: Option<Unbent>,
    fold: Fold,
}

/// A turn that is taken but whose curvature waits for the duration of the next.
#[derive(Clone, Copy)]
struct Unbent {
    rate: TurnRate,
    duration: u64,
    duration_before: Option<u64>,
    direction: Direction,
    sign: i32,
}

impl<B: EdgeBuffers> Estimator<B> {
    /// An estimator with nothing learned; clears the buffers.
    ///
    /// # Errors
    /// [`ShapeError::Buffers`] when the buffers don't hold exactly N edges.
    pub fn new(shape: EncoderShape, anchor: Anchor, mut buffers: B) -> Result<Self, ShapeError> {
        let length = shape.edges() as usize;
        if buffers.sum().len() != length || buffers.work().len() != length {
            return Err(ShapeError::Buffers(buffers.edges()));
        }
        buffers.sum().fill(0);
        buffers.work().fill([0; 2]);
        Ok(Self {
            lockstep: Lockstep::NONE,
            shape,
            anchor,
            inverse_edges_q32: u32::MAX / shape.edges(),
            buffers,
            totals: Totals::default(),
            turn: None,
            rate: None,
            duration_before: None,
            unbent: None,
            fold: Fold::idle(),
        })
    }

    /// The encoder's shape.
    #[must_use]
    pub fn shape(&self) -> EncoderShape {
        self.shape
    }

    /// Turns taken and rejected so far.
    #[must_use]
    pub fn totals(&self) -> &Totals {
        &self.totals
    }
}

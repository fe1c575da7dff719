//! Learns the encoder's own errors from intervals, turn by turn (rotation-domain averaging, eq. (20), on intervals).
//!
//! Each interval is scaled by the duration of the turn before, so that a perfect encoder on a steady shaft gives exactly
//! one step (`1 << STEP_FRACTION_BITS`) an edge. The deviation is kept for one turn; a turn that turns out whole is then
//! folded, one entry an edge while the next turn comes in: a motion of constant acceleration through its ends, which hold
//! no encoder error, turns time into angle, and the rest goes into
//!
//! - a sum over turns, weighed by the square of their speed, which holds the encoder's error;
//! - a coarse sum with all turns alike: geometry is the same in both, locked torque is not, so the two tell them apart;
//! - a coarse *contrast* of either sum: the same turns with signs that cancel whatever repeats. What is left there is what
//!   the estimate does not know, and [`Estimator::solve`] weighs every order by it.
//!
//! What friction and drag make of the motion beyond that is told by two crossings more, and taken out of both means.
//!
//! Work an edge is constant, without division or search; the library's head has what it costs.

mod agree;
mod buffers;
mod close;
mod contrast;
mod course;
mod cursor;
mod damped;
mod damping;
mod decimate;
mod delays;
mod draw;
mod drift;
mod fold;
mod learn;
mod locked;
mod lockstep;
mod lookout;
mod low;
mod moments;
mod noise;
mod order;
mod outlook;
mod pack;
mod power;
mod ripple;
mod scale;
mod separate;
mod settle;
mod sizes;
mod smooth;
mod solution;
mod solve;
mod solver;
mod spectrum;
mod speeds;
mod split;
mod transform;
mod turn;
mod weigh;

#[cfg(test)]
mod tests;

pub use buffers::{BLOCKS, EdgeBuffers, Parts, StaticBuffers, block_edges, blocks_for};
pub use lookout::Lookout;
pub use order::{LockedOrder, ORDERS_MAX, TorqueOrder};
pub use outlook::{Advice, Goal, Outlook};
pub use solution::{ClassDelays, Findings, Solution, SolveError};
pub use solve::Slice;
pub use solver::Solver;

use crate::shape::{EncoderShape, ShapeError};
use crate::step::Flags;
use agree::Agreement;
use course::Course;
use damped::Damped;
use delays::Delays;
use drift::Drift;
use fold::{Fold, FoldShape};
use learn::WholeTurn;
use lockstep::Lockstep;
use low::LowOrders;
use speeds::{Place, Speeds, Weighing};
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
    /// The turn took more than a third longer or shorter than the one before, or the one before is not known and it was not
    /// steady, or its speed is more than 90 times off that of the first turn.
    SpeedChange,
    /// Its slow motion differs far more from that of the turn taken last than turns at this speed do: a load step, a shock. Of
    /// turns that go on like that the fourth is taken if it is like the third, the ninth in any case: so the shaft runs now.
    Disagrees,
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
    /// Turns not used because they disagree with the others.
    pub disagrees: u32,
    /// Shortest turn taken, ticks.
    pub shortest: u64,
    /// Longest turn taken, ticks.
    pub longest: u64,
}

impl Totals {
    /// Whether the turns' speeds differ enough to tell torque, whose angle goes with 1 / speed^2, from geometry: one took longer
    /// than another by a quarter. How well that tells goes into every order's doubt.
    #[must_use]
    pub fn two_speeds(&self) -> bool {
        self.longest >= self.shortest.saturating_add(self.shortest / 4)
    }

    fn take(&mut self, duration: u64) {
        self.shortest = if self.turns == 0 {
            duration
        } else {
            self.shortest.min(duration)
        };
        self.longest = self.longest.max(duration);
        self.turns += 1;
    }

    fn reject(&mut self, rejection: Rejection) {
        let count = match rejection {
            Rejection::Broken => &mut self.broken,
            Rejection::Irregular => &mut self.irregular,
            Rejection::SpeedChange => &mut self.speed_change,
            Rejection::Disagrees => &mut self.disagrees,
        };
        *count += 1;
    }
}

/// What is known of the drive that turns the shaft while it is learned from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DriveKnowledge {
    /// Torque locked to the shaft is at multiples of this order only, as of a motor's pole pairs with nothing else on the
    /// shaft; 0: any order may be torque. At one speed this decides what is left alone.
    pub torque_base: u16,
    /// Orders up to this one are left alone: a speed loop may hide them.
    pub hidden_up_to: u16,
}

/// Learns eps, xi and p of one encoder; see the module's head.
pub struct Estimator<B> {
    lockstep: Lockstep,
    shape: EncoderShape,
    anchor: Anchor,
    knowledge: DriveKnowledge,
    inverse_edges_q32: u32,
    buffers: B,
    totals: Totals,
    turn: Option<Turn>,
    rate: Option<TurnRate>,
    before: Option<WholeTurn>,
    agreement: Agreement,
    low: LowOrders,
    fold: Fold,
    folding: Option<Place>,
    speeds: Speeds,
    weighing: Weighing,
    delays: Delays,
    drift: Drift,
    course: Course,
    damped: Damped,
}

impl<B: EdgeBuffers> Estimator<B> {
    /// An estimator with nothing learned; clears the buffers.
    ///
    /// # Errors
    /// [`ShapeError::Buffers`] when the buffers don't hold exactly N edges, or too few blocks for them ([`blocks_for`]).
    pub fn new(shape: EncoderShape, anchor: Anchor, mut buffers: B) -> Result<Self, ShapeError> {
        let length = shape.edges() as usize;
        let parts = buffers.parts();
        let whole = parts.sum.len() == length && parts.cells.len() == length;
        let block = block_edges(length, parts.coarse.len() / 3).filter(|_| whole);
        parts.sum.fill(0);
        parts.cells.fill(0);
        parts.coarse.fill(0);
        let block = block.ok_or(ShapeError::Buffers(buffers.edges()))?;
        #[allow(clippy::cast_possible_truncation)]
        let fold = FoldShape::new(shape.edges(), shape.classes(), block as u32);
        Ok(Self {
            lockstep: Lockstep::NONE,
            shape,
            anchor,
            knowledge: DriveKnowledge::default(),
            inverse_edges_q32: u32::MAX / shape.edges(),
            buffers,
            totals: Totals::default(),
            turn: None,
            rate: None,
            before: None,
            agreement: Agreement::NONE,
            low: LowOrders::new(length, length / block),
            fold: Fold::idle(fold),
            folding: None,
            speeds: Speeds::NONE,
            weighing: Weighing::NEW,
            delays: Delays::NONE,
            drift: Drift::NONE,
            course: Course::NONE,
            damped: Damped::NONE,
        })
    }

    /// The same with what is known of the drive.
    #[must_use]
    pub fn with_knowledge(self, knowledge: DriveKnowledge) -> Self {
        Self { knowledge, ..self }
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

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
mod lockstep;
mod order;
mod power;
mod ripple;
mod scale;
mod solution;
mod solve;
mod spectrum;
mod turn;
mod weigh;

pub use buffers::{EdgeBuffers, StaticBuffers};
pub use order::{LockedOrder, ORDERS_MAX};
pub use solution::{Solution, SolveError};

use crate::edge::Direction;
use crate::shape::{EncoderShape, ShapeError};
use crate::step::{Flags, Outcome, Step};
use crate::units::{STEP_FRACTION_BITS, Ticks};
use fold::{Fold, sign_of_turn};
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

    /// Takes what a decoder made of a sample. On the edge path: constant work.
    #[inline]
    pub fn push(&mut self, outcome: &Outcome) -> Progress {
        match outcome {
            Outcome::Step(step) if self.lockstep.take(step, &mut self.buffers) => Progress::Running,
            _ => self.push_watchful(outcome),
        }
    }

    /// Whatever is not a step in the midst of a turn while the one before is folded.
    #[cold]
    #[inline(never)]
    fn push_watchful(&mut self, outcome: &Outcome) -> Progress {
        self.leave_lockstep();
        let progress = self.take(outcome);
        if let Some(turn) = &self.turn {
            self.lockstep = Lockstep::enter(turn, &self.fold, self.shape.edges());
        }
        #[cfg(feature = "defmt")]
        if progress != Progress::Running {
            defmt::debug!("{}", progress);
        }
        progress
    }

    /// Brings turn and fold up to date.
    fn leave_lockstep(&mut self) {
        if let Some(turn) = &mut self.turn {
            self.lockstep
                .leave(turn, &mut self.fold, self.shape.edges());
        }
    }

    fn take(&mut self, outcome: &Outcome) -> Progress {
        match outcome {
            Outcome::Idle => Progress::Running,
            Outcome::Step(step) => self.push_step(step),
            Outcome::Index(index) => {
                let agrees = index.resync == 0 && !index.flags.contains(Flags::TURN_SUSPECT);
                if agrees {
                    Progress::Running
                } else {
                    self.fault()
                }
            }
            Outcome::Glitch(_) => self.fault(),
        }
    }

    fn push_step(&mut self, step: &Step) -> Progress {
        for _ in 0..step.advance {
            self.fold.step(&mut self.buffers, self.shape.edges());
        }
        // A doubt that the index at this very step raises is about the turn that ends here.
        let ends_doubt =
            step.flags.contains(Flags::TURN_SUSPECT.with(Flags::INDEX)) || step.resync != 0;
        let broken = step.flags.intersects(BROKEN) && !ends_doubt;
        let mut progress = Progress::Running;
        if broken || ends_doubt {
            progress = self.fault();
        } else if let Some(turn) = &mut self.turn {
            match turn.extend(step, self.shape.edges(), &mut self.buffers) {
                Ok(false) => return Progress::Running,
                Ok(true) => progress = self.close(step.ticks),
                Err(rejection) => progress = self.reject(rejection),
            }
        }
        let anchored = self.anchor == Anchor::FirstEdge || step.flags.contains(Flags::REFERENCED);
        let room = self.totals.turns < TURNS_MAX;
        if step.edge == 0 && self.turn.is_none() && anchored && room && !broken {
            self.open(step);
        }
        progress
    }

    /// Gives up the present turn.
    fn fault(&mut self) -> Progress {
        if self.turn.is_some() {
            self.reject(Rejection::Broken)
        } else {
            Progress::Running
        }
    }

    /// Starts a turn at edge 0, unless an earlier turn still waits to be folded out of the cells this one needs.
    fn open(&mut self, step: &Step) {
        if self.fold.is_idle() || self.fold.follows(step.direction) {
            let dither = self.totals.turns.wrapping_mul(2_654_435_769);
            self.turn = Some(Turn::start(step, self.rate, dither));
        }
    }

    fn reject(&mut self, rejection: Rejection) -> Progress {
        match rejection {
            Rejection::Broken => self.totals.broken += 1,
            Rejection::Irregular => self.totals.irregular += 1,
            Rejection::SpeedChange => self.totals.speed_change += 1,
        }
        self.turn = None;
        self.duration_before = None;
        self.settle_bend(None);
        Progress::TurnRejected(rejection)
    }

    fn close(&mut self, now: Ticks) -> Progress {
        let Some(turn) = self.turn.take() else {
            return Progress::Running;
        };
        let duration = turn.duration(now);
        let previous_rate = self.rate;
        self.rate = TurnRate::of(duration, self.shape.edges());
        self.settle_bend(Some(duration));
        let duration_before = self.duration_before.replace(duration);
        let Some(rate) = previous_rate else {
            return Progress::Running;
        };
        let grid = i64::from(self.shape.edges()) << STEP_FRACTION_BITS;
        let excess = turn.length() - grid;
        if excess.abs() > grid >> 3 {
            self.totals.speed_change += 1;
            return Progress::TurnRejected(Rejection::SpeedChange);
        }
        let sign = sign_of_turn(self.totals.turns);
        let totals = &mut self.totals;
        totals.shortest = if totals.turns == 0 {
            duration
        } else {
            totals.shortest.min(duration)
        };
        totals.longest = totals.longest.max(duration);
        totals.turns += 1;
        totals.sign_sum += sign;
        totals.excess += excess;
        let slope = excess * i64::from(self.inverse_edges_q32);
        self.fold = Fold::of_turn(turn.direction(), sign, slope, self.shape.edges());
        self.unbent = Some(Unbent {
            rate,
            duration,
            duration_before,
            direction: turn.direction(),
            sign,
        });
        Progress::TurnTaken(self.totals.turns)
    }

    /// Adds the curvature of the turn taken last, from its neighbours' durations: over one turn, at s = 0..1, time runs as
    /// `T s - kappa s (1 - s)` with 2 kappa the change of duration a turn.
    fn settle_bend(&mut self, duration_after: Option<u64>) {
        let Some(turn) = self.unbent.take() else {
            return;
        };
        // A neighbour that took much longer or shorter is not the same motion.
        let change = |other: Option<u64>| {
            let change = other?.cast_signed() - turn.duration.cast_signed();
            (change.unsigned_abs() <= turn.duration >> 3).then_some(change)
        };
        let kappa = match (change(turn.duration_before), change(duration_after)) {
            (Some(before), Some(after)) => (after - before) >> 2,
            (Some(before), None) => -before >> 1,
            (None, Some(after)) => after >> 1,
            (None, None) => return,
        };
        let bend = turn.rate.scale(kappa) * i64::from(turn.direction.sign());
        self.totals.bend += bend;
        self.totals.bend_contrast += bend * i64::from(turn.sign);
    }
}

//! The estimator's edge path, and what it does at the ends of turns.

use super::fold::{Fold, sign_of_turn};
use super::lockstep::Lockstep;
use super::turn::{Turn, TurnRate};
use super::{Anchor, BROKEN, EdgeBuffers, Estimator, Progress, Rejection, TURNS_MAX, Unbent};
use crate::step::{Flags, Outcome, Step};
use crate::units::{STEP_FRACTION_BITS, Ticks};

impl<B: EdgeBuffers> Estimator<B> {
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
    pub(super) fn leave_lockstep(&mut self) {
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
    pub(super) fn settle_bend(&mut self, duration_after: Option<u64>) {
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

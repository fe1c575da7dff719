//! The estimator's edge path, and what it does at the ends of turns.

use super::agree::Seen;
use super::course::fall_q32;
use super::fold::{Motion, TurnScale};
use super::lockstep::Lockstep;
use super::speeds::Place;
use super::turn::{Turn, TurnRate};
use super::{Anchor, BROKEN, EdgeBuffers, Estimator, Progress, Rejection, TURNS_MAX};
use crate::edge::Direction;
use crate::step::{Flags, Outcome, Step};
use crate::units::{STEP_FRACTION_BITS, Ticks};

/// A turn that is known in all its edges.
#[derive(Clone, Copy)]
pub(super) struct WholeTurn {
    duration: u64,
    /// Whether it was taken, so that it moved as smoothly as others.
    taken: bool,
}

impl<B: EdgeBuffers> Estimator<B> {
    /// Takes what a decoder made of a sample. On the edge path: constant work.
    #[inline]
    pub fn push(&mut self, outcome: &Outcome) -> Progress {
        if let Outcome::Step(step) = outcome
            && self.lockstep.take(
                step,
                &mut self.fold,
                &mut self.low,
                &mut self.buffers.parts(),
            )
        {
            return Progress::Running;
        }
        self.push_watchful(outcome)
    }

    /// Ends a recording: the present turn is given up, and what comes next may have another speed, timer or direction.
    /// Folds what waits: as long as a turn takes to learn.
    pub fn interrupt(&mut self) {
        self.lose_track();
        self.fold.finish(&mut self.buffers.parts());
        self.settle_fold();
    }

    /// Edges will be missing: the present turn is given up, and what comes next may have another speed or direction. Constant work.
    pub fn lose_track(&mut self) {
        self.leave_lockstep();
        self.turn = None;
        self.rate = None;
        self.before = None;
        self.break_row();
        self.agreement.interrupt();
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
        let mut parts = self.buffers.parts();
        for _ in 0..step.advance {
            self.fold.step(&mut parts);
        }
        // A doubt that the index at this very step raises is about the turn that ends here.
        let ends_doubt =
            step.flags.contains(Flags::TURN_SUSPECT.with(Flags::INDEX)) || step.resync != 0;
        let broken = step.flags.intersects(BROKEN) && !ends_doubt;
        let mut progress = Progress::Running;
        if broken || ends_doubt {
            progress = self.fault();
        } else if let Some(turn) = &mut self.turn {
            match turn.extend(step, self.shape.edges(), parts.cells, &mut self.low) {
                Ok(false) => return Progress::Running,
                Ok(true) => progress = self.close(step.ticks),
                Err(rejection) => {
                    // A whole turn at quite another speed still says what that speed is.
                    let whole = rejection == Rejection::Irregular && step.edge == 0;
                    let duration = turn.duration(step.ticks);
                    progress = self.reject(rejection);
                    if whole {
                        self.rate = TurnRate::of(duration, self.shape.edges());
                    }
                }
            }
        }
        let anchored = self.anchor == Anchor::FirstEdge || step.flags.contains(Flags::REFERENCED);
        let room = self.totals.turns < TURNS_MAX;
        if step.edge == 0 && self.turn.is_none() && anchored && room && !broken {
            self.open(step);
        }
        progress
    }

    /// No turn follows on the one taken last.
    fn break_row(&mut self) {
        self.drift.interrupt();
        self.course.end(&self.weighing);
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
            self.low.start();
            self.turn = Some(Turn::start(step, self.rate, dither, self.fold.shape.block));
        }
    }

    fn reject(&mut self, rejection: Rejection) -> Progress {
        self.totals.reject(rejection);
        self.break_row();
        self.turn = None;
        self.before = None;
        Progress::TurnRejected(rejection)
    }

    fn close(&mut self, now: Ticks) -> Progress {
        self.settle_fold();
        let Some(turn) = self.turn.take() else {
            return Progress::Running;
        };
        let duration = turn.duration(now);
        let measured = turn.rate.is_some();
        self.rate = TurnRate::of(duration, self.shape.edges());
        let before = self.before.replace(WholeTurn {
            duration,
            taken: false,
        });
        if !measured {
            return Progress::Running;
        }
        let grid = self.shape.edges() << STEP_FRACTION_BITS;
        let excess = i64::from(turn.whole()) - i64::from(grid);
        // Without a turn just before, only a turn as long as the rate says is known to have been steady.
        let limit = if before.is_some() {
            grid / 3
        } else {
            grid >> 5
        };
        let place = self.speeds.place(duration);
        let Some(place) = place.filter(|_| excess.unsigned_abs() <= limit.into()) else {
            self.totals.reject(Rejection::SpeedChange);
            self.break_row();
            return Progress::TurnRejected(Rejection::SpeedChange);
        };
        let linear = (excess * i64::from(self.inverse_edges_q32)) >> STEP_FRACTION_BITS;
        let (seen, bend_q32, agrees) = self.seen(duration, turn.direction, linear, place, before);
        if !agrees && self.agreement.reject(seen, &self.speeds) {
            self.totals.reject(Rejection::Disagrees);
            self.break_row();
            return Progress::TurnRejected(Rejection::Disagrees);
        }
        self.drift.take(place.bin, &seen.low);
        self.agreement.take(seen, agrees, &mut self.speeds);
        self.before = Some(WholeTurn {
            duration,
            taken: true,
        });
        if before.is_some_and(|before| before.taken)
            && let Some(bin) = self.speeds.bin(place)
        {
            bin.jitter = bin.jitter.saturating_add(turn.jitter.squares);
            bin.jitter_turns = bin.jitter_turns.saturating_add(1);
        }
        let plus = plus_in_contrast(self.totals.turns);
        self.speeds.count(place, plus);
        self.totals.take(duration);
        let motion = Motion {
            length: turn.whole(),
            bend_q32,
        };
        let along = before.map(|before| before.duration);
        let along = along.filter(|&before| bend_q32 == Motion::bend_q32(before, duration));
        let fall_q32 = fall_q32(place, bend_q32);
        self.damped
            .take(turn.direction, place.ratio_q32, &seen.low, fall_q32);
        let of_turn = (duration, turn.direction, place);
        self.course.take(of_turn, along, bend_q32, &self.weighing);
        let sum = self.weighing.add(place.bin);
        self.course.shift(sum.sum_down);
        let scale = TurnScale { sum, minus: !plus };
        self.fold.start(turn.direction, motion, scale);
        self.folding = Some(place);
        Progress::TurnTaken(self.totals.turns)
    }

    /// The turn as it compares with others, its bend, and whether it agrees. After a turn that was not taken the two durations
    /// need not tell how this one moves; then it may have been steady, if that is closer to the turn taken last.
    fn seen(
        &self,
        duration: u64,
        direction: Direction,
        linear: i64,
        place: Place,
        before: Option<WholeTurn>,
    ) -> (Seen, i32, bool) {
        let with_bend = |bend_q32| {
            let seen = Seen {
                duration,
                ratio_q32: place.ratio_q32,
                direction,
                bin: place.bin,
                low: self.low.finish(linear, bend_q32),
            };
            (seen, bend_q32, self.agreement.off(&seen, &self.speeds))
        };
        let smooth = before.map_or(0, |before| Motion::bend_q32(before.duration, duration));
        let mut best = with_bend(smooth);
        if before.is_some_and(|before| !before.taken) {
            let steady = with_bend(0);
            if steady.2.level < best.2.level {
                best = steady;
            }
        }
        let (seen, bend_q32, off) = best;
        (seen, bend_q32, !off.far)
    }

    /// Takes note of the classes of the turn that was folded.
    pub(super) fn settle_fold(&mut self) {
        if let Some(place) = self.folding.take_if(|_| self.fold.is_idle()) {
            let direction = self.fold.direction;
            self.delays
                .take(&self.fold.classes, place.ratio_q32, direction);
        }
    }
}

/// Sign of a turn in the contrast: the Thue-Morse sequence, which cancels a constant pattern in every pair and a steady
/// drift in every four.
fn plus_in_contrast(turn: u32) -> bool {
    turn.count_ones().is_multiple_of(2)
}

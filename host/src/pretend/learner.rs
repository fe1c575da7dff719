//! The core's estimator as a device's learner, on the heap, solved for in one slice.

use std::mem;

use quadcal::device::{Learner, Learning};
use quadcal::estimate::{
    Advice, Anchor, DriveKnowledge, Estimator, Goal, Progress, Solution, SolveError,
};
use quadcal::recalibrate::{SolveInSlices, Solving};
use quadcal::shape::EncoderShape;
use quadcal::slot::SlotHeader;
use quadcal::step::Outcome;

use crate::buffers::HeapBuffers;

enum State {
    Released,
    Learning(Box<Estimator<HeapBuffers>>),
    Solved(Box<Solution<HeapBuffers>>),
    TooFewTurns(u32),
}

/// Learns an encoder.
pub struct HeapLearner {
    shape: EncoderShape,
    clock_hz: u64,
    goal: Goal,
    learned_until: u64,
    state: State,
    room: Vec<i16>,
}

impl HeapLearner {
    /// Of an encoder whose edges are stamped by a clock.
    #[must_use]
    pub const fn new(shape: EncoderShape, clock_hz: u64) -> Self {
        Self {
            shape,
            clock_hz,
            goal: Goal { error: 0 },
            learned_until: 0,
            state: State::Released,
            room: Vec::new(),
        }
    }
}

impl SolveInSlices for HeapLearner {
    fn slice(&mut self) -> Solving {
        self.state = match mem::replace(&mut self.state, State::Released) {
            State::Learning(estimator) => match estimator.solve() {
                Ok(solution) => State::Solved(Box::new(solution)),
                Err(SolveError::TooFewTurns(turns)) => State::TooFewTurns(turns),
            },
            State::Released => State::TooFewTurns(0),
            state => state,
        };
        match self.state {
            State::TooFewTurns(turns) => Solving::TooFewTurns(turns),
            _ => Solving::Solved,
        }
    }
}

impl Learner for HeapLearner {
    fn prepare(&mut self, knowledge: DriveKnowledge, goal: Goal) {
        self.goal = goal;
        let buffers = HeapBuffers::new(self.shape.edges() as usize);
        self.state = match Estimator::new(self.shape, Anchor::Index, buffers) {
            Ok(estimator) => State::Learning(Box::new(estimator.with_knowledge(knowledge))),
            Err(_) => State::Released,
        };
    }

    fn push(&mut self, outcome: &Outcome) {
        if let State::Learning(estimator) = &mut self.state
            && let Progress::TurnTaken(_) = estimator.push(outcome)
            && let Outcome::Step(step) = outcome
        {
            self.learned_until = step.ticks;
        }
    }

    fn interrupt(&mut self) {
        if let State::Learning(estimator) = &mut self.state {
            estimator.interrupt();
        }
    }

    fn learning(&mut self) -> Learning {
        let State::Learning(estimator) = &self.state else {
            return Learning {
                turns: 0,
                rejected: 0,
            };
        };
        let totals = estimator.totals();
        Learning {
            turns: totals.turns,
            rejected: totals.broken + totals.irregular + totals.speed_change + totals.disagrees,
        }
    }

    fn advice(&mut self) -> Option<Advice> {
        let State::Learning(estimator) = &mut self.state else {
            return None;
        };
        let outlook = estimator.outlook();
        outlook.map(|outlook| outlook.advice(self.goal))
    }

    fn header(&self) -> Option<SlotHeader> {
        match &self.state {
            State::Solved(solution) => {
                Some(SlotHeader::of(solution, self.learned_until, self.clock_hz))
            }
            _ => None,
        }
    }

    fn entries(&self) -> &[i16] {
        match &self.state {
            State::Solved(solution) => solution.entries(),
            _ => &[],
        }
    }

    fn room(&mut self) -> Option<&mut [i16]> {
        self.state = State::Released;
        self.room.resize(self.shape.edges() as usize, 0);
        Some(&mut self.room)
    }

    fn release(&mut self) {
        self.state = State::Released;
    }
}

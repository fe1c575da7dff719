//! The core's estimator as a device's learner.

use core::borrow::BorrowMut;
use core::mem;
use core::task::Poll;

use super::bench::{Learner, Learning};
use super::memory::LearnerMemory;
use crate::estimate::{
    Advice, Anchor, DriveKnowledge, EdgeBuffers, Estimator, Goal, Lookout, Progress, Slice,
    Solution, SolveError, Solver,
};
use crate::recalibrate::{SolveInSlices, Solving};
use crate::shape::EncoderShape;
use crate::slot::SlotHeader;
use crate::step::Outcome;
use crate::units::Ticks;

/// What its memory is used for.
#[allow(clippy::large_enum_variant)]
enum State<B> {
    /// Nothing: it is back where it came from.
    Released,
    /// The entries of a table that is handed over.
    Room(B),
    Learning(Estimator<B>),
    Solved(Solution<B>),
    TooFewTurns(u32),
}

/// Learns an encoder with an index. Takes its memory when there is something to learn or to put there, and gives it back afterwards.
/// `S` is a [`Solver`] by reference, or in a box where there is a heap.
pub struct EstimatorLearner<M: LearnerMemory, S> {
    shape: EncoderShape,
    clock_hz: u64,
    memory: M,
    goal: Goal,
    learned_until: Ticks,
    state: State<M::Buffers>,
    /// How good the table would be, while that is worked out, and the turns that it was last asked of.
    lookout: Option<Lookout>,
    seen: u32,
    solver: S,
}

impl<M: LearnerMemory, S: BorrowMut<Solver>> EstimatorLearner<M, S> {
    /// Of an encoder whose edges are stamped by a clock of so many hertz. Memory for another number of edges learns nothing.
    pub const fn new(shape: EncoderShape, clock_hz: u64, memory: M, solver: S) -> Self {
        Self {
            shape,
            clock_hz,
            memory,
            goal: Goal { error: 0 },
            learned_until: 0,
            state: State::Released,
            lookout: None,
            seen: 0,
            solver,
        }
    }
}

impl<M: LearnerMemory, S: BorrowMut<Solver>> SolveInSlices for EstimatorLearner<M, S> {
    fn slice(&mut self) -> Solving {
        let State::Learning(estimator) = &mut self.state else {
            return match self.state {
                State::Solved(_) => Solving::Solved,
                State::TooFewTurns(turns) => Solving::TooFewTurns(turns),
                _ => Solving::TooFewTurns(0),
            };
        };
        match estimator.slice(self.solver.borrow_mut()) {
            Ok(Slice::More(percent)) => Solving::Working(percent),
            Ok(Slice::Solved(findings)) => {
                if let State::Learning(estimator) = mem::replace(&mut self.state, State::Released) {
                    self.state = State::Solved(estimator.finish(findings));
                }
                Solving::Solved
            }
            Err(SolveError::TooFewTurns(turns)) => {
                self.state = State::TooFewTurns(turns);
                Solving::TooFewTurns(turns)
            }
        }
    }
}

impl<M: LearnerMemory, S: BorrowMut<Solver>> Learner for EstimatorLearner<M, S> {
    fn prepare(&mut self, knowledge: DriveKnowledge, goal: Goal) {
        self.goal = goal;
        // First the memory has to be back.
        self.release();
        let estimator = self
            .memory
            .take()
            .and_then(|buffers| Estimator::new(self.shape, Anchor::Index, buffers).ok());
        if let Some(estimator) = estimator {
            self.state = State::Learning(estimator.with_knowledge(knowledge));
        }
        self.solver.borrow_mut().restart();
        (self.lookout, self.seen) = (None, 0);
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
            estimator.lose_track();
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
        let turns = estimator.totals().turns;
        if self.lookout.is_none() && turns == self.seen {
            return None;
        }
        if self.lookout.is_none() {
            (self.lookout, self.seen) = (Some(Lookout::new()), turns);
        }
        let Poll::Ready(outlook) = estimator.look_out(self.lookout.as_mut()?) else {
            return None;
        };
        self.lookout = None;
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
        if !matches!(self.state, State::Room(_)) {
            self.release();
            let buffers = self.memory.take()?;
            if buffers.edges() == self.shape.edges() as usize {
                self.state = State::Room(buffers);
            }
        }
        match &mut self.state {
            State::Room(buffers) => Some(buffers.parts().cells),
            _ => None,
        }
    }

    fn release(&mut self) {
        self.state = State::Released;
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::device::Shelf;
    use crate::estimate::StaticBuffers;
    use crate::step::{Flags, Step};
    use std::boxed::Box;

    const LINES: u32 = 8;
    type Buffers = StaticBuffers<8, 4, 32>;

    fn shape() -> EncoderShape {
        EncoderShape::new(4 * LINES, 4).unwrap()
    }

    /// Whole turns of an encoder whose rising edges of A are late by a tenth of a step.
    fn turn<M: LearnerMemory>(learner: &mut EstimatorLearner<M, Box<Solver>>, turns: u32) {
        let mut before = 0;
        for k in 0..=turns * 4 * LINES {
            let late = if k % 4 == 0 { 100 } else { 0 };
            let ticks = u64::from(k + 1) * 1000 + late;
            learner.push(&Outcome::Step(Step {
                ticks,
                edge: k % (4 * LINES),
                position: k,
                interval: u32::try_from(ticks - before).unwrap(),
                resync: 0,
                advance: 1,
                flags: Flags::REFERENCED,
                direction: crate::edge::Direction::Forward,
            }));
            before = ticks;
        }
    }

    fn solve<M: LearnerMemory>(learner: &mut EstimatorLearner<M, Box<Solver>>) -> Solving {
        let mut before = 0;
        loop {
            match learner.slice() {
                Solving::Working(percent) => {
                    assert!((before..100).contains(&percent));
                    before = percent;
                }
                solved => return solved,
            }
        }
    }

    fn prepare<M: LearnerMemory>(learner: &mut EstimatorLearner<M, Box<Solver>>) {
        learner.prepare(DriveKnowledge::default(), Goal { error: 0 });
    }

    #[test]
    fn it_learns_again_and_again_in_the_same_memory_however_it_ends() {
        let mut buffers = Buffers::new();
        let shelf = Shelf::new(&mut buffers);
        let mut learner = EstimatorLearner::new(shape(), 1_000_000, &shelf, Box::default());
        for _ in 0..2 {
            // Aborted.
            prepare(&mut learner);
            turn(&mut learner, 3);
            assert!(learner.learning().turns > 0);
            learner.release();
            assert_eq!(learner.learning().turns, 0);
            // Too few turns.
            prepare(&mut learner);
            turn(&mut learner, 2);
            assert_eq!(learner.slice(), Solving::TooFewTurns(1));
            assert_eq!(learner.slice(), Solving::TooFewTurns(1));
            // Straight into the next one, to its end.
            prepare(&mut learner);
            turn(&mut learner, 9);
            assert_eq!(learner.learning().turns, 8);
            assert_eq!(solve(&mut learner), Solving::Solved);
            assert_eq!(learner.slice(), Solving::Solved);
            let header = learner.header().unwrap();
            assert_eq!((header.turns, learner.entries().len()), (8, 32));
            // A tenth of a step of 2^27, less the mean of the four classes.
            let spread = header.class_offsets[0].0 - header.class_offsets[1].0;
            let step = f64::from(1 << 27);
            assert!(
                (f64::from(spread.abs()) / step - 0.1).abs() < 2e-3,
                "{header:?}"
            );
        }
    }

    #[test]
    fn what_is_put_in_its_room_stays_until_it_learns() {
        let mut buffers = Buffers::new();
        let shelf = Shelf::new(&mut buffers);
        let mut learner = EstimatorLearner::new(shape(), 1_000_000, &shelf, Box::default());
        prepare(&mut learner);
        let room = learner.room().unwrap();
        assert_eq!(room.len(), 32);
        room[31] = 7;
        assert_eq!(learner.room().unwrap()[31], 7);
        assert_eq!(learner.slice(), Solving::TooFewTurns(0));
        assert_eq!(learner.room().unwrap()[31], 7);
        prepare(&mut learner);
        turn(&mut learner, 9);
        assert_eq!(solve(&mut learner), Solving::Solved);
    }

    #[test]
    fn memory_of_another_size_or_in_use_elsewhere_learns_nothing() {
        let mut buffers = Buffers::new();
        let shelf = Shelf::new(&mut buffers);
        let mut other =
            EstimatorLearner::new(EncoderShape::new(36, 4).unwrap(), 1, &shelf, Box::default());
        prepare(&mut other);
        assert_eq!(other.slice(), Solving::TooFewTurns(0));
        assert!(other.room().is_none());
        let mut learner = EstimatorLearner::new(shape(), 1_000_000, &shelf, Box::default());
        assert!(learner.room().is_some());
        prepare(&mut other);
        let mut third = EstimatorLearner::new(shape(), 1_000_000, &shelf, Box::default());
        assert!(third.room().is_none());
        drop(learner);
        assert!(third.room().is_some());
    }
}

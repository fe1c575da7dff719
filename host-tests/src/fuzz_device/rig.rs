//! What is around the device: a shaft that does anything, an interlock that says anything, and nonces.

use std::cell::Cell;
use std::rc::Rc;

use quadcal::access::Nonces;
use quadcal::device::{Bench, Learning};
use quadcal::estimate::Advice;
use quadcal::recalibrate::{Action, Figures, Interlock, Obstacle, Scatter, SolveInSlices, Solving};
use quadcal::shape::{CLASSES_MAX, EncoderShape};
use quadcal::slot::{Delays, SlotHeader, Stamp};
use quadcal::store::Found;
use quadcal::units::TurnDelta32;
use quadcal::wire::{Live, Nonce};

use super::dice::Dice;

/// Edges a turn: few, so that a table is quickly handed over.
pub const EDGES: usize = 12;

/// The encoder's shape.
///
/// # Panics
/// Never.
#[must_use]
pub fn shape() -> EncoderShape {
    EncoderShape::new(EDGES as u32, 4).expect("twelve edges in four classes")
}

/// A table of this encoder.
#[must_use]
pub fn header() -> SlotHeader {
    SlotHeader {
        shape: shape(),
        shift: 2,
        turns: 11,
        indexed: true,
        standard_error: 3,
        class_standard_error: 1,
        source: 0,
        learned_until: 0,
        class_offsets: [TurnDelta32(5); CLASSES_MAX],
        delays: Delays::NONE,
        stamp: Stamp::default(),
    }
}

/// A bench that moves on fast, and now and then the wrong way.
#[derive(Debug)]
pub struct AnyBench {
    dice: Dice,
    turns: u32,
    proven: u32,
    cells: [i16; EDGES],
    /// What the device did to it.
    pub changes: u64,
}

impl AnyBench {
    /// A bench that draws from a seed.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self {
            dice: Dice::new(seed),
            turns: 0,
            proven: 0,
            cells: [7; EDGES],
            changes: 0,
        }
    }
}

impl SolveInSlices for AnyBench {
    fn slice(&mut self) -> Solving {
        match self.dice.below(20) {
            0 => Solving::TooFewTurns(self.turns),
            1..10 => Solving::Working(self.dice.byte()),
            _ => Solving::Solved,
        }
    }
}

impl Bench for AnyBench {
    fn perform(&mut self, action: &Action) {
        self.changes += 1;
        match action {
            Action::Prepare(_) => self.turns = 0,
            Action::Prove => self.proven = 0,
            _ => {}
        }
    }

    fn live(&mut self) -> Live {
        Live::default()
    }

    fn speed(&mut self) -> u32 {
        if self.dice.once_in(30) {
            self.dice.number() as u32
        } else {
            1000
        }
    }

    fn learning(&mut self) -> Learning {
        self.turns += self.dice.below(4) as u32;
        Learning {
            turns: self.turns,
            rejected: 0,
        }
    }

    fn advice(&mut self) -> Option<Advice> {
        match self.dice.below(4) {
            0 => Some(Advice::GoalMet),
            1 => Some(Advice::GoOn),
            _ => None,
        }
    }

    fn figures(&mut self) -> Figures {
        // A fresh turn at every look is as much as there can be.
        self.proven += 1;
        Figures {
            turns: self.proven,
            rejected: 0,
            old: Scatter::default(),
            new: Scatter::default(),
            better: !self.turns.is_multiple_of(5),
        }
    }

    fn candidate(&self) -> Option<(SlotHeader, &[i16])> {
        (self.turns % 7 != 6).then(|| (header(), self.cells.as_slice()))
    }

    fn room(&mut self) -> Option<&mut [i16]> {
        self.changes += 1;
        Some(&mut self.cells)
    }

    fn compare(&mut self, _: &SlotHeader) {
        self.changes += 1;
        self.proven = 0;
    }

    fn adopt(&mut self, _: Option<&Found>) -> bool {
        self.changes += 1;
        true
    }
}

/// An interlock that the test sets.
#[derive(Clone, Debug, Default)]
pub struct Switch {
    /// Whether nothing is allowed.
    pub closed: Rc<Cell<bool>>,
}

impl Switch {
    fn ask(&self) -> Result<(), Obstacle> {
        if self.closed.get() {
            Err(Obstacle::Fault)
        } else {
            Ok(())
        }
    }
}

impl Interlock for Switch {
    fn may_calibrate(&self) -> Result<(), Obstacle> {
        self.ask()
    }

    fn may_commit(&self) -> Result<(), Obstacle> {
        self.ask()
    }
}

/// Nonces that are never the same, and now and then none.
#[derive(Debug)]
pub struct DiceNonces(pub Dice);

impl Nonces for DiceNonces {
    fn nonce(&mut self) -> Option<Nonce> {
        if self.0.once_in(50) {
            return None;
        }
        let [a, b] = [self.0.bits(), self.0.bits()].map(u64::to_le_bytes);
        Some(std::array::from_fn(|i| if i < 8 { a[i] } else { b[i - 8] }))
    }
}

//! The edge path of a drive that can be calibrated in the field: corrected edges come out, and beside that it learns or proves.

use super::bench::{Bench, Learner, Learning};
use super::pace::Pace;
use super::proof::{Corrected, Proof};
use super::trial::Trial;
use crate::corrector::{CorrectedEdge, Corrector};
use crate::estimate::{Advice, Anchor, DriveKnowledge, Goal};
use crate::interval::{SPEED_FRACTION_BITS, Speed};
use crate::recalibrate::{Action, Figures, SolveInSlices, Solving};
use crate::shape::{EncoderShape, Grid};
use crate::slot::{Slot, SlotHeader};
use crate::step::{Faults, Flags, Outcome};
use crate::store::Found;
use crate::units::Ticks;
use crate::wire::Live;

/// Flash that the processor reads like memory, slot by slot. `'f` lasts as long as the device runs.
///
/// The flash is written meanwhile, but no slot in use is: [`super::Device`] has another one adopted, or none, before it is. So an
/// implementation hands out the bytes of the slot asked for and nothing beside them, neither the store's marks before it nor the other
/// place.
pub trait MappedFlash<'f> {
    /// The bytes of the slot that begins at an offset of the store's flash, to the end of its place at the most.
    fn bytes(&self, offset: u32) -> Option<&'f [u8]>;
}

/// What is done with edges besides correcting them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Work {
    Nothing,
    Learning,
    Proving,
    /// Proving a table that was handed over.
    Comparing,
}

/// What a [`Workbench`] is told once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WorkbenchConfig {
    /// The encoder's shape.
    pub shape: EncoderShape,
    /// Ticks a second.
    pub clock_hz: u64,
    /// Ticks without an edge after which the shaft stands still.
    pub still: Ticks,
}

/// Corrects edges with the table in use and, on command, learns and proves another. The encoder has an index.
pub struct Workbench<'f, L, M> {
    config: WorkbenchConfig,
    flash: M,
    corrector: Corrector<'f, [u8; 2]>,
    pace: Pace,
    work: Work,
    learner: L,
    proof: Proof,
    trial: Option<Trial>,
    now: Ticks,
    faults: Faults,
}

impl<'f, L: Learner, M: MappedFlash<'f>> Workbench<'f, L, M> {
    /// Corrects with no table yet.
    pub fn new(config: WorkbenchConfig, learner: L, flash: M) -> Self {
        Self {
            config,
            flash,
            corrector: Corrector::uncorrected(Grid::new(config.shape)),
            pace: Pace::new(config.shape),
            work: Work::Nothing,
            learner,
            proof: Proof::new(config.shape),
            trial: None,
            now: 0,
            faults: Faults::new(),
        }
    }

    /// Takes what a decoder made of a sample; `Some` for every accepted edge. On the edge path.
    #[inline]
    pub fn push(&mut self, outcome: &Outcome) -> Option<CorrectedEdge> {
        let edge = self.corrector.push(outcome);
        if let Outcome::Step(step) = outcome {
            self.pace.push(step);
        }
        match self.work {
            Work::Nothing => {}
            Work::Learning => self.learn(outcome),
            Work::Proving | Work::Comparing => {
                let old = edge.as_ref().map(|edge| Corrected {
                    moved: edge.moved,
                    late: edge.late,
                });
                self.prove(outcome, old);
            }
        }
        edge
    }

    /// The time and what the decoder counted, for [`Bench::live`] and [`Bench::speed`]; from the main loop.
    pub fn note(&mut self, now: Ticks, faults: &Faults) {
        self.now = now;
        self.faults = *faults;
    }

    /// The corrector, for the control loop.
    pub const fn corrector(&self) -> &Corrector<'f, [u8; 2]> {
        &self.corrector
    }

    /// Out of line, as [`Self::prove`]: what the control loop waits for keeps the registers to itself.
    #[inline(never)]
    fn learn(&mut self, outcome: &Outcome) {
        self.learner.push(outcome);
    }

    #[inline(never)]
    fn prove(&mut self, outcome: &Outcome, old: Option<Corrected>) {
        match (outcome, old, &mut self.trial) {
            (Outcome::Step(step), Some(old), Some(trial)) => {
                let entries = match self.work {
                    Work::Comparing => self.learner.room().map_or(&[][..], |room| room),
                    _ => self.learner.entries(),
                };
                let new = trial.push(step, entries);
                self.proof.push(step, old, new);
            }
            (Outcome::Index(index), ..) if index.resync == 0 => {}
            (Outcome::Idle, ..) => {}
            _ => self.proof.spoil(),
        }
    }

    /// Stops learning.
    fn hold(&mut self) {
        if self.work == Work::Learning {
            self.learner.interrupt();
        }
        self.work = Work::Nothing;
    }

    fn start_proof(&mut self) {
        self.proof = Proof::new(self.config.shape);
        let entries = self.learner.entries();
        let clock_hz = self.config.clock_hz;
        let header = self.learner.header();
        self.trial = header.and_then(|header| Trial::new(&header, entries, clock_hz));
        self.work = Work::Proving;
    }

    /// The table of a slot in flash, if it is of this encoder.
    fn corrector_of(&self, found: &Found) -> Option<Corrector<'f, [u8; 2]>> {
        let slot = Slot::parse(self.flash.bytes(found.offset)?).ok()?;
        let table = slot.table_at(self.config.clock_hz).ok()?;
        let fits = slot.header.indexed && slot.header.shape == self.config.shape;
        fits.then(|| Corrector::new(table, Anchor::Index))
    }
}

impl<L: Learner, M> SolveInSlices for Workbench<'_, L, M> {
    fn slice(&mut self) -> Solving {
        self.learner.slice()
    }
}

impl<'f, L: Learner, M: MappedFlash<'f>> Bench for Workbench<'f, L, M> {
    fn perform(&mut self, action: &Action) {
        self.hold();
        match action {
            Action::Prepare(options) => {
                let knowledge = DriveKnowledge {
                    torque_base: options.torque_base,
                    hidden_up_to: options.hidden_up_to,
                };
                let goal = Goal {
                    error: options.goal,
                };
                self.trial = None;
                self.learner.prepare(knowledge, goal);
            }
            Action::Learn => self.work = Work::Learning,
            Action::Hold | Action::Solve | Action::Compare | Action::Keep | Action::Write(_) => {}
            Action::Prove => self.start_proof(),
            Action::Release => {
                self.trial = None;
                self.learner.release();
            }
        }
    }

    fn live(&mut self) -> Live {
        let faults = &self.faults;
        let last = self.corrector.last();
        let still = |last: &CorrectedEdge| {
            last.interval == 0 || self.now.saturating_sub(last.ticks) > self.config.still
        };
        let (speed_raw, speed) = match &last {
            Some(last) if !still(last) => {
                let step = (1_i64 << SPEED_FRACTION_BITS) / i64::from(self.config.shape.edges());
                let step = step * i64::from(self.pace.direction().sign());
                let moved = i64::from(last.moved.0) << (SPEED_FRACTION_BITS - 32);
                (
                    Speed::over(step, last.interval),
                    Speed::over_q8(moved, last.interval_q8()),
                )
            }
            _ => (Speed::ZERO, Speed::ZERO),
        };
        Live {
            ticks: self.now,
            angle: self.corrector.angle_at(self.now).map_or(0, |angle| angle.0),
            referenced: last.is_some_and(|last| last.flags.contains(Flags::REFERENCED)),
            speed_raw: speed_raw.0,
            speed: speed.0,
            faults: [
                faults.illegal,
                faults.lost,
                faults.extra,
                faults.glitch,
                faults.abrupt_reversal,
                faults.interval_spike,
                faults.repeated,
            ],
        }
    }

    fn speed(&mut self) -> u32 {
        let last = self.corrector.last().map_or(0, |last| last.ticks);
        let WorkbenchConfig {
            clock_hz, still, ..
        } = self.config;
        self.pace.speed(last, self.now, clock_hz, still)
    }

    fn learning(&mut self) -> Learning {
        self.learner.learning()
    }

    fn advice(&mut self) -> Option<Advice> {
        self.learner.advice()
    }

    fn figures(&mut self) -> Figures {
        self.proof.settle();
        self.proof.figures()
    }

    fn candidate(&self) -> Option<(SlotHeader, &[i16])> {
        let header = self.learner.header()?;
        Some((header, self.learner.entries()))
    }

    fn room(&mut self) -> Option<&mut [i16]> {
        if self.work == Work::Nothing {
            self.learner.room()
        } else {
            None
        }
    }

    fn compare(&mut self, header: &SlotHeader) {
        let clock_hz = self.config.clock_hz;
        self.proof = Proof::new(self.config.shape);
        self.trial = self
            .learner
            .room()
            .and_then(|entries| Trial::new(header, entries, clock_hz));
        self.work = Work::Comparing;
    }

    fn adopt(&mut self, found: Option<&Found>) -> bool {
        let corrector = found.and_then(|found| self.corrector_of(found));
        let adopted = corrector.is_some() == found.is_some();
        self.corrector =
            corrector.unwrap_or_else(|| Corrector::uncorrected(Grid::new(self.config.shape)));
        adopted
    }
}

//! What the machine says is done, and what happens is told to the machine.

use embedded_storage::nor_flash::NorFlash;

use super::bench::{Bench, Learning};
use super::service::{Service, write_failure};
use crate::access::Nonces;
use crate::recalibrate::{
    Action, Candidate, Event, Failure, Interlock, Solving, Stage, Taken, WriteFailure,
};
use crate::slot::{SlotHeader, Stamp};
use crate::units::{TickDelta8, TurnDelta32};
use crate::wire::{Learned, Refusal};

impl<F: NorFlash, N: Nonces, I: Interlock> Service<F, N, I> {
    /// One piece of work: a look at the shaft, a slice of solving, or writing the table.
    pub fn poll(&mut self, now_ms: u64, bench: &mut impl Bench) {
        // None of these is a command, so none is refused.
        let _ = self.tell(Event::Tick, now_ms, bench);
        match self.due.take() {
            Some(candidate) => self.write_due(candidate, now_ms, bench),
            None => {
                let _ = self.look(now_ms, bench);
            }
        }
    }

    fn look(&mut self, now_ms: u64, bench: &mut impl Bench) -> Result<(), Refusal> {
        match self.machine.stage() {
            Stage::WaitingForMotion | Stage::CheckingSpeed => {
                self.tell(Event::Motion(bench.speed()), now_ms, bench)
            }
            Stage::Learning => {
                self.tell(Event::Motion(bench.speed()), now_ms, bench)?;
                self.look_at_learning(now_ms, bench)
            }
            Stage::Solving => {
                let solving = bench.slice();
                match solving {
                    Solving::Working(percent) => self.solved_percent = percent,
                    Solving::Solved => {
                        self.solved_percent = 100;
                        self.learned = bench
                            .candidate()
                            .map(|(header, _)| learned(&header, self.rejected));
                    }
                    Solving::TooFewTurns(_) => {}
                }
                self.tell(Event::Slice(solving), now_ms, bench)
            }
            Stage::Proving => self.look_at_figures(now_ms, bench),
            // The machine passes these figures over: they are for the preview.
            Stage::ReadyToCommit if self.loaded.is_some() => self.look_at_figures(now_ms, bench),
            _ => Ok(()),
        }
    }

    fn look_at_figures(&mut self, now_ms: u64, bench: &mut impl Bench) -> Result<(), Refusal> {
        let figures = bench.figures();
        self.rejected = figures.rejected;
        if figures.turns == self.turns {
            return Ok(());
        }
        self.turns = figures.turns;
        self.preview = Some(figures);
        self.tell(Event::Proof(figures), now_ms, bench)
    }

    fn look_at_learning(&mut self, now_ms: u64, bench: &mut impl Bench) -> Result<(), Refusal> {
        let Learning { turns, rejected } = bench.learning();
        self.rejected = rejected;
        let advice = bench.advice();
        if turns == self.turns && advice.is_none() {
            return Ok(());
        }
        self.turns = turns;
        self.tell(Event::Turn(Taken { turns, advice }), now_ms, bench)
    }

    /// Does what the machine says. Writing waits for the next poll, so that the reply goes out first.
    pub fn perform(&mut self, action: &Action, bench: &mut impl Bench) {
        match action {
            Action::Prepare(_) => {
                (self.upload, self.loaded) = (None, None);
                (self.turns, self.rejected, self.solved_percent) = (0, 0, 0);
                (self.learned, self.preview) = (None, None);
            }
            Action::Prove => {
                (self.turns, self.rejected) = (0, 0);
            }
            Action::Compare => {
                (self.turns, self.rejected, self.preview) = (0, 0, None);
            }
            Action::Release => {
                (self.upload, self.loaded) = (None, None);
                // Why a table was refused can still be read; else there is no table that the figures are of.
                if self.machine.stage() != Stage::Failed(Failure::NotBetter) {
                    self.preview = None;
                }
            }
            Action::Write(candidate) => self.due = Some(*candidate),
            _ => {}
        }
        bench.perform(action);
        if let (Action::Compare, Some(header)) = (action, &self.loaded) {
            bench.compare(header);
        }
    }

    /// Writes the table that was said to be written, if the interlock still allows it.
    fn write_due(&mut self, candidate: Candidate, now_ms: u64, bench: &mut impl Bench) {
        if self.interlock.may_commit().is_err() {
            let _ = self.tell(Event::HeldBack, now_ms, bench);
            return;
        }
        let written = match self.agree_with_store(bench) {
            Ok(()) => self.commit(candidate, bench),
            Err(_) => Err(WriteFailure::Flash),
        };
        if written.is_ok() {
            // Where flash can't be read right after it was read back, correction ends, and status says so.
            let _ = self.adopt_newest(bench);
        }
        self.loaded = None;
        let _ = self.tell(Event::Written(written), now_ms, bench);
    }

    fn commit(&mut self, candidate: Candidate, bench: &mut impl Bench) -> Result<(), WriteFailure> {
        let temperature_q4 = bench.temperature_q4();
        self.wear.spend();
        let found = match candidate {
            Candidate::Learned => {
                let (header, entries) = bench.candidate().ok_or(WriteFailure::Missing)?;
                let header = SlotHeader {
                    stamp: Stamp {
                        serial: self.config.serial,
                        learned_at: self.machine.options().date,
                        temperature_q4,
                        ..header.stamp
                    },
                    ..header
                };
                self.store.commit(&header, entries)
            }
            Candidate::Loaded => {
                let header = self.loaded.ok_or(WriteFailure::Missing)?;
                let entries = bench.room().ok_or(WriteFailure::Missing)?;
                self.store.commit(&header, &*entries)
            }
        };
        found.map(drop).map_err(|error| write_failure(&error))
    }
}

fn learned(header: &SlotHeader, rejected: u32) -> Learned {
    Learned {
        turns: header.turns,
        rejected,
        standard_error: header.standard_error,
        class_standard_error: header.class_standard_error,
        table_rms: header.stamp.table_rms,
        class_offsets: header.class_offsets.map(|TurnDelta32(offset)| offset),
        class_delays: header.delays.of_class.map(|TickDelta8(delay)| delay),
    }
}

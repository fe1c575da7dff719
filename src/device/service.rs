//! Answers to requests.

use embedded_storage::nor_flash::NorFlash;

use super::DeviceConfig;
use super::bench::Bench;
use super::upload::Upload;
use crate::access::{Access, Nonces};
use crate::recalibrate::{
    Candidate, Event, Figures, Interlock, Machine, Refused, Stage, WearBudget, WriteFailure,
};
use crate::slot::{SlotHeader, VERSION};
use crate::store::{Found, Place, Store, StoreError};
use crate::wire::{Frame, Identity, Learned, LogLevel, Refusal, Reply, Request, Status, TableInfo};

/// All of a device but the parser of its port.
pub(super) struct Service<F, N, I> {
    pub config: DeviceConfig,
    pub store: Store<F>,
    pub nonces: N,
    pub interlock: I,
    pub access: Access,
    pub machine: Machine,
    pub wear: WearBudget,
    pub upload: Option<Upload>,
    /// What the table that was handed over says of itself.
    pub loaded: Option<SlotHeader>,
    /// What is to be written at the next poll.
    pub due: Option<Candidate>,
    /// The table that is corrected with.
    pub in_use: Option<Found>,
    pub learned: Option<Learned>,
    pub preview: Option<Figures>,
    /// Turns that the machine was told of.
    pub turns: u32,
    pub rejected: u32,
    pub solved_percent: u8,
    pub log_level: LogLevel,
    pub bad_frames: u32,
    pub started_ms: u64,
}

/// What comes of a request.
pub(super) type Answer = Result<Reply, Refusal>;

impl<F: NorFlash, N: Nonces, I: Interlock> Service<F, N, I> {
    /// Answers a frame with a request.
    pub fn answer(&mut self, frame: &Frame<'_>, now_ms: u64, bench: &mut impl Bench) -> Reply {
        let answer = match frame.read::<Request>() {
            None => Err(Refusal::Unknown),
            Some(request) if request.is_open_to_all() => self.read(&request, now_ms, bench),
            Some(request) => match self.access.admit(frame, now_ms) {
                Ok(()) => self.change(request, now_ms, bench),
                Err(refusal) => Err(refusal),
            },
        };
        answer.unwrap_or_else(Reply::Refused)
    }

    /// A request that changes nothing but who may.
    fn read(&mut self, request: &Request, now_ms: u64, bench: &mut impl Bench) -> Answer {
        Ok(match request {
            Request::Identify => Reply::Identity(self.identity()),
            Request::Status => Reply::Status(self.status(now_ms)?),
            Request::Live => Reply::Live(bench.live()),
            Request::Result => Reply::Result(self.learned),
            Request::Preview => Reply::Preview(self.preview),
            Request::ReadTable { offset } => self.piece(*offset)?,
            Request::Challenge => Reply::Challenge {
                nonce: self.access.challenge(&mut self.nonces, now_ms)?,
            },
            Request::Open { proof } => Reply::Opened {
                idle_ms: self.access.open(proof, now_ms)?,
            },
            _ => return Err(Refusal::NoSession),
        })
    }

    /// A request that was admitted.
    fn change(&mut self, request: Request, now_ms: u64, bench: &mut impl Bench) -> Answer {
        // Time may have run out since the last look.
        self.tell(Event::Tick, now_ms, bench)?;
        match request {
            Request::Start(options) => self.tell(Event::Start(options), now_ms, bench)?,
            Request::Abort => self.tell(Event::Abort, now_ms, bench)?,
            Request::Commit => {
                if self.machine.stage() == Stage::ReadyToCommit {
                    self.may_erase(now_ms)?;
                }
                self.tell(Event::Commit, now_ms, bench)?;
            }
            Request::RollBack => {
                self.may_exchange()?;
                self.store.roll_back().map_err(refused)?;
                self.adopt_newest(bench)?;
                self.forget(now_ms, bench)?;
            }
            Request::WriteTable { offset, piece } => {
                return self.write(offset, &piece, now_ms, bench);
            }
            Request::Erase => {
                self.may_exchange()?;
                self.may_erase(now_ms)?;
                self.wear.spend();
                // Nothing is written under the edge path's eyes.
                bench.adopt(None);
                let erased = self.store.erase().map_err(refused);
                // Where it failed, there may be one left.
                self.adopt_newest(bench)?;
                self.forget(now_ms, bench)?;
                erased?;
            }
            Request::LogLevel(level) => self.log_level = level,
            Request::Close => self.access.close(),
            _ => return Err(Refusal::Unknown),
        }
        Ok(Reply::Done)
    }

    fn identity(&self) -> Identity {
        let shape = self.config.shape;
        #[allow(clippy::cast_possible_truncation)]
        Identity {
            firmware: self.config.firmware,
            slot_version: VERSION,
            edges: shape.edges(),
            classes: shape.classes() as u8,
            clock_hz: self.config.clock_hz,
            serial: self.config.serial,
        }
    }

    fn status(&mut self, now_ms: u64) -> Result<Status, Refusal> {
        let stage = self.machine.stage();
        let options = self.machine.options();
        let turns_wanted = match stage {
            Stage::Proving | Stage::ReadyToCommit => options.proof_turns.into(),
            _ => options.turns.into(),
        };
        let mut wear = [0; 2];
        for (wear, place) in wear.iter_mut().zip([Place::A, Place::B]) {
            *wear = self.store.wear(place).map_err(refused)?;
        }
        Ok(Status {
            stage,
            turns: self.turns,
            turns_wanted,
            rejected: self.rejected,
            solved_percent: self.solved_percent,
            session: self.access.is_open(now_ms),
            table: self.in_use.as_ref().map(info),
            wear,
            log_level: self.log_level,
            bad_frames: self.bad_frames,
            uptime_ms: now_ms.saturating_sub(self.started_ms),
        })
    }

    /// Whether the table in use may be exchanged by hand.
    fn may_exchange(&self) -> Result<(), Refusal> {
        let stage = self.machine.stage();
        if !matches!(stage, Stage::Idle | Stage::Done | Stage::Failed(_)) {
            return Err(Refusal::Stage(stage));
        }
        self.interlock.may_commit().map_err(Refusal::Interlock)
    }

    /// Back to idle: what the calibration before came to, and its figures, are of a table that is no longer in use.
    fn forget(&mut self, now_ms: u64, bench: &mut impl Bench) -> Result<(), Refusal> {
        self.tell(Event::Abort, now_ms, bench)
    }

    /// Whether a place may be erased once more.
    fn may_erase(&mut self, now_ms: u64) -> Result<(), Refusal> {
        let [a, b] = [Place::A, Place::B].map(|place| self.store.wear(place));
        let wear = a.map_err(refused)?.max(b.map_err(refused)?);
        self.wear
            .check(wear, now_ms)
            .map_err(|left_ms| match left_ms {
                Some(left_ms) => {
                    Refusal::Wear(u32::try_from(left_ms.div_ceil(1000)).unwrap_or(u32::MAX))
                }
                None => Refusal::NotWritten(WriteFailure::WornOut),
            })
    }

    /// Corrects with the newest table from now on.
    pub fn adopt_newest(&mut self, bench: &mut impl Bench) -> Result<(), Refusal> {
        let newest = self.store.newest().map_err(refused);
        let found = newest.unwrap_or_default();
        let adopted = bench.adopt(found.as_ref());
        self.in_use = found.filter(|_| adopted);
        newest.map(drop)
    }

    /// Makes sure that what is in use is what counts, which the store does not write to. A write that failed at its very end, the flash
    /// having done what it denies, may have changed that.
    pub fn agree_with_store(&mut self, bench: &mut impl Bench) -> Result<(), Refusal> {
        if self.store.newest().map_err(refused)? == self.in_use {
            Ok(())
        } else {
            self.adopt_newest(bench)
        }
    }

    /// Tells the machine what happens and does what it says.
    pub fn tell(
        &mut self,
        event: Event,
        now_ms: u64,
        bench: &mut impl Bench,
    ) -> Result<(), Refusal> {
        let (action, taken) = self.machine.take(event, now_ms, &self.interlock);
        if let Some(action) = action {
            self.perform(&action, bench);
        }
        taken.map_err(|refused| match refused {
            Refused::Stage(stage) => Refusal::Stage(stage),
            Refused::Interlock(obstacle) => Refusal::Interlock(obstacle),
            Refused::Window => Refusal::Window,
        })
    }
}

fn info(found: &Found) -> TableInfo {
    let header = &found.header;
    TableInfo {
        place: found.place as u8,
        sequence: header.stamp.sequence,
        turns: header.turns,
        standard_error: header.standard_error,
        table_rms: header.stamp.table_rms,
        serial: header.stamp.serial,
        learned_at: header.stamp.learned_at,
        temperature_q4: header.stamp.temperature_q4,
    }
}

/// Why the store did not do it.
pub(super) fn refused<E>(error: StoreError<E>) -> Refusal {
    match error {
        StoreError::NothingOlder => Refusal::NothingOlder,
        error => match write_failure(&error) {
            WriteFailure::Flash => Refusal::Flash,
            failure => Refusal::NotWritten(failure),
        },
    }
}

/// Why a table was not written.
pub(super) fn write_failure<E>(error: &StoreError<E>) -> WriteFailure {
    match error {
        StoreError::Flash(_) => WriteFailure::Flash,
        StoreError::TooLong { .. } => WriteFailure::TooLong,
        StoreError::WornOut { .. } => WriteFailure::WornOut,
        StoreError::Verify(_) => WriteFailure::Verify,
        StoreError::NothingOlder => WriteFailure::Missing,
    }
}

//! The machine itself; the [module's](super) head draws it.

use super::event::{Action, Candidate, Event, Refused, Solving, Taken};
use super::{
    Failure, Figures, Interlock, Limits, Options, PROOF_TURNS_LEAST, SpeedWindow, Stage,
    TURNS_LEAST, Waiting,
};
use crate::estimate::Advice;

/// A calibration by command. Times are milliseconds of a clock that does not go back.
#[derive(Clone, Debug)]
pub struct Machine {
    limits: Limits,
    stage: Stage,
    options: Options,
    candidate: Candidate,
    /// When the present stage began, or what it waits for came last.
    since_ms: u64,
    /// When the calibration began.
    began_ms: u64,
    /// Since when the speed has been in the window.
    steady_since_ms: Option<u64>,
}

/// What the machine makes of an event.
type Step = Result<Option<Action>, Refused>;

impl Machine {
    /// Idle.
    #[must_use]
    pub fn new(limits: Limits) -> Self {
        Self {
            limits,
            stage: Stage::Idle,
            options: Options::default(),
            candidate: Candidate::Learned,
            since_ms: 0,
            began_ms: 0,
            steady_since_ms: None,
        }
    }

    /// Where it stands.
    #[must_use]
    pub const fn stage(&self) -> Stage {
        self.stage
    }

    /// What the calibration was asked for, within the limits.
    #[must_use]
    pub const fn options(&self) -> &Options {
        &self.options
    }

    /// Takes an event. A command that does not fit the stage is refused; what else does not fit it is passed over.
    ///
    /// The action is to be done even where a command is refused: time may have run out before it.
    pub fn take(
        &mut self,
        event: Event,
        now_ms: u64,
        interlock: &impl Interlock,
    ) -> (Option<Action>, Result<(), Refused>) {
        let ended = self.end(now_ms, interlock);
        match self.step(event, now_ms, interlock) {
            // Preparing, and handing over, forget what was before.
            Ok(action) => (action.or(ended), Ok(())),
            Err(refused) => (ended, Err(refused)),
        }
    }

    fn step(&mut self, event: Event, now_ms: u64, interlock: &impl Interlock) -> Step {
        match event {
            Event::Start(options) => self.start(options, now_ms, interlock),
            Event::Abort => self.abort(now_ms),
            Event::Commit => self.commit(now_ms, interlock),
            Event::Loaded => self.loaded(now_ms),
            Event::Tick => Ok(None),
            Event::Motion(speed) => Ok(self.motion(speed, now_ms)),
            Event::Turn(taken) => Ok(self.turn(taken, now_ms)),
            Event::Slice(solving) => Ok(self.slice(solving, now_ms)),
            Event::Proof(figures) => Ok(self.proof(&figures, now_ms)),
            Event::HeldBack => Ok(self.held_back(now_ms)),
            Event::Written(written) => Ok(match (self.stage, written) {
                (Stage::Committing, Ok(())) => self.enter(Stage::Done, now_ms, None),
                (Stage::Committing, Err(failure)) => {
                    self.fail(Failure::NotWritten(failure), now_ms)
                }
                _ => None,
            }),
        }
    }

    fn enter(&mut self, stage: Stage, now_ms: u64, action: Option<Action>) -> Option<Action> {
        self.stage = stage;
        self.since_ms = now_ms;
        self.steady_since_ms = None;
        action
    }

    fn fail(&mut self, failure: Failure, now_ms: u64) -> Option<Action> {
        self.enter(Stage::Failed(failure), now_ms, Some(Action::Release))
    }

    /// Whether nothing is being done.
    const fn is_at_rest(&self) -> bool {
        matches!(self.stage, Stage::Idle | Stage::Done | Stage::Failed(_))
    }

    fn start(&mut self, options: Options, now_ms: u64, interlock: &impl Interlock) -> Step {
        if !self.is_at_rest() {
            return Err(Refused::Stage(self.stage));
        }
        let window = options.window.within(self.limits.window);
        // Standing still is no speed to learn at.
        let window = window.within(SpeedWindow::ANY);
        if window.is_empty() {
            return Err(Refused::Window);
        }
        interlock.may_calibrate().map_err(Refused::Interlock)?;
        self.options = Options {
            window,
            turns: options.turns.max(TURNS_LEAST),
            proof_turns: options.proof_turns.max(PROOF_TURNS_LEAST),
            ..options
        };
        self.began_ms = now_ms;
        self.candidate = Candidate::Learned;
        let action = Some(Action::Prepare(self.options));
        Ok(self.enter(Stage::WaitingForMotion, now_ms, action))
    }

    fn abort(&mut self, now_ms: u64) -> Step {
        if self.stage == Stage::Committing {
            return Err(Refused::Stage(self.stage));
        }
        Ok(self.enter(Stage::Idle, now_ms, Some(Action::Release)))
    }

    fn commit(&mut self, now_ms: u64, interlock: &impl Interlock) -> Step {
        if self.stage != Stage::ReadyToCommit {
            return Err(Refused::Stage(self.stage));
        }
        interlock.may_commit().map_err(Refused::Interlock)?;
        let action = Some(Action::Write(self.candidate));
        Ok(self.enter(Stage::Committing, now_ms, action))
    }

    /// The table waits again: what was learned must not be lost because the shaft moved at the last moment.
    fn held_back(&mut self, now_ms: u64) -> Option<Action> {
        if self.stage == Stage::Committing {
            self.enter(Stage::ReadyToCommit, now_ms, Some(Action::Keep))
        } else {
            None
        }
    }

    fn loaded(&mut self, now_ms: u64) -> Step {
        if !self.is_at_rest() {
            return Err(Refused::Stage(self.stage));
        }
        self.candidate = Candidate::Loaded;
        Ok(self.enter(Stage::ReadyToCommit, now_ms, Some(Action::Compare)))
    }

    fn motion(&mut self, speed: u32, now_ms: u64) -> Option<Action> {
        let within = self.options.window.contains(speed);
        match self.stage {
            Stage::WaitingForMotion if speed != 0 => {
                self.enter(Stage::CheckingSpeed, now_ms, None);
                self.steady_since_ms = within.then_some(now_ms);
                None
            }
            Stage::CheckingSpeed if speed == 0 => self.enter(Stage::WaitingForMotion, now_ms, None),
            Stage::CheckingSpeed => self.steady(within, now_ms),
            Stage::Learning if speed == 0 => {
                self.enter(Stage::WaitingForMotion, now_ms, Some(Action::Hold))
            }
            Stage::Learning if !within => {
                self.enter(Stage::CheckingSpeed, now_ms, Some(Action::Hold))
            }
            _ => None,
        }
    }

    /// Goes on to learning once the speed has been in the window for long enough.
    fn steady(&mut self, within: bool, now_ms: u64) -> Option<Action> {
        if !within {
            self.steady_since_ms = None;
            return None;
        }
        let since = *self.steady_since_ms.get_or_insert(now_ms);
        if now_ms.saturating_sub(since) < self.limits.steady_ms.into() {
            return None;
        }
        self.enter(Stage::Learning, now_ms, Some(Action::Learn))
    }

    fn turn(&mut self, taken: Taken, now_ms: u64) -> Option<Action> {
        if self.stage != Stage::Learning {
            return None;
        }
        self.since_ms = now_ms;
        let advised = taken.advice.is_some_and(|advice| advice != Advice::GoOn);
        let least = if advised {
            TURNS_LEAST
        } else {
            self.options.turns
        };
        if taken.turns >= least.into() {
            self.enter(Stage::Solving, now_ms, Some(Action::Solve))
        } else {
            None
        }
    }

    fn slice(&mut self, solving: Solving, now_ms: u64) -> Option<Action> {
        match (self.stage, solving) {
            (Stage::Solving, Solving::Solved) => {
                self.enter(Stage::Proving, now_ms, Some(Action::Prove))
            }
            (Stage::Solving, Solving::TooFewTurns(turns)) => {
                self.fail(Failure::TooFewTurns(turns), now_ms)
            }
            _ => None,
        }
    }

    fn proof(&mut self, figures: &Figures, now_ms: u64) -> Option<Action> {
        if self.stage != Stage::Proving {
            return None;
        }
        self.since_ms = now_ms;
        if figures.turns < self.options.proof_turns.into() {
            None
        } else if figures.better {
            self.enter(Stage::ReadyToCommit, now_ms, Some(Action::Keep))
        } else {
            self.fail(Failure::NotBetter, now_ms)
        }
    }

    /// Ends what waits for too long or is no longer allowed.
    fn end(&mut self, now_ms: u64, interlock: &impl Interlock) -> Option<Action> {
        let limits = &self.limits;
        let (waiting, limit_ms) = match self.stage {
            Stage::WaitingForMotion => (Waiting::Motion, limits.motion_ms),
            Stage::CheckingSpeed => (Waiting::Speed, limits.speed_ms),
            Stage::Learning => (Waiting::Turn, limits.turn_ms),
            Stage::Solving => (Waiting::Solver, limits.solve_ms),
            Stage::Proving => (Waiting::Proof, limits.proof_ms),
            Stage::ReadyToCommit => (Waiting::Commit, limits.commit_ms),
            Stage::Idle | Stage::Committing | Stage::Done | Stage::Failed(_) => return None,
        };
        let learns = !matches!(waiting, Waiting::Proof | Waiting::Commit);
        let passed = |since_ms: u64| now_ms.saturating_sub(since_ms);
        if waiting != Waiting::Commit
            && let Err(obstacle) = interlock.may_calibrate()
        {
            self.fail(Failure::Interlock(obstacle), now_ms)
        } else if passed(self.since_ms) > limit_ms.into() {
            self.fail(Failure::TimedOut(waiting), now_ms)
        } else if learns && passed(self.began_ms) > limits.whole_ms.into() {
            self.fail(Failure::TimedOut(Waiting::Table), now_ms)
        } else {
            None
        }
    }
}

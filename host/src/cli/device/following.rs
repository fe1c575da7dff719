//! A calibration under way, as people see it.

use std::io::{self, IsTerminal, Write};
use std::time::Instant;

use quadcal::recalibrate::{Limits, Stage};
use quadcal::wire::Status;

use crate::device::stage_text;

use super::super::Globals;
use super::super::progress::Progress;
use super::pace::{Pace, Place};

/// Progress stage by stage: a remark as each begins, and a bar within it.
pub(super) struct Shown {
    globals: Globals,
    stage: Option<Stage>,
    since: Instant,
    progress: Option<Progress>,
    /// Where the speed was said to be.
    told: Option<Place>,
}

/// Whether the device waits for the shaft.
pub(super) const fn waits(stage: Stage) -> bool {
    matches!(stage, Stage::WaitingForMotion | Stage::CheckingSpeed)
}

impl Shown {
    pub fn new(globals: Globals) -> Self {
        Self {
            globals,
            stage: None,
            since: Instant::now(),
            progress: None,
            told: None,
        }
    }

    pub fn show(&mut self, status: &Status, pace: &Pace) {
        let stage = status.stage;
        if self.stage != Some(stage) {
            self.progress = None;
            self.stage = Some(stage);
            self.since = Instant::now();
            self.told = None;
            self.begin(status);
        }
        if waits(stage) {
            self.wait(stage, pace);
            return;
        }
        let (done, whole) = match stage {
            Stage::Solving => (status.solved_percent.into(), 100),
            _ => (status.turns.into(), status.turns_wanted.into()),
        };
        if let Some(progress) = &mut self.progress {
            progress.of(done, whole);
        }
    }

    /// The speed beside the bar, or, where there is none, in a line when it leaves the window or comes into it.
    fn wait(&mut self, stage: Stage, pace: &Pace) {
        if let Some(progress) = &mut self.progress {
            progress.reach(self.since.elapsed().as_secs(), |_| pace.text());
        }
        let place = pace.place();
        let news = place.is_some() && place != self.told && stage == Stage::CheckingSpeed;
        if news && !io::stderr().is_terminal() {
            self.told = place;
            self.say(&pace.text());
        }
    }

    fn begin(&mut self, status: &Status) {
        let stage = status.stage;
        let limits = Limits::default();
        let bar = match stage {
            // The times where the firmware sets no others.
            Stage::WaitingForMotion => Some(("Waiting", "s", Some(limits.motion_ms / 1000))),
            Stage::CheckingSpeed => Some(("Waiting", "s", Some(limits.speed_ms / 1000))),
            Stage::Learning => Some(("Learning", "turns", None)),
            Stage::Solving => Some(("Solving", "%", None)),
            Stage::Proving => Some(("Proving", "turns", None)),
            _ => None,
        };
        self.progress = bar.map(|(what, unit, whole)| {
            Progress::count(what, unit, whole.map(u64::from), self.globals)
        });
        if stage == Stage::Solving && status.turns < status.turns_wanted {
            let (turns, wanted) = (status.turns, status.turns_wanted);
            self.say(&format!(
                "{turns} of {wanted} turns are enough, more would not help"
            ));
        }
        if !matches!(stage, Stage::ReadyToCommit | Stage::Failed(_)) {
            self.say(&stage_text(stage));
        }
    }

    fn say(&self, text: &str) {
        if !self.globals.quiet {
            // A remark that cannot be shown is no reason to fail.
            let _ = writeln!(io::stderr(), "{text}");
        }
    }
}

//! A calibration under way, as people see it.

use std::io::{self, Write};

use quadcal::recalibrate::Stage;
use quadcal::wire::Status;

use crate::device::stage_text;

use super::super::Globals;
use super::super::progress::Progress;

/// Progress stage by stage: a remark as each begins, and a bar within it.
pub(super) struct Shown {
    globals: Globals,
    stage: Option<Stage>,
    progress: Option<Progress>,
}

impl Shown {
    pub fn new(globals: Globals) -> Self {
        Self {
            globals,
            stage: None,
            progress: None,
        }
    }

    pub fn show(&mut self, status: &Status) {
        let stage = status.stage;
        if self.stage != Some(stage) {
            self.progress = None;
            self.stage = Some(stage);
            self.begin(stage);
        }
        let (done, whole) = match stage {
            Stage::Solving => (status.solved_percent.into(), 100),
            _ => (status.turns.into(), status.turns_wanted.into()),
        };
        if let Some(progress) = &mut self.progress {
            progress.of(done, whole);
        }
    }

    fn begin(&mut self, stage: Stage) {
        let bar = match stage {
            Stage::Learning => Some(("Learning", "turns")),
            Stage::Solving => Some(("Solving", "%")),
            Stage::Proving => Some(("Proving", "turns")),
            _ => None,
        };
        self.progress = bar.map(|(what, unit)| Progress::count(what, unit, None, self.globals));
        if !self.globals.quiet && !matches!(stage, Stage::ReadyToCommit | Stage::Failed(_)) {
            // A remark that cannot be shown is no reason to fail.
            let _ = writeln!(io::stderr(), "{}", stage_text(stage));
        }
    }
}

//! `quadcal device recalibrate`: the whole of it, from the start to the table in flash.

use std::io::{self, Write};
use std::mem;
use std::time::SystemTime;

use clap::{Args, value_parser};
use quadcal::recalibrate::{Options, SpeedWindow, Stage};
use quadcal::units::RAD_PER_TURN32;
use quadcal::wire::{Identity, Status, TableInfo};

use crate::device::{Calibrated, Calibration, Fault, Watching, stage_text};

use super::super::Globals;
use super::super::failure::Failure;
use super::super::output::{Facts, JsonArg};
use super::super::progress::Progress;
use super::line::{AnyClient, LineArgs};
use super::summary::{
    CalibrationSummary, FailureSummary, LearnedSummary, ProofSummary, TableSummary,
};
use super::{EXIT_CODES, ask, facts, interrupt};

const EXAMPLES: &str = "\
Examples:
  quadcal device recalibrate --port /dev/ttyACM0 --key-file drive.key
  quadcal device recalibrate --port /dev/ttyACM0 --turns 16 --goal 5e-6 --commit
  quadcal device recalibrate --port /dev/ttyACM0 --pole-pairs 5 --from 200 --to 800
  quadcal device recalibrate --port unix:/tmp/drive --no-commit --json - | jq .proof

Let the shaft turn evenly, best in torque or voltage mode and at two speeds, one half as fast again
as the other. The device learns, works the table out, and holds it against the old one on fresh
turns; only a better one can be committed, which is asked for, or done with --commit. Meanwhile the
old table goes on correcting. Ctrl-C ends the calibration, and the old table stays.

";

/// Learn the encoder again, prove the new table on fresh turns, and commit it
#[derive(Debug, Args)]
#[command(after_help = [EXAMPLES, EXIT_CODES].concat())]
pub(super) struct Recalibrate {
    /// Turns to learn from at the most
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = value_parser!(u16).range(6..), help_heading = "Learning")]
    turns: u16,
    /// Stop learning once the error to expect is this small, rad RMS
    #[arg(long, value_name = "RAD", value_parser = goal, help_heading = "Learning")]
    goal: Option<f64>,
    /// Fresh turns to prove the table on
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = value_parser!(u8).range(4..), help_heading = "Learning")]
    proof_turns: u8,
    /// Slowest speed to learn at, r/min
    #[arg(long, value_name = "R_MIN", value_parser = speed, help_heading = "Learning")]
    from: Option<u32>,
    /// Fastest speed to learn at, r/min
    #[arg(long, value_name = "R_MIN", value_parser = speed, help_heading = "Learning")]
    to: Option<u32>,
    /// Pole pairs of the motor, where nothing else makes torque: ripple is at multiples of N only
    #[arg(long, value_name = "N", value_parser = value_parser!(u16).range(1..), help_heading = "Drive")]
    pole_pairs: Option<u16>,
    /// Leave orders up to N alone, as a speed loop may hide them
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Drive")]
    hidden_up_to: u16,
    /// Commit a better table without asking
    #[arg(long, conflicts_with = "no_commit")]
    commit: bool,
    /// Leave a better table waiting, to be committed later
    #[arg(long)]
    no_commit: bool,
    #[command(flatten)]
    json: JsonArg,
}

fn goal(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value < 1.0 => Ok(value),
        _ => Err("give a number above 0 and below 1, in rad: 2e-6".to_owned()),
    }
}

/// r/min in thousandths.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn speed(text: &str) -> Result<u32, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.001..=4e6).contains(&value) => Ok((value * 1000.0).round() as u32),
        _ => Err("give a speed in r/min, from 0.001 to 4000000".to_owned()),
    }
}

/// What becomes of a table that waits.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Decision {
    Commit,
    Leave,
    GiveUp,
}

impl Recalibrate {
    pub fn run(self, line: &LineArgs, globals: Globals) -> Result<(), Failure> {
        let mut client = line.commander()?;
        let identity = client.identify()?;
        interrupt::catch();
        let mut shown = Shown::new(globals);
        let calibration = client.calibrate(&self.options(), |status| {
            shown.show(status);
            if interrupt::asked() {
                Watching::Stop
            } else {
                Watching::GoOn
            }
        })?;
        drop(shown);
        interrupt::release();
        let mut facts = Facts::default();
        facts.push("Port", client.name());
        if let Some(learned) = &calibration.learned {
            facts::learned(&mut facts, learned);
        }
        if let Some(figures) = &calibration.figures {
            facts::proof(&mut facts, figures);
        }
        match calibration.end {
            Calibrated::Waiting => self.decide(client, &identity, &calibration, facts),
            Calibrated::Failed(failure) => {
                facts.push("Outcome", "no new table; the one in use is as before");
                let summary = summary(&client, "failed", &identity, &calibration, None);
                client.close();
                self.json.write(&summary, &facts)?;
                Err(Fault::Failed(failure).at(client.name()).into())
            }
            Calibrated::Stopped => {
                facts.push("Outcome", "stopped; the table in use is as before");
                let summary = summary(&client, "stopped", &identity, &calibration, None);
                client.close();
                self.json.write(&summary, &facts)?;
                Err(Failure::Stopped)
            }
        }
    }

    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    fn options(&self) -> Options {
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        Options {
            turns: self.turns,
            // Below 1 rad, which is less than 2^32.
            goal: self
                .goal
                .map_or(0, |rad| ((rad / RAD_PER_TURN32) as u32).max(1)),
            proof_turns: self.proof_turns,
            torque_base: self.pole_pairs.unwrap_or(0),
            hidden_up_to: self.hidden_up_to,
            window: SpeedWindow {
                from: self.from.unwrap_or(SpeedWindow::ANY.from),
                to: self.to.unwrap_or(SpeedWindow::ANY.to),
            },
            date: now.map_or(0, |now| now.as_secs()),
        }
    }

    /// What is to become of the table that waits, shown before it is asked for.
    fn decision(&self, facts: &mut Facts) -> Decision {
        if self.commit {
            return Decision::Commit;
        }
        if self.no_commit || !ask::possible() {
            return Decision::Leave;
        }
        // The figures are needed to decide by, and are not printed twice.
        let figures = mem::take(facts);
        let _ = write!(io::stderr(), "{figures}");
        match ask::yes("Commit the new table?") {
            Some(true) => Decision::Commit,
            Some(false) => Decision::GiveUp,
            None => Decision::Leave,
        }
    }

    fn decide(
        &self,
        mut client: AnyClient,
        identity: &Identity,
        calibration: &Calibration,
        mut facts: Facts,
    ) -> Result<(), Failure> {
        let (outcome, table) = match self.decision(&mut facts) {
            Decision::Commit => {
                let table = client.commit()?;
                facts.push("Outcome", "the new table is in flash and in use");
                facts::table(&mut facts, table.as_ref());
                ("committed", table)
            }
            Decision::Leave => {
                facts.push(
                    "Outcome",
                    "the new table waits; 'quadcal device commit' makes it count",
                );
                ("waiting", None)
            }
            Decision::GiveUp => {
                client.change("abort", &quadcal::wire::Request::Abort)?;
                facts.push("Outcome", "given up; the table in use is as before");
                ("given_up", None)
            }
        };
        let summary = summary(&client, outcome, identity, calibration, table.as_ref());
        client.close();
        self.json.write(&summary, &facts)
    }
}

fn summary(
    client: &AnyClient,
    outcome: &'static str,
    identity: &Identity,
    calibration: &Calibration,
    table: Option<&TableInfo>,
) -> CalibrationSummary {
    let learned = calibration.learned.as_ref();
    CalibrationSummary {
        port: client.name().to_owned(),
        outcome,
        failure: match &calibration.end {
            Calibrated::Failed(failure) => Some(FailureSummary::new(failure)),
            _ => None,
        },
        learned: learned.map(|learned| LearnedSummary::new(learned, identity)),
        proof: calibration.figures.as_ref().map(ProofSummary::new),
        table: table.map(TableSummary::new),
    }
}

/// Progress stage by stage: a remark as each begins, and a bar within it.
struct Shown {
    globals: Globals,
    stage: Option<Stage>,
    progress: Option<Progress>,
}

impl Shown {
    fn new(globals: Globals) -> Self {
        Self {
            globals,
            stage: None,
            progress: None,
        }
    }

    fn show(&mut self, status: &Status) {
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

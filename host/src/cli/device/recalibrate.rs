//! `quadcal device recalibrate`: the whole of it, from the start to the table in flash.

use std::time::SystemTime;

use clap::{Args, value_parser};
use quadcal::recalibrate::{Failure as Reason, Options, SpeedWindow, Waiting};
use quadcal::units::RAD_PER_TURN32;
use quadcal::wire::Identity;

use crate::device::{Calibrated, Calibration, Fault, Watching};

use super::super::Globals;
use super::super::failure::Failure;
use super::super::output::{Facts, JsonArg};
use super::ask::Answer;
use super::following::{Shown, waits};
use super::line::{AnyClient, LineArgs};
use super::pace::Pace;
use super::summary::{
    CalibrationSummary, FailureSummary, LearnedSummary, ProofSummary, TableSummary,
};
use super::{EXIT_CODES, ask, committing, facts, interrupt};

const EXAMPLES: &str = "\
Examples:
  quadcal device recalibrate --port /dev/ttyACM0 --key-file drive.key
  quadcal device recalibrate --port /dev/ttyACM0 --turns 16 --goal 5e-6 --commit
  quadcal device recalibrate --port /dev/ttyACM0 --pole-pairs 5 --from 200 --to 800
  quadcal device recalibrate --port unix:/tmp/drive --no-commit --json - | jq .proof

Let the shaft turn evenly, best in torque or voltage mode and at two speeds, one half as fast again
as the other. The device learns, works the table out, and holds it against the old one on fresh
turns; only a better one can be committed, which is asked for, or done with --commit. Meanwhile the
old table goes on correcting. Ctrl-C ends the calibration, at the question too, and the old table
stays. A drive that commits only at rest leaves the table waiting: bring it to rest, then
'quadcal device commit'.

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
    Stop,
}

impl Recalibrate {
    pub fn run(self, line: &LineArgs, globals: Globals) -> Result<(), Failure> {
        let mut client = line.commander()?;
        let identity = client.identify()?;
        interrupt::catch();
        let mut shown = Shown::new(globals);
        let options = self.options();
        let mut pace = Pace::new(options.window, identity.clock_hz);
        let calibration = client.calibrate_with(&options, |client, status| {
            // Where this look fails for good, the next status says so.
            if waits(status.stage)
                && let Ok(live) = client.live()
            {
                pace.take(&live);
            }
            shown.show(status, &pace);
            Ok(if interrupt::asked() {
                Watching::Stop
            } else {
                Watching::GoOn
            })
        })?;
        drop(shown);
        let mut facts = Facts::default();
        facts.push("Port", client.name());
        if let Some(learned) = &calibration.learned {
            facts::learned(&mut facts, learned);
            if learned.turns < self.turns.into() {
                facts.push("  Ended early", self.ended_early());
            }
        }
        if let Some(figures) = &calibration.figures {
            facts::proof(&mut facts, figures);
        }
        match calibration.end {
            Calibrated::Waiting => self.decide(client, &identity, &calibration, facts),
            Calibrated::Failed(failure) => {
                facts.push("Outcome", "no new table; the one in use is as before");
                let summary = summary(client.name(), "failed", &identity, &calibration);
                self.json.write(&summary, &facts)?;
                Err(match (failure, pace.missed()) {
                    (Reason::TimedOut(Waiting::Speed), Some(speed)) => Failure::OutOfWindow {
                        port: client.name().to_owned(),
                        speed,
                        window: options.window,
                    },
                    _ => Fault::Failed(failure).at(client.name()).into(),
                })
            }
            Calibrated::Stopped => {
                facts.push("Outcome", "stopped; the table in use is as before");
                let summary = summary(client.name(), "stopped", &identity, &calibration);
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

    /// Why it learned from fewer turns than it might have.
    fn ended_early(&self) -> String {
        let why = match self.goal {
            Some(_) => "the goal is reached, or more would not help",
            None => "more would not help",
        };
        format!("of {} turns at the most: {why}", self.turns)
    }

    /// What is to become of the table that waits, shown before it is asked for.
    fn decision(&self, facts: &mut Facts) -> Decision {
        if interrupt::asked() {
            return Decision::Stop;
        }
        if self.commit {
            return Decision::Commit;
        }
        if self.no_commit {
            return Decision::Leave;
        }
        let figures = facts.to_string();
        let answer = ask::yes(&figures, "Commit the new table?");
        if answer != Answer::Nobody {
            // What was decided by is not printed twice.
            *facts = Facts::default();
        }
        match answer {
            Answer::Yes => Decision::Commit,
            Answer::No => Decision::GiveUp,
            Answer::Stop => Decision::Stop,
            Answer::Nobody => Decision::Leave,
        }
    }

    fn decide(
        &self,
        mut client: AnyClient,
        identity: &Identity,
        calibration: &Calibration,
        mut facts: Facts,
    ) -> Result<(), Failure> {
        let decision = self.decision(&mut facts);
        interrupt::release();
        let port = client.name().to_owned();
        let show = |outcome, facts: &Facts| {
            let summary = summary(&port, outcome, identity, calibration);
            self.json.write(&summary, facts)
        };
        match decision {
            Decision::Commit => {
                let committed = committing::commit(&mut client);
                committed.describe(&mut facts);
                let mut summary = summary(&port, committed.outcome(), identity, calibration);
                summary.table = committed.table().map(TableSummary::new);
                summary.failure = committed.reason().map(FailureSummary::new);
                self.json.write(&summary, &facts)?;
                committed.end()
            }
            Decision::Leave => {
                facts.push("Outcome", committing::waits_text());
                show("waiting", &facts)
            }
            Decision::GiveUp | Decision::Stop => {
                client.change("abort", &quadcal::wire::Request::Abort)?;
                facts.push("Outcome", "given up; the table in use is as before");
                if decision == Decision::GiveUp {
                    return show("given_up", &facts);
                }
                show("stopped", &facts)?;
                Err(Failure::Stopped)
            }
        }
    }
}

fn summary(
    port: &str,
    outcome: &'static str,
    identity: &Identity,
    calibration: &Calibration,
) -> CalibrationSummary {
    let learned = calibration.learned.as_ref();
    CalibrationSummary {
        port: port.to_owned(),
        outcome,
        failure: match &calibration.end {
            Calibrated::Failed(failure) => Some(FailureSummary::new(failure)),
            _ => None,
        },
        learned: learned.map(|learned| LearnedSummary::new(learned, identity)),
        proof: calibration.figures.as_ref().map(ProofSummary::new),
        table: None,
    }
}

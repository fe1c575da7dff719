//! `quadcal device commit`, `abort`, `rollback`, `erase` and `log-level`: one command to the device each.

use clap::{Args, ValueEnum};
use quadcal::wire::{LogLevel, Request};

use super::super::failure::Failure;
use super::super::output::{Facts, JsonArg};
use super::line::{AnyClient, LineArgs};
use super::summary::{ChangeSummary, level_name};
use super::{EXIT_CODES, ask, committing, facts};
use crate::device::stage_text;

/// Says what was done and how things stand now.
fn report(
    mut client: AnyClient,
    json: &JsonArg,
    done: &'static str,
    text: &str,
) -> Result<(), Failure> {
    let status = client.status()?;
    let mut facts = Facts::default();
    facts
        .push("Port", client.name())
        .push("Done", text)
        .push("Calibration", stage_text(status.stage));
    facts::table(&mut facts, status.table.as_ref());
    json.write(&ChangeSummary::new(client.name(), done, &status), &facts)
}

const COMMIT_EXAMPLES: &str = "\
Examples:
  quadcal device preview --port /dev/ttyACM0
  quadcal device commit --port /dev/ttyACM0 --key-file drive.key

The table that was in use before stays in flash: 'quadcal device rollback' brings it back. The
drive may insist on standstill while flash is written.

";

/// Write the table that waits to flash and use it
#[derive(Debug, Args)]
#[command(after_help = [COMMIT_EXAMPLES, EXIT_CODES].concat())]
pub(super) struct Commit {
    #[command(flatten)]
    json: JsonArg,
}

impl Commit {
    pub fn run(self, line: &LineArgs) -> Result<(), Failure> {
        let mut client = line.commander()?;
        committing::commit(&mut client).end()?;
        report(
            client,
            &self.json,
            "commit",
            "the table is in flash and in use",
        )
    }
}

const ABORT_EXAMPLES: &str = "\
Examples:
  quadcal device abort --port /dev/ttyACM0 --key-file drive.key

";

/// End a calibration, or give up a table that waits to be committed
#[derive(Debug, Args)]
#[command(after_help = [ABORT_EXAMPLES, EXIT_CODES].concat())]
pub(super) struct Abort {
    #[command(flatten)]
    json: JsonArg,
}

impl Abort {
    pub fn run(self, line: &LineArgs) -> Result<(), Failure> {
        let mut client = line.commander()?;
        client.change("abort", &Request::Abort)?;
        report(
            client,
            &self.json,
            "abort",
            "nothing waits; the table in use is as before",
        )
    }
}

const ROLLBACK_EXAMPLES: &str = "\
Examples:
  quadcal device rollback --port /dev/ttyACM0 --key-file drive.key

The table in use is withdrawn for good; dump it first where it may be wanted again.

";

/// Withdraw the table in use and go back to the one before
#[derive(Debug, Args)]
#[command(after_help = [ROLLBACK_EXAMPLES, EXIT_CODES].concat())]
pub(super) struct Rollback {
    #[command(flatten)]
    json: JsonArg,
}

impl Rollback {
    pub fn run(self, line: &LineArgs) -> Result<(), Failure> {
        let mut client = line.commander()?;
        client.change("rollback", &Request::RollBack)?;
        report(
            client,
            &self.json,
            "rollback",
            "the table before is in use again",
        )
    }
}

const ERASE_EXAMPLES: &str = "\
Examples:
  quadcal device dump --port /dev/ttyACM0 -o before.qct
  quadcal device erase --port /dev/ttyACM0 --key-file drive.key --yes

";

/// Erase all tables: the encoder then runs uncorrected
#[derive(Debug, Args)]
#[command(after_help = [ERASE_EXAMPLES, EXIT_CODES].concat())]
pub(super) struct Erase {
    /// Don't ask whether it is meant
    #[arg(long)]
    yes: bool,
    #[command(flatten)]
    json: JsonArg,
}

impl Erase {
    pub fn run(self, line: &LineArgs) -> Result<(), Failure> {
        if !self.yes {
            match ask::yes("", "Erase all tables of the device?") {
                ask::Answer::Yes => {}
                ask::Answer::Nobody => return Err(Failure::NotConfirmed),
                ask::Answer::No | ask::Answer::Stop => {
                    let text = "nothing, as answered";
                    return report(line.reader()?, &self.json, "nothing", text);
                }
            }
        }
        let mut client = line.commander()?;
        client.change("erase", &Request::Erase)?;
        report(client, &self.json, "erase", "all tables are erased")
    }
}

/// How much a device logs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Level {
    /// Nothing
    Off,
    /// What went wrong
    Error,
    /// What may go wrong
    Warn,
    /// What was done
    Info,
    /// Turn by turn
    Debug,
}

impl From<Level> for LogLevel {
    fn from(level: Level) -> Self {
        match level {
            Level::Off => Self::Off,
            Level::Error => Self::Error,
            Level::Warn => Self::Warn,
            Level::Info => Self::Info,
            Level::Debug => Self::Debug,
        }
    }
}

const LOG_EXAMPLES: &str = "\
Examples:
  quadcal device log-level debug --port /dev/ttyACM0 --key-file drive.key

The level holds until the device restarts.

";

/// Set how much the device logs
#[derive(Debug, Args)]
#[command(after_help = [LOG_EXAMPLES, EXIT_CODES].concat())]
pub(super) struct SetLogLevel {
    /// Level
    level: Level,
    #[command(flatten)]
    json: JsonArg,
}

impl SetLogLevel {
    pub fn run(self, line: &LineArgs) -> Result<(), Failure> {
        let level = LogLevel::from(self.level);
        let mut client = line.commander()?;
        client.change("log-level", &Request::LogLevel(level))?;
        let text = format!("the device logs at level {}", level_name(level));
        report(client, &self.json, "log-level", &text)
    }
}

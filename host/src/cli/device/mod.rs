//! `quadcal device`: a drive's calibration service, over its port.

mod ask;
mod changes;
mod chart;
mod committing;
mod facts;
mod following;
mod interrupt;
mod line;
pub(super) mod pace;
mod read;
mod recalibrate;
mod summary;
mod tables;
mod watch;

use clap::{Args, Subcommand};

use super::Globals;
use super::failure::Failure;
use line::LineArgs;

/// What holds for all of these commands, shown below their options.
const EXIT_CODES: &str = "\
Exit codes:
  0  done
  1  the device refuses, no better table came of it, it was stopped, or an output cannot be written
  2  the command line, the key or a file is wrong; nothing was changed
  3  the device cannot be reached or does not answer
  130  ended at once by Ctrl-C; what the device had begun goes on, see 'quadcal device status'";

const EXAMPLES: &str = "\
Examples:
  quadcal device identify --port /dev/ttyACM0
  quadcal device status --port tcp:localhost:4444         QEMU with -serial tcp::4444,server
  quadcal device watch --port unix:/tmp/drive --seconds 10
  quadcal device recalibrate --port /dev/ttyACM0 --key-file drive.key
  quadcal device dump --port /dev/ttyACM0 -o drive.qct    the table in use, as a file

PORT is a serial port, unix:PATH or tcp:HOST:PORT; QUADCAL_PORT names it once for all. Reading needs
no key. What changes the device needs its key: --key-file, or QUADCAL_KEY with 64 hexadecimal
digits. Fields of the JSON: docs/device-json.md.

";

/// Ask a drive over its port, recalibrate it, and keep its table
#[derive(Debug, Args)]
#[command(after_help = [EXAMPLES, EXIT_CODES].concat(), disable_help_subcommand = true)]
pub struct Device {
    #[command(flatten)]
    line: LineArgs,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Identify(read::Identify),
    Status(read::Status),
    Watch(watch::Watch),
    Recalibrate(recalibrate::Recalibrate),
    Preview(read::Preview),
    Commit(changes::Commit),
    Abort(changes::Abort),
    Rollback(changes::Rollback),
    Dump(tables::Dump),
    Load(tables::Load),
    Erase(changes::Erase),
    LogLevel(changes::SetLogLevel),
}

impl Device {
    /// Does what was asked.
    pub fn run(self, globals: Globals) -> Result<(), Failure> {
        let line = self.line;
        match self.command {
            Command::Identify(command) => command.run(&line),
            Command::Status(command) => command.run(&line),
            Command::Watch(command) => command.run(&line, globals),
            Command::Recalibrate(command) => command.run(&line, globals),
            Command::Preview(command) => command.run(&line),
            Command::Commit(command) => command.run(&line),
            Command::Abort(command) => command.run(&line),
            Command::Rollback(command) => command.run(&line),
            Command::Dump(command) => command.run(&line, globals),
            Command::Load(command) => command.run(&line, globals),
            Command::Erase(command) => command.run(&line),
            Command::LogLevel(command) => command.run(&line),
        }
    }
}

//! The `quadcal` command line: what can be asked for, one file a command, and the pieces they share.

mod calibrate;
mod calibrate_facts;
mod calibrate_summary;
mod completions;
mod convert;
mod demo;
mod device;
mod diagnose;
pub mod failure;
mod footer;
mod hints;
mod info;
pub mod input;
mod locate;
mod loop_args;
pub mod output;
pub mod progress;
mod sensor_args;
mod simulate;
mod simulated;
mod staged;
mod started;
mod table_arg;
mod tally;
mod twin;
mod verify;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use failure::Failure;

/// What holds for every command, shown below its options.
const EXIT_CODES: &str = "\
Exit codes:
  0  done
  1  the result fails its check, or an output cannot be written
  2  the input or the command line is wrong; no output file is written";

/// Examples of the whole tool.
const EXAMPLES: &str = "\
Examples:
  quadcal demo                                simulated and real encoders, with a report
  quadcal calibrate spindle.csv -o spindle.qct --report spindle.html
  quadcal verify spindle.csv --table spindle.qct
  quadcal locate spindle.csv --table spindle.qct
  quadcal twin rig.csv -o rig.toml            a twin from the recording alone
  quadcal diagnose rig.csv --twin rig.toml --report rig.html
  quadcal info spindle.csv                    what a recording holds
  quadcal convert capture.vcd -o capture.csv  from one format to another
  quadcal device recalibrate --port /dev/ttyACM0

'quadcal COMMAND --help' explains a command, with examples.";

/// Make an incremental encoder as good as its own edges allow.
///
/// Learns an encoder's own errors from the times of its edges and removes them from angle and speed.
#[derive(Debug, Parser)]
#[command(
    name = "quadcal",
    version,
    max_term_width = 100,
    arg_required_else_help = true,
    disable_help_subcommand = true,
    after_help = [EXAMPLES, "\n\n", EXIT_CODES].concat()
)]
pub struct Cli {
    #[command(flatten)]
    globals: Globals,
    #[command(subcommand)]
    command: Command,
}

/// Options of every command.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct Globals {
    /// Print results and errors only: no progress bar, no remarks
    #[arg(short, long, global = true)]
    pub quiet: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    Demo(demo::Demo),
    Simulate(simulate::Simulate),
    Calibrate(calibrate::Calibrate),
    Verify(verify::Verify),
    Locate(locate::Locate),
    Twin(twin::Twin),
    Diagnose(diagnose::Diagnose),
    Info(info::Info),
    Convert(convert::Convert),
    Device(device::Device),
    Completions(completions::Completions),
}

/// Runs the command this process was started with and says how it ended: 0 done, 1 the result fails its check or an output cannot
/// be written, 2 the input or the command line is wrong.
#[must_use]
pub fn run() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help goes to stdout and may meet a closed pipe, which is no failure.
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { 2 } else { 0 });
        }
    };
    match cli.run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

impl Cli {
    fn run(self) -> Result<(), Failure> {
        let globals = self.globals;
        match self.command {
            Command::Demo(command) => command.run(globals),
            Command::Simulate(command) => command.run(globals),
            Command::Calibrate(command) => command.run(globals),
            Command::Verify(command) => command.run(globals),
            Command::Locate(command) => command.run(globals),
            Command::Twin(command) => command.run(globals),
            Command::Diagnose(command) => command.run(globals),
            Command::Info(command) => command.run(globals),
            Command::Convert(command) => command.run(globals),
            Command::Device(command) => command.run(globals),
            Command::Completions(command) => command.run(),
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_command_shows_examples_and_exit_codes() {
        fn check(command: &clap::Command, path: &str) {
            for command in command.get_subcommands() {
                let help = command.get_after_help().map(ToString::to_string);
                let help = help.unwrap_or_default();
                let path = format!("{path} {}", command.get_name());
                assert!(help.contains(&format!("{path} ")), "{path}: {help}");
                assert!(help.contains("Exit codes:"), "{path}: {help}");
                check(command, &path);
            }
        }
        check(&Cli::command(), "quadcal");
    }
}

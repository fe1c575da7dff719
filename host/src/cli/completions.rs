//! `quadcal completions`: a completion script for a shell.

use clap::{Args, CommandFactory};
use clap_complete::Shell;

use super::failure::Failure;
use super::output::Target;
use super::{Cli, EXIT_CODES};

const EXAMPLES: &str = "\
Examples:
  quadcal completions bash > ~/.local/share/bash-completion/completions/quadcal
  quadcal completions fish > ~/.config/fish/completions/quadcal.fish

";

/// Print a completion script for a shell
#[derive(Debug, Args)]
#[command(after_help = [EXAMPLES, EXIT_CODES].concat())]
pub struct Completions {
    /// Shell to complete for
    shell: Shell,
}

impl Completions {
    /// Prints the script.
    pub fn run(self) -> Result<(), Failure> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "quadcal", &mut script);
        Target::Stdout.write(&script)
    }
}

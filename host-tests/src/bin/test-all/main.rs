//! Every check there is, from a clean clone: `cargo test-all`.
#![forbid(unsafe_code)]

mod prerequisites;
mod steps;

use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Parser;
use steps::{Failure, STEPS, Step};

/// Checks, builds and tests everything, firmware in QEMU included; installs or names what is missing.
#[derive(Parser)]
#[command(name = "cargo test-all", bin_name = "cargo test-all")]
struct Options {
    /// Do this step alone; may be given again for more.
    #[arg(long, value_name = "STEP", value_parser = step)]
    only: Vec<&'static Step>,
    /// List the steps and end.
    #[arg(long)]
    list: bool,
}

fn step(name: &str) -> Result<&'static Step, String> {
    STEPS
        .iter()
        .find(|step| step.name == name)
        .ok_or_else(|| "no such step; see --list".to_owned())
}

struct Done {
    step: &'static Step,
    time: Duration,
    result: Result<(), Failure>,
}

fn main() -> ExitCode {
    let options = Options::parse();
    if options.list {
        for step in STEPS {
            println!("{:<14} {}", step.name, step.about);
        }
        return ExitCode::SUCCESS;
    }
    let wanted = STEPS.iter().filter(|step| {
        options.only.is_empty() || options.only.iter().any(|only| only.name == step.name)
    });
    let mut done = Vec::new();
    for step in wanted {
        println!("\n==> {}: {}", step.name, step.about);
        let begin = Instant::now();
        let result = (step.run)();
        if let Err(failure) = &result {
            eprintln!("{failure}");
        }
        done.push(Done {
            step,
            time: begin.elapsed(),
            result,
        });
    }
    summary(&done);
    ExitCode::from(u8::from(done.iter().any(|done| done.result.is_err())))
}

fn summary(done: &[Done]) {
    println!("\n{:<14} {:>8}  result", "step", "time");
    for done in done {
        let result = if done.result.is_ok() { "ok" } else { "FAILED" };
        println!(
            "{:<14} {:>6.1} s  {result}",
            done.step.name,
            done.time.as_secs_f64()
        );
    }
    let total: Duration = done.iter().map(|done| done.time).sum();
    println!("{:<14} {:>6.1} s", "total", total.as_secs_f64());
    for done in done {
        if let Err(failure) = &done.result {
            println!("{}: {failure}", done.step.name);
        }
    }
}

//! A drive in QEMU, recalibrated by command: `cargo run --release -p quadcal-host-tests --bin field-trial`.
#![forbid(unsafe_code)]

use std::fmt::Write as _;
use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use clap::{Parser, value_parser};
use quadcal::recalibrate::Stage;
use quadcal::units::RAD_PER_TURN32;
use quadcal::wire::{Status, TableInfo};
use quadcal_host::device::stage_text;
use quadcal_host::report::si;
use quadcal_host_tests::field_trial::drive::{KEY, LINES};
use quadcal_host_tests::field_trial::ripple::{Answers, Ripple};
use quadcal_host_tests::field_trial::{Bench, GAIN_LEAST, Outcome, Progress, Trial};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// Examples and exit codes.
const AFTER_HELP: &str = "\
Examples:
  cargo run --release -p quadcal-host-tests --bin field-trial
  cargo run --release -p quadcal-host-tests --bin field-trial -- --seed 7 --speed 120
  cargo run --release -p quadcal-host-tests --bin field-trial -- --stay     # then try 'quadcal device watch' on it

Exit codes:
  0  the speed from flash is corrected, its ripple at most a tenth
  1  it is not, or something failed
  2  the command line is wrong";

/// Time between two looks at a drive that stays on.
const LOOK: Duration = Duration::from_millis(200);

/// Recalibrate a drive in QEMU by command.
///
/// Builds the firmware, starts it in QEMU on empty flash with a simulated, badly made encoder of 2500 lines turning behind it in real time,
/// and then does over its port what a technician would: looks at the speed, recalibrates, commits, cuts the power, and looks again.
#[derive(Debug, Parser)]
#[command(after_help = AFTER_HELP, max_term_width = 100)]
struct Options {
    /// Seed of the encoder's errors and the shaft's wander
    #[arg(long, value_name = "N", default_value_t = Trial::default().seed)]
    seed: u64,
    /// Speed of the shaft, r/min, from 60 to 600
    #[arg(long, value_name = "R_MIN", default_value_t = Trial::default().r_min, value_parser = speed)]
    speed: f64,
    /// Turns to learn from
    #[arg(long, value_name = "N", default_value_t = Trial::default().turns, value_parser = value_parser!(u16).range(6..=100))]
    turns: u16,
    /// Fresh turns to prove the table on
    #[arg(long, value_name = "N", default_value_t = Trial::default().proof_turns, value_parser = value_parser!(u8).range(4..))]
    proof_turns: u8,
    /// Leave the drive on at the end, to try 'quadcal device' on
    #[arg(long)]
    stay: bool,
}

fn speed(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (60.0..=600.0).contains(&value) => Ok(value),
        _ => Err("give r/min from 60 to 600".to_owned()),
    }
}

fn main() -> anyhow::Result<ExitCode> {
    let options = Options::parse();
    let trial = Trial {
        seed: options.seed,
        r_min: options.speed,
        turns: options.turns,
        proof_turns: options.proof_turns,
        ..Trial::default()
    };
    println!("Building the firmware; a first build takes a minute.");
    let mut screen = Screen::new();
    let (outcome, bench) = trial.run(|progress| screen.show(&trial, &progress))?;
    print!("\n{}", table(&outcome)?);
    if options.stay {
        stay(bench)?;
    }
    Ok(if outcome.is_better() {
        ExitCode::SUCCESS
    } else {
        eprintln!("error: the ripple of the speed is not smaller by {GAIN_LEAST} times");
        ExitCode::FAILURE
    })
}

/// Keeps the drive on until Enter; where standard input is at its end, until a signal comes or the drive ends.
fn stay(mut bench: Bench) -> io::Result<()> {
    let key: String = KEY.iter().map(|byte| format!("{byte:02x}")).collect();
    println!("\nThe drive stays on; Enter or Ctrl-C switches it off. In another shell:");
    let port = bench.drive.address();
    println!("  export QUADCAL_PORT={port} QUADCAL_KEY={key}");
    println!("  quadcal device status\n  quadcal device watch");
    let asked = Arc::new(AtomicBool::new(false));
    if io::stdin().read_line(&mut String::new())? == 0 {
        for signal in [SIGINT, SIGTERM] {
            flag::register(signal, Arc::clone(&asked))?;
        }
        while !asked.load(Ordering::Relaxed) && bench.drive.is_on() {
            thread::sleep(LOOK);
        }
    }
    if !asked.load(Ordering::Relaxed) && !bench.drive.is_on() {
        eprintln!("error: the drive has ended by itself");
    }
    Ok(())
}

/// What goes on, line by line; on a terminal the line of what is going on is drawn anew.
struct Screen {
    begin: Instant,
    stage: Stage,
    live: bool,
}

impl Screen {
    fn new() -> Self {
        Self {
            begin: Instant::now(),
            stage: Stage::Idle,
            live: io::stdout().is_terminal(),
        }
    }

    fn show(&mut self, trial: &Trial, progress: &Progress) {
        match progress {
            Progress::Started => {
                self.begin = Instant::now();
                self.say(&format!(
                    "on: QEMU with empty flash; {LINES} lines, badly made (seed {}), at {} r/min behind it",
                    trial.seed, trial.r_min
                ));
            }
            Progress::Uncorrected(ripple) => {
                self.say(&format!("no table: {}", speed_text(ripple)));
            }
            Progress::Calibrating(status) => self.follow(status),
            Progress::Proven(learned, figures) => {
                self.say(&format!(
                    "learned from {} turns; expected to be left {}",
                    learned.turns,
                    rad(learned.standard_error)
                ));
                self.say(&format!(
                    "on {} fresh turns, from edge to edge: {} off without a table, {} with the new one",
                    figures.turns,
                    rad(figures.old.interval),
                    rad(figures.new.interval)
                ));
            }
            Progress::Committed(table) => self.say(&format!("committed: {}", table_text(table))),
            Progress::Rebooted => {
                self.say("power cut (QEMU killed) and on again, with the same flash")
            }
            Progress::Corrected(table, ripple) => {
                self.say(&format!("from flash: {}", table_text(table)));
                self.say(&format!("with it: {}", speed_text(ripple)));
            }
        }
    }

    fn follow(&mut self, status: &Status) {
        let more = match status.stage {
            Stage::Learning | Stage::Proving => {
                format!(", {} of {} turns", status.turns, status.turns_wanted)
            }
            Stage::Solving => format!(", {} %", status.solved_percent),
            _ => String::new(),
        };
        let fresh = std::mem::replace(&mut self.stage, status.stage) != status.stage;
        if self.live {
            print!(
                "\r{}{more}\x1b[K",
                self.line(stage_text(status.stage).as_ref())
            );
            let _ = io::stdout().flush();
        } else if fresh {
            self.say(stage_text(status.stage).as_ref());
        }
    }

    fn line(&self, text: &str) -> String {
        format!("{:5.1} s  {text}", self.begin.elapsed().as_secs_f64())
    }

    fn say(&self, text: &str) {
        let (start, end) = if self.live {
            ("\r", "\x1b[K")
        } else {
            ("", "")
        };
        println!("{start}{}{end}", self.line(text));
    }
}

fn speed_text(ripple: &Ripple) -> String {
    format!(
        "{:.1} r/min, ripple {} RMS ({} samples)",
        ripple.r_min,
        percent(ripple.given),
        ripple.samples
    )
}

fn table_text(table: &TableInfo) -> String {
    let place = if table.place == 0 { "A" } else { "B" };
    format!(
        "table {} at place {place}, learned from {} turns",
        table.sequence, table.turns
    )
}

fn percent(share: f64) -> String {
    format!("{:.3} %", 100.0 * share)
}

/// 2^-32 turn in rad.
fn rad(turn32: u32) -> String {
    si(f64::from(turn32) * RAD_PER_TURN32, "rad")
}

/// Before and after, side by side.
fn table(outcome: &Outcome) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    let mut row =
        |name: &str, before: &str, after: &str| writeln!(text, "{name:<44}{before:>16}{after:>16}");
    let Outcome {
        before,
        meanwhile,
        figures,
        after,
        ..
    } = outcome;
    let sequence = format!("{}, from flash", outcome.table.sequence);
    row("", "before", "after reboot")?;
    row("table in use", "none", &sequence)?;
    row(
        "ripple of the speed handed out, RMS",
        &percent(before.given),
        &percent(after.given),
    )?;
    row(
        "ripple without the table, RMS",
        &percent(before.raw),
        &percent(after.raw),
    )?;
    row(
        "mean speed, r/min",
        &format!("{:.2}", before.r_min),
        &format!("{:.2}", after.r_min),
    )?;
    row(
        "edge to edge, on fresh turns, RMS",
        &rad(figures.old.interval),
        &rad(figures.new.interval),
    )?;
    row(
        "angle over the turn, on fresh turns, RMS *",
        &rad(figures.old.angle),
        &rad(figures.new.angle),
    )?;
    writeln!(
        text,
        "* what the shaft itself swings is in it\n\nThe ripple is {:.0} times smaller. While it learned, solved and proved, the speed was handed out as before: {} ({} samples).",
        before.given / after.given,
        percent(meanwhile.given),
        meanwhile.samples
    )?;
    for (what, answers) in [
        ("learning and proving", &outcome.answers_at_work),
        ("solving", &outcome.answers_solving),
    ] {
        if let Some((middle, longest)) = Answers::middle_and_longest(answers) {
            writeln!(
                text,
                "Answers while {what}: {} in the middle, {} at the longest.",
                milliseconds(middle),
                milliseconds(longest)
            )?;
        }
    }
    writeln!(
        text,
        "RAM: {} bytes of statics (72,288 of them to learn in), {} of stack at the deepest.",
        outcome.memory.statics, outcome.memory.stack
    )?;
    Ok(text)
}

fn milliseconds(time: Duration) -> String {
    format!("{:.1} ms", 1e3 * time.as_secs_f64())
}

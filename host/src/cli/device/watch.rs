//! `quadcal device watch`: the shaft as it turns, before and after correction.

mod course;
mod screen;

use std::io::{self, IsTerminal, Write};
use std::thread;
use std::time::{Duration, Instant};

use clap::Args;
use serde::Serialize;

use super::super::Globals;
use super::super::failure::Failure;
use super::super::output::{Facts, Output, Target};
use super::line::{LineArgs, seconds};
use super::{EXIT_CODES, interrupt};
use course::{Course, Sample, Summary};
use screen::Screen;

/// Longest time between two looks at whether Ctrl-C was pressed.
const ATTENTION: Duration = Duration::from_millis(50);

/// Multiples of it fill the range from 0 to 1 most evenly.
const GOLDEN_SHARE: f64 = 0.618_033_988_749_895;

const EXAMPLES: &str = "\
Examples:
  quadcal device watch --port /dev/ttyACM0
  quadcal device watch --port tcp:localhost:4444 --turns 20
  quadcal device watch --port /dev/ttyACM0 --seconds 5 --json - | jq .rev_per_min_after

Before correction is what the encoder shows as it is, after correction what the drive's loop gets.
The scatter is that from sample to sample, so that a change of the real speed hardly counts. On a
terminal it draws both, elsewhere it prints a line a sample. Ctrl-C ends it.

";

/// Draw the live speed before and after correction
#[derive(Debug, Args)]
#[command(after_help = [EXAMPLES, EXIT_CODES].concat())]
pub(super) struct Watch {
    /// End after about so many turns
    #[arg(long, value_name = "N", value_parser = turns)]
    turns: Option<f64>,
    /// End after so many seconds
    #[arg(long, value_name = "S", value_parser = seconds)]
    seconds: Option<Duration>,
    /// Samples a second, on the average
    #[arg(long, value_name = "HZ", default_value_t = 20.0, value_parser = rate)]
    rate: f64,
    /// Write JSON, an object a line: a sample each, and a summary at last; '-' prints it in place of the text
    #[arg(long, value_name = "PATH", help_heading = "Results")]
    json: Option<Target>,
}

fn turns(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("give a number above 0".to_owned()),
    }
}

fn rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.1..=1000.0).contains(&value) => Ok(value),
        _ => Err("give samples a second, from 0.1 to 1000".to_owned()),
    }
}

impl Watch {
    pub fn run(self, line: &LineArgs, globals: Globals) -> Result<(), Failure> {
        let mut client = line.reader()?;
        let identity = client.identify()?;
        interrupt::catch();
        let mut json = match &self.json {
            Some(target) => Some((target, target.create()?)),
            None => None,
        };
        let mut text = Text::new(self.json == Some(Target::Stdout), globals);
        let mut course = Course::new(identity.clock_hz);
        let started = Instant::now();
        let mut due = started;
        while !self.is_over(started, &course) {
            let sample = course.push(&client.live()?);
            if let Some((target, output)) = &mut json {
                write_line(output, &sample).map_err(|source| target.failed(source))?;
            }
            text.show(&sample, &course)
                .map_err(|source| Target::Stdout.failed(source))?;
            due += self.pause(course.samples());
            wait(due, started + self.seconds.unwrap_or(Duration::MAX / 4));
        }
        let summary = course.summary(client.name());
        if let Some((target, mut output)) = json {
            write_line(&mut output, &summary)
                .and_then(|()| output.commit())
                .map_err(|source| target.failed(source))?;
        }
        text.end(&summary)
    }

    /// Time from a sample to the next: uneven, or they would always meet the same places of the turn at many speeds.
    fn pause(&self, samples: u32) -> Duration {
        let share = (f64::from(samples) * GOLDEN_SHARE).fract();
        Duration::from_secs_f64((0.75 + 0.5 * share) / self.rate)
    }

    fn is_over(&self, started: Instant, course: &Course) -> bool {
        interrupt::asked()
            || self
                .seconds
                .is_some_and(|seconds| started.elapsed() >= seconds)
            || self.turns.is_some_and(|turns| course.turns() >= turns)
    }
}

/// Waits until a sample is due, or all is over.
fn wait(due: Instant, end: Instant) {
    let due = due.min(end);
    while !interrupt::asked() {
        let left = due.saturating_duration_since(Instant::now());
        if left.is_zero() {
            break;
        }
        thread::sleep(left.min(ATTENTION));
    }
}

fn write_line(output: &mut Output, value: &impl Serialize) -> io::Result<()> {
    serde_json::to_writer(&mut *output, value)?;
    output.write_all(b"\n")?;
    output.flush()
}

/// What people see.
enum Text {
    /// JSON has the place.
    Nothing,
    /// A line a sample.
    Lines { begun: bool },
    /// A chart that moves.
    Chart(Screen),
    /// The end only.
    Summary,
}

impl Text {
    fn new(taken: bool, globals: Globals) -> Self {
        if taken {
            Self::Nothing
        } else if globals.quiet {
            Self::Summary
        } else if io::stdout().is_terminal() {
            Self::Chart(Screen::new())
        } else {
            Self::Lines { begun: false }
        }
    }

    fn show(&mut self, sample: &Sample, course: &Course) -> io::Result<()> {
        match self {
            Self::Nothing | Self::Summary => Ok(()),
            Self::Chart(screen) => screen.draw(sample, course),
            Self::Lines { begun } => {
                let mut out = io::stdout().lock();
                if !*begun {
                    writeln!(out, "time_s  r_min_before   r_min_after  angle_deg  faults")?;
                    *begun = true;
                }
                writeln!(
                    out,
                    "{:>6.2} {:>13.4} {:>13.4} {:>10.4} {:>7}",
                    sample.time_s,
                    sample.rev_per_min_before,
                    sample.rev_per_min_after,
                    sample.angle_rad.to_degrees(),
                    sample.faults.total()
                )?;
                out.flush()
            }
        }
    }

    fn end(self, summary: &Summary) -> Result<(), Failure> {
        if matches!(self, Self::Nothing) {
            return Ok(());
        }
        let mut facts = Facts::default();
        summary.describe(&mut facts);
        Target::Stdout.write(facts.to_string().as_bytes())
    }
}

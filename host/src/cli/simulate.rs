//! `quadcal simulate`: a recording of a rig that is declared in a twin.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::Serialize;

use crate::report::si;
use crate::reports::simulate as page;
use crate::sim::Simulation;
use crate::twin::{Drive, Duration, Encoder, KEYS, Twin};

use super::failure::Failure;
use super::footer::footer;
use super::output::{Facts, JsonArg, ReportArg, Target, spare};
use super::simulated::{Files, Simulated};
use super::{EXIT_CODES, Globals, verify};

const EXAMPLES: &str = "\
Examples:
  quadcal simulate --example paper > rig.toml     a twin to start from
  quadcal simulate --keys                         every key that a twin may have
  quadcal simulate rig.toml -o rig.csv --turns 14
  quadcal simulate rig.toml -o rig.csv --truth truth.csv --reference ref.csv --ratio 8

The same twin and seed give the same bytes. The recording holds what a capture unit would see and nothing of the truth: the
encoder's true errors go to the file of --truth, only where that is asked for.

";

/// Simulate a rig declared in a twin (TOML) and write the edges it gives as a recording
#[derive(Debug, Args)]
#[command(after_help = [EXAMPLES, EXIT_CODES].concat())]
pub struct Simulate {
    /// Twin: encoder, shaft, drive and timer of the rig, as TOML
    #[arg(required_unless_present_any = ["example", "keys"])]
    twin: Option<PathBuf>,
    /// Recording to write, .csv or .vcd, '-' for CSV on stdout
    #[arg(short, long, value_name = "REC", required_unless_present_any = ["example", "keys"])]
    output: Option<Target>,
    /// Seed of all random numbers, in place of the twin's
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..1 << 63))]
    seed: Option<u64>,
    /// Turns to record, in place of the twin's duration
    #[arg(long, value_name = "N", value_parser = turns)]
    turns: Option<f64>,
    /// Print a twin to start from and do nothing else
    #[arg(long, value_enum, value_name = "NAME", conflicts_with_all = ["twin", "output"])]
    example: Option<Example>,
    /// Print every key that a twin may have, with its unit and default, and do nothing else
    #[arg(long, conflicts_with_all = ["twin", "output", "example"])]
    keys: bool,
    /// Write the encoder's true errors: CSV with edge,error_rad
    #[arg(long, value_name = "TRUTH", help_heading = "Truth")]
    truth: Option<Target>,
    /// Write what an ideal reference encoder shows: CSV with time,angle_rad, a point at each edge
    #[arg(long, value_name = "REF", help_heading = "Truth")]
    reference: Option<Target>,
    /// Turns of the reference for each turn of the encoder; negative if it turns the other way
    #[arg(
        long,
        value_name = "R",
        default_value = "1",
        value_parser = verify::ratio,
        allow_negative_numbers = true,
        requires = "reference",
        help_heading = "Truth"
    )]
    ratio: f64,
    #[command(flatten)]
    report: ReportArg,
    #[command(flatten)]
    json: JsonArg,
}

/// Twins shipped with the command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Example {
    /// The paper's rig: 2500 lines, 15 r/min, torque ripple
    Paper,
    /// The same with a speed that wanders by 0.1 %
    Wander,
    /// Three Hall sensors on two pole pairs
    Hall,
    /// A toothed wheel of 60 teeth, two of them missing
    Wheel,
    /// The paper's encoder on a shaft that runs down freely
    RunDown,
    /// The paper's encoder under a speed loop fed by its own edges
    SpeedLoop,
    /// Slow optocouplers at two speeds: delays that grow with the speed
    Delays,
    /// A spindle whose load bites twice
    LoadStep,
    /// A spindle with something of nearly every mechanism: sections to copy
    Mechanisms,
    /// A slow table that sticks and slips
    StickSlip,
    /// The slow one of a pair: one encoder, eccentric, with torque ripple, at two speeds
    PairSlow,
    /// The fast one of the pair
    PairFast,
}

impl Example {
    const fn text(self) -> &'static str {
        match self {
            Self::Paper => include_str!("../../twins/paper.toml"),
            Self::Wander => include_str!("../../twins/wander-0.1.toml"),
            Self::Hall => include_str!("../../twins/hall.toml"),
            Self::Wheel => include_str!("../../twins/wheel-60-2.toml"),
            Self::RunDown => include_str!("../../twins/run-down.toml"),
            Self::SpeedLoop => include_str!("../../twins/speed-loop.toml"),
            Self::Delays => include_str!("../../twins/delays.toml"),
            Self::LoadStep => include_str!("../../twins/load-step.toml"),
            Self::Mechanisms => include_str!("../../twins/mechanisms.toml"),
            Self::StickSlip => include_str!("../../twins/stick-slip.toml"),
            Self::PairSlow => include_str!("../../twins/pair-slow.toml"),
            Self::PairFast => include_str!("../../twins/pair-fast.toml"),
        }
    }
}

fn turns(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("give a number above 0".to_owned()),
    }
}

/// The result, as in the JSON.
#[derive(Debug, Serialize)]
struct Summary {
    twin: String,
    recording: String,
    seed: u64,
    rows: u64,
    edges: u64,
    seconds: f64,
    turns: f64,
}

impl Simulate {
    /// Prints an example, or simulates and writes everything that was asked for.
    pub fn run(self, globals: Globals) -> Result<(), Failure> {
        if let Some(example) = self.example {
            return Target::Stdout.write(example.text().as_bytes());
        }
        if self.keys {
            return Target::Stdout.write(KEYS.as_bytes());
        }
        // Both are there, as the command line was checked.
        let (Some(path), Some(output)) = (&self.twin, &self.output) else {
            return Ok(());
        };
        spare(&self.outputs(), path)?;
        let twin = self.load(path)?;
        let simulation = Simulation::new(&twin)?;
        let truth = simulation.true_errors();
        let files = Files {
            recording: output,
            truth: self.truth.as_ref(),
            reference: self.reference.as_ref().map(|target| (target, self.ratio)),
        };
        let written = Simulated::run(simulation, &twin, &files, globals)?;
        let outcome = written.commit(&files, &truth)?;
        if let Some(target) = &self.report.report {
            let (from, to) = (path.display().to_string(), output.to_string());
            let page = page::report(&from, &to, &outcome, footer(&[path])?);
            target.write_report(&page)?;
        }
        let summary = Summary {
            twin: path.display().to_string(),
            recording: output.to_string(),
            seed: twin.seed,
            rows: outcome.rows,
            edges: outcome.edges,
            seconds: outcome.seconds,
            turns: outcome.turns,
        };
        let facts = self.facts(&summary);
        self.json.write_beside(&self.outputs(), &summary, &facts)?;
        let learns = twin.encoder.missing_at_end().is_some();
        let quiet = globals.quiet || self.json.json.is_some();
        if !quiet && learns && *output != Target::Stdout {
            // Edges alone do not tell a loop that hides orders, nor what kind of disc it is.
            let plain = matches!(twin.encoder, Encoder::Quadrature { .. });
            let free = !matches!(twin.drive, Drive::SpeedLoop { .. });
            let twin = if plain && free {
                String::new()
            } else {
                format!(" --twin {}", path.display())
            };
            // A remark that cannot be shown is no reason to fail.
            let _ = writeln!(
                io::stderr(),
                "Next: quadcal calibrate {output}{twin} -o table.qct --report report.html"
            );
        }
        Ok(())
    }

    fn outputs(&self) -> [Option<&Target>; 5] {
        [
            self.output.as_ref(),
            self.truth.as_ref(),
            self.reference.as_ref(),
            self.report.report.as_ref(),
            self.json.json.as_ref(),
        ]
    }

    fn load(&self, path: &Path) -> Result<Twin, Failure> {
        let mut twin = Twin::load(path)?;
        if let Some(seed) = self.seed {
            twin.seed = seed;
        }
        if let Some(turns) = self.turns {
            twin.duration = Duration::Turns(turns);
        }
        twin.check()?;
        Ok(twin)
    }

    fn facts(&self, summary: &Summary) -> Facts {
        let mut facts = Facts::default();
        facts
            .push("Twin", &summary.twin)
            .push("Recording", &summary.recording)
            .push("Seed", summary.seed)
            .push("Turns", format!("{:.2}", summary.turns))
            .push("Length", si(summary.seconds, "s"))
            .push("Rows", summary.rows)
            .push("Edges", summary.edges);
        for (name, target) in [("Truth", &self.truth), ("Reference", &self.reference)] {
            if let Some(target) = target {
                facts.push(name, target);
            }
        }
        facts
    }
}

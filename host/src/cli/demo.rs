//! `quadcal demo`: everything once, with nothing to prepare.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use crate::demo::{self, DemoError, RIG_TURNS, RIG_TWIN, Rig, Run, TABLE_1};
use crate::report::si;
use crate::reports::{self, words};

use super::failure::Failure;
use super::footer::footer;
use super::output::{Facts, JsonArg, Target};
use super::progress::Progress;
use super::{EXIT_CODES, Globals};

const EXAMPLES: &str = "\
Examples:
  quadcal demo
  quadcal demo --out /tmp/demo

Simulates the encoder rig of the paper and calibrates it, then does the same with a recording of a real motor that is built in.
Writes recordings, tables, the rig's twin and one report, demo.html.

";

/// Calibrate a simulated and a real encoder and show what came of it
#[derive(Debug, Args)]
#[command(after_help = [EXAMPLES, EXIT_CODES].concat())]
pub struct Demo {
    /// Folder for all files; made if it does not exist
    #[arg(long, value_name = "DIR", default_value = "quadcal-demo")]
    out: PathBuf,
    #[command(flatten)]
    json: JsonArg,
}

/// The result, as in the JSON.
#[derive(Debug, Serialize)]
struct Summary {
    report: String,
    simulated: SimulatedSummary,
    spindle: SpindleSummary,
}

#[derive(Debug, Serialize)]
struct SimulatedSummary {
    turns: u32,
    error_before_rad: f64,
    error_after_rad: f64,
    expected_error_after_rad: f64,
    table_1: Vec<Row>,
}

#[derive(Debug, Serialize)]
struct Row {
    name: &'static str,
    paper_true_rad: f64,
    paper_found_rad: f64,
    true_rad: f64,
    found_rad: f64,
    standard_error_rad: f64,
}

#[derive(Debug, Serialize)]
struct SpindleSummary {
    turns: u32,
    intervals_checked: u64,
    scatter_before: f64,
    scatter_after: f64,
}

impl Demo {
    /// Runs both encoders and writes the folder.
    pub fn run(self, globals: Globals) -> Result<(), Failure> {
        let mut progress = Progress::count("Demonstration", "steps", Some(3), globals);
        let failed = |error: DemoError| Failure::Demo(Box::new(error));
        let rig = demo::rig().map_err(failed)?;
        progress.reach(1, |_| "the real recording".to_owned());
        let spindle = demo::spindle().map_err(failed)?;
        progress.reach(2, |_| "the report".to_owned());
        let page = reports::demo::report(&rig, &spindle, footer(&[])?);
        drop(progress);
        fs::create_dir_all(&self.out)
            .map_err(|source| Target::File(self.out.clone()).failed(source))?;
        for (name, bytes) in [
            ("paper-rig.toml", RIG_TWIN.as_bytes()),
            ("paper-rig.csv", &rig.run.recording),
            ("paper-rig.qct", &rig.run.table),
            ("hall-spindle.csv", &spindle.recording),
            ("hall-spindle.qct", &spindle.table),
        ] {
            Target::File(self.out.join(name)).write(bytes)?;
        }
        let report = self.out.join("demo.html");
        Target::File(report.clone()).write_report(&page)?;
        let summary = Summary::new(&report, &rig, &spindle);
        self.json.write(&summary, &self.facts(&summary, &report))
    }

    fn facts(&self, summary: &Summary, report: &Path) -> Facts {
        let mut facts = Facts::default();
        let simulated = &summary.simulated;
        facts.push(
            "Simulated rig of the paper",
            format!("2500 lines, speed wander 0.1 %, {RIG_TURNS} turns"),
        );
        let micro = |rad: f64| format!("{:.2}", rad * 1e6);
        let fine = |rad: f64| format!("{:.3}", rad * 1e6);
        for row in &simulated.table_1 {
            facts.push(
                format!("  {}", row.name),
                format!(
                    "{} ± {} µrad, true {}   (paper: {}, true {})",
                    fine(row.found_rad),
                    fine(row.standard_error_rad),
                    fine(row.true_rad),
                    micro(row.paper_found_rad),
                    micro(row.paper_true_rad)
                ),
            );
        }
        facts.push(
            "  Angle error against the truth, RMS",
            format!(
                "{} before, {} after: down by {:.1} %",
                si(simulated.error_before_rad, "rad"),
                si(simulated.error_after_rad, "rad"),
                words::reduction_percent(simulated.error_before_rad, simulated.error_after_rad)
            ),
        );
        let spindle = &summary.spindle;
        facts.push(
            "Real recording, hall-spindle.csv",
            format!(
                "three Hall sensors, {} turns of its first half",
                spindle.turns
            ),
        );
        facts.push(
            "  Scatter of the speed, second half",
            format!(
                "{:.2} % before, {:.2} % after: down by {:.1} %",
                100.0 * spindle.scatter_before,
                100.0 * spindle.scatter_after,
                words::reduction_percent(spindle.scatter_before, spindle.scatter_after)
            ),
        );
        let path = fs::canonicalize(report).unwrap_or_else(|_| report.to_owned());
        let out = self.out.display();
        facts
            .push("Report, open in a browser", path.display())
            .push(
                "Try next",
                format!("quadcal verify {out}/paper-rig.csv --table {out}/paper-rig.qct"),
            )
            .push(
                "",
                format!(
                    "quadcal calibrate {out}/hall-spindle.csv --fraction 0.5 -o spindle.qct --report spindle.html"
                ),
            )
            .push(
                "",
                format!("quadcal simulate {out}/paper-rig.toml -o rig.csv --seed 7 --turns 30"),
            );
        facts
    }
}

impl Summary {
    fn new(report: &Path, rig: &Rig, spindle: &Run) -> Self {
        let rows = TABLE_1
            .iter()
            .zip(&rig.run.findings.parameters)
            .zip(&rig.true_parameters_rad);
        Self {
            report: report.display().to_string(),
            simulated: SimulatedSummary {
                turns: rig.run.calibration.totals.turns,
                error_before_rad: rig.before_rad,
                error_after_rad: rig.after_rad,
                expected_error_after_rad: rig.run.findings.after_rad,
                table_1: rows
                    .map(
                        |((&(name, paper_true_rad, paper_found_rad), ours), &true_rad)| Row {
                            name,
                            paper_true_rad,
                            paper_found_rad,
                            true_rad,
                            found_rad: ours.rad,
                            standard_error_rad: ours.standard_error_rad,
                        },
                    )
                    .collect(),
            },
            spindle: SpindleSummary {
                turns: spindle.calibration.totals.turns,
                intervals_checked: spindle.check.scatter.intervals,
                scatter_before: spindle.check.scatter.before,
                scatter_after: spindle.check.scatter.after,
            },
        }
    }
}

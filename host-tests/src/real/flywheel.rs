//! flywheel-6-magnets: a rower's flywheel, against a twin that knows pulses a turn and inertia.

use std::path::Path;

use anyhow::{Context, Result};
use quadcal_host::diagnose::diagnosis::Verdict;
use quadcal_host::mechanism::Mechanism;
use quadcal_host::sim::Simulation;

use super::command::Bench;
use super::line::Line;
use super::run_down::run_downs;

const MAGNETS: usize = 6;
/// Moment of inertia of this make of flywheel, kg m^2.
const INERTIA: f64 = 0.1001;
/// Where the magnets are, degrees, from whichever is counted first.
const PLACES: [f64; MAGNETS] = [-0.616, -0.605, -0.061, 0.822, 0.613, -0.155];

/// Diagnoses the flywheel's recording.
///
/// # Errors
/// Where it can't be read or run.
pub fn flywheel(bench: &Bench, recording: &Path) -> Result<Vec<Line>> {
    let text =
        std::fs::read_to_string(recording).with_context(|| recording.display().to_string())?;
    let mut now = 0.0;
    let times: Vec<f64> = text
        .lines()
        .filter_map(|line| line.trim().parse::<f64>().ok())
        .map(|interval| {
            now += interval;
            now
        })
        .collect();
    // Nothing drives it as far as the twin knows: one push, then it runs down.
    let turns = times.len() as f64 / MAGNETS as f64;
    let twin = format!(
        "duration = {{ seconds = {now:.1} }}\n[encoder.wheel]\nteeth = {MAGNETS}\n[shaft]\ninertia_kg_m2 = {INERTIA}\n\
         [drive.run_down]\nr_min = {:.0}\noff_s = 0\n[timer]\nclock_hz = 1000000\n",
        60.0 * turns / now
    );
    let twin = bench.write("flywheel.toml", &twin)?;
    let said = bench.diagnose(recording, &twin, "flywheel")?;
    let mut lines = Vec::new();
    // Edge k stands at its grid angle less e(k); both edges of a magnet have its error.
    let errors = Simulation::new(&said.twin)?.true_errors();
    let places: Vec<f64> = errors.iter().step_by(2).map(|e| -e.to_degrees()).collect();
    let (off, first) = (0..MAGNETS)
        .map(|first| {
            let each = (0..MAGNETS).map(|k| places[(k + first) % MAGNETS] - PLACES[k]);
            let mean = each.clone().sum::<f64>() / MAGNETS as f64;
            (each.map(|d| (d - mean).abs()).fold(0.0, f64::max), first)
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .context("no magnets")?;
    let shown: Vec<String> = (0..MAGNETS)
        .map(|k| format!("{:.3}", places[(k + first) % MAGNETS]))
        .collect();
    lines.push(Line::told(
        "flywheel: magnets' places, degrees",
        shown.join(" "),
    ));
    lines.push(Line::judged(
        "  farthest from where they are known to be",
        "0.02 degrees or less",
        format!("{off:.4} degrees"),
        off <= 0.02 && said.of(Mechanism::LineError).is_some(),
    ));
    let slows = run_downs(&times, MAGNETS).context("no run-downs")?;
    lines.push(Line::told(
        "  run-downs by themselves: power of the speed",
        format!("{:.2} in {}", slows.exponent, slows.count),
    ));
    let drag = said
        .of(Mechanism::Friction)
        .and_then(|f| f.parameters.get("drag_n_m_s2"));
    let expected = slows.drag * INERTIA;
    lines.push(Line::judged(
        "  friction: drag that goes with the speed squared",
        &format!("{:.1} uN m s^2, within 3 %", 1e6 * expected),
        drag.map_or(said.names(), |drag| {
            let half = drag.ci95.map_or(0.0, |[low, high]| 0.5 * (high - low));
            format!("{:.1} +- {:.1} uN m s^2", 1e6 * drag.value, 1e6 * half)
        }),
        drag.is_some_and(|drag| (drag.value / expected - 1.0).abs() < 0.03),
    ));
    let pushes = said
        .of(Mechanism::LoadStep)
        .and_then(|f| f.parameters.get("count"));
    lines.push(Line::judged(
        "  pushes left out of the comparison",
        "206",
        pushes.map_or("none".to_owned(), |count| count.value.to_string()),
        pushes.is_some_and(|count| (count.value - 206.0).abs() < 0.5),
    ));
    let left = said.of(Mechanism::Unknown);
    lines.push(Line::judged(
        "  what is left",
        "said to be unknown",
        left.map_or("not said".to_owned(), |f| f.text.clone()),
        left.is_some() && said.diagnosis.verdict == Verdict::Partly,
    ));
    Ok(lines)
}

//! `quadcal info`: what a recording holds.

use clap::{Args, value_parser};
use serde::Serialize;

use crate::recording::{Channels, Format, ListKind};
use crate::report;
use crate::survey::Survey;

use super::failure::Failure;
use super::input::InputArgs;
use super::output::{Facts, JsonArg};
use super::progress::Watched;
use super::tally::{Rates, Steps, Tally};
use super::{EXIT_CODES, Globals};

const EXAMPLES: &str = "\
Examples:
  quadcal info spindle.csv
  quadcal info capture.csv --map 'a=Channel 0' --map 'b=Channel 1'
  quadcal info hall.csv --edges 12            speeds in r/min: 12 edges a turn
  quadcal info spindle.csv --json - | jq .lines

Speeds are means over 60 edges each.

";

/// Show what a recording holds: format, clock, channels, length, speed and line count
#[derive(Debug, Args)]
#[command(after_help = [EXAMPLES, EXIT_CODES].concat())]
pub struct Info {
    #[command(flatten)]
    input: InputArgs,
    /// Edges a turn, for speeds in r/min where no index tells the line count
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..))]
    edges: Option<u32>,
    #[command(flatten)]
    json: JsonArg,
}

/// The result, as in the JSON.
#[derive(Debug, Serialize)]
struct Summary {
    file: String,
    format: &'static str,
    list: Option<&'static str>,
    clock_hz: u64,
    /// Step of the time stamps; null with few rows.
    time_step_s: Option<f64>,
    channels: &'static str,
    rows: u64,
    repeated_rows: u64,
    first_tick: u64,
    last_tick: u64,
    seconds: f64,
    edges: u64,
    steps: Option<Steps>,
    index_pulses: Option<u64>,
    lines: Option<u32>,
    edges_per_turn: Option<u32>,
    edges_per_second: Option<Rates>,
    rev_per_min: Option<Rates>,
    notes: Vec<Note>,
}

#[derive(Debug, Serialize)]
struct Note {
    key: String,
    value: String,
}

impl Info {
    /// Reads the recording and prints what it is.
    pub fn run(self, globals: Globals) -> Result<(), Failure> {
        if let Some(target) = &self.json.json {
            self.input.spare(target)?;
        }
        let summary = self.summary(globals)?;
        self.json.write(&summary, &summary.facts())
    }

    fn summary(&self, globals: Globals) -> Result<Summary, Failure> {
        let recording = self.input.open()?;
        let (format, list) = (recording.format(), recording.list_kind());
        let header = recording.header.clone();
        let channels = header.channels;
        let mut tally = Tally::new(channels);
        let mut rows = Watched::new(recording, globals);
        let counted = rows
            .by_ref()
            .inspect(|row| row.iter().for_each(|row| tally.push(row)));
        let survey = Survey::of(header, counted)?;
        let quadrature = matches!(channels, Channels::Quadrature { .. });
        let has_index = channels == Channels::Quadrature { index: true };
        let lines = survey.lines();
        let edges_per_turn = self.edges.or(lines.map(|lines| lines.saturating_mul(4)));
        let edges_per_second = tally.rates(survey.header.clock_hz);
        Ok(Summary {
            file: self.input.recording.display().to_string(),
            format: match format {
                Format::Native => "native",
                Format::Logic => "logic",
                Format::Vcd => "vcd",
                Format::List => "list",
            },
            list: list.map(|kind| match kind {
                ListKind::Times => "times",
                ListKind::Intervals | ListKind::Auto => "intervals",
            }),
            clock_hz: survey.header.clock_hz,
            time_step_s: time_step_s(&survey),
            channels: match channels {
                Channels::Quadrature { .. } => "quadrature",
                Channels::Hall => "hall",
                Channels::Wheel => "wheel",
                Channels::Pulses => "pulses",
            },
            rows: survey.rows,
            repeated_rows: rows.recording().repeated_rows(),
            first_tick: survey.first,
            last_tick: survey.last,
            seconds: survey.seconds(),
            edges: tally.edges,
            steps: quadrature.then_some(tally.steps),
            index_pulses: has_index.then_some(survey.index_pulses),
            lines,
            edges_per_turn,
            edges_per_second,
            rev_per_min: edges_per_second
                .zip(edges_per_turn)
                .map(|(rates, edges)| rates.per_minute(edges)),
            notes: survey
                .header
                .notes
                .into_iter()
                .filter(|(key, _)| key != "clock_hz")
                .map(|(key, value)| Note { key, value })
                .collect(),
        })
    }
}

impl Summary {
    fn facts(&self) -> Facts {
        let mut facts = Facts::default();
        facts
            .push("File", &self.file)
            .push("Format", self.format_text())
            .push("Clock", self.clock_text())
            .push("Channels", self.channels_text())
            .push("Length", format!("{:.3} s", self.seconds));
        let repeated = match self.repeated_rows {
            0 => String::new(),
            repeated => format!(" ({repeated} more repeat the levels above and are left out)"),
        };
        facts.push("Rows", format!("{}{repeated}", self.rows));
        facts.push("Edges", self.edges);
        if let Some(steps) = self.steps {
            facts.push("Direction", steps.text());
        }
        match (self.index_pulses, self.lines) {
            (Some(0), _) => facts.push("Index", "no pulse: the line count cannot be told"),
            (Some(pulses), None) => facts.push(
                "Index",
                format!("{pulses} pulses, with no steady edge count between them"),
            ),
            (Some(pulses), Some(lines)) => facts
                .push("Index", format!("{pulses} pulses"))
                .push("Lines", format!("{lines} a turn")),
            (None, _) => &mut facts,
        };
        match (self.rev_per_min, self.edges_per_second) {
            (Some(speeds), _) => facts.push("Speed", speeds.text("r/min")),
            (None, Some(rates)) => facts.push(
                "Speed",
                format!("{} (--edges N gives r/min)", rates.text("edges/s")),
            ),
            (None, None) => facts.push("Speed", "unknown, fewer than 61 edges at different times"),
        };
        for note in &self.notes {
            facts.push(format!("# {}", note.key), &note.value);
        }
        facts
    }
}

impl Summary {
    fn format_text(&self) -> &'static str {
        match (self.format, self.list) {
            ("native", _) => "native CSV",
            ("logic", _) => "logic-analyser CSV",
            ("vcd", _) => "VCD",
            (_, Some("times")) => "one-column list of times",
            _ => "one-column list of intervals",
        }
    }

    /// The clock, and the step of the time stamps where it is not a tick.
    #[allow(clippy::cast_precision_loss)]
    fn clock_text(&self) -> String {
        let clock = clock(self.clock_hz);
        match self.time_step_s {
            Some(step) if step * self.clock_hz as f64 > 1.5 => format!(
                "{clock}; the times have a step of {}, as if sampled at {}",
                report::si(step, "s"),
                report::si(1.0 / step, "Hz")
            ),
            _ => clock,
        }
    }

    fn channels_text(&self) -> &'static str {
        match (self.channels, self.index_pulses) {
            ("quadrature", Some(_)) => "quadrature with index (A, B, Z)",
            ("quadrature", None) => "quadrature without index (A, B)",
            ("hall", _) => "three Hall sensors (A, B, C)",
            ("wheel", _) => "one channel, both edges (A)",
            _ => "one channel, one pulse a tooth",
        }
    }
}

impl Steps {
    fn text(self) -> String {
        let turned = match (self.forward, self.backward) {
            (0, 0) => "none".to_owned(),
            (_, 0) => "forward".to_owned(),
            (0, _) => "backward".to_owned(),
            (forward, backward) => format!("{forward} edges forward, {backward} backward"),
        };
        match self.skipped {
            0 => turned,
            skipped => format!("{turned}; A and B changed at once {skipped} times"),
        }
    }
}

impl Rates {
    fn text(self, unit: &str) -> String {
        let [lowest, mean, highest] = [self.lowest, self.mean, self.highest].map(number);
        format!("{lowest} to {highest} {unit}, mean {mean} {unit}")
    }
}

#[allow(clippy::cast_precision_loss)]
fn time_step_s(survey: &Survey) -> Option<f64> {
    let ticks = survey.time_step.ticks()?;
    Some(ticks / survey.header.clock_hz as f64)
}

/// With as many digits as it takes, for a clock is exact.
#[allow(clippy::cast_precision_loss)]
fn clock(hz: u64) -> String {
    let (number, unit) = report::si_parts(hz as f64, "Hz");
    let scale = match unit.trim_end_matches("Hz") {
        "k" => 1e3,
        "M" => 1e6,
        "G" => 1e9,
        _ => return format!("{number} {unit}"),
    };
    format!("{} {unit}", hz as f64 / scale)
}

/// Four digits, without a prefix.
fn number(value: f64) -> String {
    let decimals = (3 - value.abs().max(1e-6).log10().floor() as i32).clamp(0, 6);
    format!("{value:.*}", decimals as usize)
}

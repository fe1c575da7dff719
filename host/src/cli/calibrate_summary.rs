//! What `quadcal calibrate` prints and writes as JSON.

use std::path::Path;

use serde::Serialize;

use crate::calibrate::Calibration;
use crate::findings::Findings;
use crate::report::si;
use crate::reports::words;
use crate::showcase::Showcase;

use super::output::{Facts, Target};

/// The result, as in the JSON.
#[derive(Debug, Serialize)]
pub(super) struct Summary {
    file: String,
    sensor: &'static str,
    counted: &'static str,
    lines: u32,
    edges_per_turn: u32,
    origin: &'static str,
    clock_hz: u64,
    seconds: f64,
    turns: Turns,
    faults: Faults,
    parameters: Vec<Value>,
    eps_rms_rad: f64,
    expected_error_before_rad: f64,
    expected_error_after_rad: f64,
    orders_left_alone: Vec<Order>,
    learned_until_tick: u64,
    later_turns: Option<LaterTurns>,
}

/// The table on turns after those learned from.
#[derive(Debug, Serialize)]
struct LaterTurns {
    scatter_before: f64,
    scatter_after: f64,
    worse: bool,
}

#[derive(Debug, Serialize)]
struct Turns {
    used: u32,
    broken: u32,
    irregular: u32,
    speed_change: u32,
    slowest_rev_per_min: f64,
    fastest_rev_per_min: f64,
}

#[derive(Debug, Serialize)]
struct Faults {
    lost: u32,
    extra: u32,
    illegal: u32,
    glitch: u32,
}

#[derive(Debug, Serialize)]
struct Value {
    name: &'static str,
    #[serde(skip)]
    label: &'static str,
    rad: f64,
    standard_error_rad: f64,
}

#[derive(Debug, Serialize)]
struct Order {
    order: u16,
    amplitude_rad: f64,
}

impl Summary {
    pub fn new(
        path: &Path,
        calibration: &Calibration,
        findings: &Findings,
        shown: &Showcase,
    ) -> Self {
        let (plan, totals, faults) = (calibration.plan, &calibration.totals, &calibration.faults);
        let survey = &calibration.survey;
        let [slowest, fastest] = words::speeds_r_min(calibration);
        Self {
            file: path.display().to_string(),
            sensor: words::sensor(plan.kind),
            counted: plan.kind.line_name(),
            lines: plan.lines,
            edges_per_turn: calibration.solution.shape().edges(),
            origin: words::origin(plan),
            clock_hz: survey.header.clock_hz,
            seconds: survey.seconds(),
            turns: Turns {
                used: totals.turns,
                broken: totals.broken,
                irregular: totals.irregular,
                speed_change: totals.speed_change,
                slowest_rev_per_min: slowest,
                fastest_rev_per_min: fastest,
            },
            faults: Faults {
                lost: faults.lost,
                extra: faults.extra,
                illegal: faults.illegal,
                glitch: faults.glitch,
            },
            parameters: findings
                .parameters
                .iter()
                .map(|parameter| Value {
                    name: parameter.id,
                    label: parameter.name,
                    rad: parameter.rad,
                    standard_error_rad: parameter.standard_error_rad,
                })
                .collect(),
            eps_rms_rad: findings.eps_rms_rad(),
            expected_error_before_rad: findings.before_rad,
            expected_error_after_rad: findings.after_rad,
            orders_left_alone: findings
                .left_alone
                .iter()
                .map(|left| Order {
                    order: left.order,
                    amplitude_rad: left.amplitude_rad,
                })
                .collect(),
            learned_until_tick: calibration.learned_until,
            later_turns: shown.later.then(|| LaterTurns {
                scatter_before: shown.check.scatter.before,
                scatter_after: shown.check.scatter.after,
                worse: shown.worse_later(),
            }),
        }
    }

    pub fn facts(&self, table: &Target) -> Facts {
        let mut facts = Facts::default();
        facts.push("Recording", &self.file).push(
            "Encoder",
            format!(
                "{}, {} {}, counted from {}",
                self.sensor, self.lines, self.counted, self.origin
            ),
        );
        let turns = &self.turns;
        facts.push(
            "Turns used",
            format!(
                "{} at {}",
                turns.used,
                words::speed_range([turns.slowest_rev_per_min, turns.fastest_rev_per_min])
            ),
        );
        facts.push(
            "Turns rejected",
            words::rejected(turns.broken, turns.irregular, turns.speed_change),
        );
        for value in &self.parameters {
            let text = words::with_error(value.rad, value.standard_error_rad);
            facts.push(value.label, text);
        }
        facts.push_si("Line position error eps, RMS", self.eps_rms_rad, "rad");
        facts.push(
            "Expected error, RMS",
            format!(
                "{} before, {} after",
                si(self.expected_error_before_rad, "rad"),
                si(self.expected_error_after_rad, "rad")
            ),
        );
        for left in &self.orders_left_alone {
            facts.push(
                format!("Order {} left alone", left.order),
                words::left_alone(left.amplitude_rad),
            );
        }
        if let Some(later) = &self.later_turns {
            let remark = if later.worse {
                ": worse, so it does not hold at the speeds of these turns"
            } else {
                ""
            };
            let scatter = words::scatter(later.scatter_before, later.scatter_after);
            facts.push("Scatter on later turns", format!("{scatter}{remark}"));
        }
        facts.push("Table", table).push(
            "",
            words::outlook(
                self.expected_error_before_rad,
                self.expected_error_after_rad,
            ),
        );
        facts
    }
}

//! What `quadcal calibrate` prints.

use crate::calibrate::RecordingUse;
use crate::report::si;
use crate::reports::calibrate::Calibrated;
use crate::reports::expected::{self, LeftOut};
use crate::reports::{separation, words};

use super::output::{Facts, Target};

/// The result as text for people.
pub(super) fn facts(calibrated: &Calibrated<'_>, table: &Target) -> Facts {
    let Calibrated {
        calibration,
        findings,
        inertia_kg_m2,
        ..
    } = *calibrated;
    let plan = calibration.plan;
    let left_out = LeftOut::of(calibration, findings);
    let mut facts = Facts::default();
    let encoder = format!(
        "{}, {} {}{}, counted from {}",
        words::sensor(plan.kind),
        plan.lines,
        plan.kind.line_name(),
        words::lines_guessed(calibration),
        words::origin(plan)
    );
    recording_facts(&mut facts, calibrated);
    facts.push("Encoder", encoder);
    for parameter in &findings.parameters {
        let text = words::with_error(parameter.rad, parameter.standard_error_rad);
        facts.push(parameter.name, text);
    }
    facts
        .push_si(
            "Line position error eps, RMS",
            findings.eps_rms_rad(),
            "rad",
        )
        .push_si("Standard error of a line", findings.after_rad, "rad")
        .push(
            "Expected error, RMS",
            format!(
                "{} before, {} after{}{}",
                si(findings.before_rad, "rad"),
                si(findings.after_rad, "rad"),
                left_out.besides(),
                expected::proviso(findings)
            ),
        );
    if let Some(progress) = words::progress(calibration, findings.after_rad) {
        facts.push("", progress);
    }
    let [slowest, _] = words::speeds_r_min(&calibration.totals, calibration.clock_hz);
    let (strong, weaker) = separation::strong(&findings.torques);
    for torque in strong {
        facts.push(
            format!("Torque ripple, order {}", torque.order),
            separation::torque(torque, inertia_kg_m2, slowest),
        );
    }
    if weaker > 0 {
        facts.push(
            format!("  and {weaker} more"),
            "with less than a hundredth of that swing; --report and --json list them",
        );
    }
    if calibration.two_speeds() && findings.torques.is_empty() {
        facts.push("Torque ripple", "none that stands out");
    }
    if inertia_kg_m2.is_some() && !calibration.two_speeds() && !calibration.loops_undone {
        facts.push(
            "--inertia",
            "has no use here: all turns ran at one speed, where torque can't be told from the disc; give a recording at another speed too",
        );
    }
    for delay in findings.delays.found() {
        let size = [delay.seconds, delay.standard_error_s].map(|seconds| si(seconds, "s"));
        facts.push(delay.name, size.join(" ± "));
    }
    if let Some(unknown) = separation::delays_unknown(&findings.delays) {
        facts.push("Rise/fall delay and channel skew", unknown);
    }
    for left in &findings.left_alone {
        let text = separation::left_alone(left);
        facts.push(format!("Order {} left alone", left.order), text);
    }
    if let Some(advice) = separation::advice(findings, calibration.drive) {
        facts.push("", advice);
    }
    if let Some(hidden) = separation::hidden(calibration) {
        facts.push("Hidden orders", hidden);
    }
    if let Some(hump) = &findings.loop_suspicion {
        facts.push("Was a speed loop on?", separation::loop_suspected(hump));
    }
    facts
        .push("Table", table)
        .push("", expected::outlook(findings, &left_out));
    facts
}

/// What was taken of each recording, and what the table does on its later turns.
fn recording_facts(facts: &mut Facts, calibrated: &Calibrated<'_>) {
    let calibration = calibrated.calibration;
    let recordings = calibrated
        .names
        .iter()
        .zip(&calibration.recordings)
        .zip(calibrated.shown);
    for ((name, used), shown) in recordings {
        let totals = &used.totals;
        let speeds = words::speed_range(words::speeds_r_min(totals, calibration.clock_hz));
        let taken = match totals.turns {
            0 => "none".to_owned(),
            turns => format!("{turns} at {speeds}"),
        };
        facts
            .push("Recording", name)
            .push("  Turns used", taken)
            .push("  Turns rejected", words::rejected(totals));
        rejected_facts(&mut *facts, used);
        if shown.later {
            let scatter = &shown.check.scatter;
            let remark = if shown.worse_later() {
                ": worse, so it does not hold at the speeds of these turns"
            } else {
                ""
            };
            let scatter = words::scatter(scatter.before, scatter.after);
            facts.push("  Scatter on later turns", format!("{scatter}{remark}"));
        }
    }
}

/// Rejected turns of a recording that are listed.
const LISTED: usize = 5;

/// Which turns of a recording were rejected, where and why.
fn rejected_facts(facts: &mut Facts, used: &RecordingUse) {
    let turns = used.rejected.listed();
    for turn in turns.iter().take(LISTED) {
        let (start, duration) = used.seconds_of(turn);
        let took = duration.map_or_else(String::new, |s| format!(", took {}", words::took(s)));
        let why = words::reason(turn.reason);
        facts.push(
            format!("    Turn {}", turn.number),
            format!("{why}; begins at {start:.3} s{took}"),
        );
    }
    let more = turns.len().saturating_sub(LISTED) as u64 + used.rejected.more();
    if more > 0 {
        facts.push(format!("    and {more} more"), "--json lists them");
    }
}

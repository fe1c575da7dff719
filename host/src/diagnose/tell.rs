//! The diagnosis in the user's terms.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::beside::{put_in, put_lost};
use super::board::Bench;
use super::conclude::Name;
use super::diagnosis::{
    Diagnosis, Evidence, Finding, NextRecording, Parameter, Place, RecordingFacts, RunnerUp,
};
use super::estimate::Estimate;
use super::named::parameters;
use super::next;
use super::place::{place, text};
use super::plots;
use super::run::{Diagnosed, Recorded};
use super::settle::Settled;
use super::told_disc::{disc, one_disc};
use super::verdict::{order, summary, verdict};
use crate::mechanism::Mechanism;

/// Revolutions a minute in rad/s.
pub const R_MIN: f64 = 60.0 / std::f64::consts::TAU;

/// Everything that comes of what was settled; `to_record` are the recordings to make, one for each finding with a name, and `beside`
/// findings that are no pattern.
#[must_use]
pub fn tell(
    rig: &[Recorded],
    settled: &Settled,
    to_record: &[Option<NextRecording>],
    beside: Vec<Finding>,
) -> Diagnosed {
    let mut findings: Vec<Finding> = settled
        .concluded
        .named
        .iter()
        .zip(&settled.estimates)
        .enumerate()
        .map(|(number, (name, estimate))| Finding {
            next_recording: to_record.get(number).cloned().flatten(),
            ..finding(settled, name, settled.held.named.get(number), estimate)
        })
        .collect();
    let numbers: Vec<Finding> = findings.clone();
    one_disc(&mut findings);
    findings.extend(
        disc(settled).filter(|_| !findings.iter().any(|f| f.mechanism == Mechanism::LineError)),
    );
    findings.extend(unknown(settled));
    let mut twins = settled.twins.clone();
    for (twin, one) in twins.iter_mut().zip(rig) {
        put_in(twin, &beside);
        put_lost(twin, &one.track);
    }
    findings.extend(beside);
    let verdict = verdict(&findings);
    order(&mut findings, verdict);
    // Which of the patterns each is.
    let drawn: Vec<(Finding, Option<usize>)> = findings
        .iter()
        .map(|finding| {
            let same = |one: &Finding| {
                one.mechanism == finding.mechanism && one.parameters == finding.parameters
            };
            (finding.clone(), numbers.iter().position(same))
        })
        .collect();
    let first_next = next::first(findings.iter().map(|one| one.next_recording.as_ref())).cloned();
    Diagnosed {
        shown: plots::shown(settled, &drawn),
        diagnosis: Diagnosis {
            version: 1,
            verdict,
            summary: summary(verdict, &findings, &settled.fit, rig.len()),
            recordings: rig.iter().zip(&settled.given.benches).map(facts).collect(),
            fit: settled.fit,
            findings,
            next_recording: first_next,
        },
        twins,
        error_lists: settled.error_lists.clone(),
    }
}

fn finding(
    settled: &Settled,
    name: &Name,
    held: Option<&Option<f64>>,
    estimate: &Estimate,
) -> Finding {
    let mechanism = name.hypothesis.mechanism;
    let parameters = parameters(estimate);
    let place = place(settled, name, estimate, &parameters);
    let mut look_alikes = name.alike.clone();
    for told_by_rig in mechanism.card().told_by_rig {
        if !look_alikes.contains(told_by_rig) {
            look_alikes.push(*told_by_rig);
        }
    }
    Finding {
        mechanism,
        text: text(name, &place),
        confidence: name.confidence,
        parameters,
        place,
        evidence: Evidence {
            delta_bic: name.score,
            p_value: p_value(settled, name.score),
            held_out_rms_ratio: held.copied().flatten(),
            runner_up: name.runner_up.map(|(mechanism, delta_bic)| RunnerUp {
                mechanism,
                delta_bic,
            }),
        },
        look_alikes,
        next_recording: None,
    }
}

/// Chance of a fall of the squares by so much beyond its cost, anywhere: a bound, as the cost of each number is more than its share.
pub(super) fn p_value(settled: &Settled, score: f64) -> f64 {
    let places = 10.0 * settled.given.edges() as f64;
    (places * (-0.5 * score).exp()).min(1.0)
}

fn unknown(settled: &Settled) -> Option<Finding> {
    let nameless = settled.concluded.nameless.as_ref()?;
    let mut parameters = BTreeMap::new();
    let mut text = nameless.text.clone();
    if let Some(repeats) = settled.repeats {
        let half = 1.96 * repeats.standard_error;
        let bound = |share: f64| share.clamp(0.0, 1.0);
        let share = Parameter {
            value: repeats.share,
            unit: "1".to_owned(),
            ci95: Some([bound(repeats.share - half), bound(repeats.share + half)]),
        };
        parameters.insert("repeats_each_turn".to_owned(), share);
        let _ = write!(
            text,
            "; {:.0} % of it comes again each turn",
            100.0 * repeats.share
        );
    }
    Some(Finding {
        mechanism: Mechanism::Unknown,
        text,
        confidence: 1.0,
        parameters,
        place: Place {
            orders: nameless.orders.clone(),
            frequencies_hz: nameless.frequencies_hz.clone(),
            ..Place::default()
        },
        evidence: Evidence {
            delta_bic: nameless.squares,
            p_value: nameless.p_value,
            held_out_rms_ratio: settled.held.nameless,
            runner_up: None,
        },
        look_alikes: Vec::new(),
        next_recording: None,
    })
}

fn facts((one, bench): (&Recorded, &Bench)) -> RecordingFacts {
    RecordingFacts {
        file: one.file.clone(),
        twin: one.twin.name.clone(),
        edges: bench.seen.len() as u64,
        turns: bench.seen.turns(),
        seconds: bench.seen.seconds(),
        speed_r_min: bench.seen.speed_range().map(|speed| speed * R_MIN),
        anchored: one.track.anchored,
        start_rad: one.start_rad(),
        stamp_rms_s: Some(bench.noise.stamp_s),
        disturbed_s: one.track.slips.iter().map(|slip| slip.time_s).collect(),
    }
}

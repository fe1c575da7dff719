//! The diagnosis in the user's terms.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::beside::{put_in, put_lost};
use super::board::Bench;
use super::conclude::Name;
use super::diagnosis::{
    Diagnosis, Evidence, Finding, NextRecording, Parameter, Place, RecordingFacts, RunnerUp,
    Verdict,
};
use super::named::parameters;
use super::next;
use super::place::{place, text};
use super::plots;
use super::run::{Diagnosed, Recorded};
use super::settle::Settled;
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
            ..finding(
                settled,
                name,
                settled.held.named.get(number),
                parameters(estimate),
            )
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
    findings.sort_by(|a, b| b.evidence.delta_bic.total_cmp(&a.evidence.delta_bic));
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
    let verdict = verdict(&findings);
    let first_next = next::first(findings.iter().map(|one| one.next_recording.as_ref())).cloned();
    Diagnosed {
        shown: plots::shown(settled, &drawn),
        diagnosis: Diagnosis {
            version: 1,
            verdict,
            summary: summary(verdict, &findings),
            recordings: rig.iter().zip(&settled.given.benches).map(facts).collect(),
            fit: settled.fit,
            findings,
            next_recording: first_next,
        },
        twins,
        error_lists: settled.error_lists.clone(),
    }
}

/// The verdict on findings, strongest first.
#[must_use]
pub fn verdict(findings: &[Finding]) -> Verdict {
    let unknown = findings.iter().any(|f| f.mechanism == Mechanism::Unknown);
    let known = findings
        .iter()
        .filter(|f| f.mechanism != Mechanism::Unknown)
        .count();
    match (unknown, known) {
        (false, 0) => Verdict::Complete,
        (true, 0) => Verdict::Unknown,
        (true, _) if findings[0].mechanism == Mechanism::Unknown => Verdict::Unknown,
        (true, _) => Verdict::Partly,
        (false, _) if findings.iter().any(Finding::is_open) => Verdict::Ambiguous,
        (false, _) => Verdict::Explained,
    }
}

/// The verdict in a sentence.
#[must_use]
pub fn summary(verdict: Verdict, findings: &[Finding]) -> String {
    let names: Vec<String> = findings
        .iter()
        .filter(|f| f.mechanism != Mechanism::Unknown)
        .map(|f| f.mechanism.title().to_lowercase())
        .collect();
    let names = names.join(", ");
    match verdict {
        Verdict::Complete => "The twin explains the recording: what is left is noise.".to_owned(),
        Verdict::Explained => {
            format!("The twin lacked: {names}. With that, what is left is noise.")
        }
        Verdict::Partly => format!("The twin lacked: {names}; something without a name is left."),
        Verdict::Ambiguous => {
            format!("The twin lacked: {names}; this recording allows other names for it.")
        }
        Verdict::Unknown => {
            "Something is there that none of the known mechanisms makes.".to_owned()
        }
    }
}

fn finding(
    settled: &Settled,
    name: &Name,
    held: Option<&Option<f64>>,
    parameters: BTreeMap<String, Parameter>,
) -> Finding {
    let mechanism = name.hypothesis.mechanism;
    let place = place(settled, name, &parameters);
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
fn p_value(settled: &Settled, score: f64) -> f64 {
    let places = 10.0 * settled.given.edges() as f64;
    (places * (-0.5 * score).exp()).min(1.0)
}

/// Orders of the disc's pattern that were found one by one are one finding, that of the strongest.
fn one_disc(findings: &mut Vec<Finding>) {
    let lines = |finding: &Finding| finding.mechanism == Mechanism::LineError;
    let orders: Vec<f64> = findings
        .iter()
        .filter(|finding| lines(finding))
        .flat_map(|finding| finding.place.orders.clone())
        .collect();
    let mut first = true;
    findings.retain_mut(|finding| {
        if !lines(finding) {
            return true;
        }
        if first && orders.len() > 1 {
            finding.place.orders.clone_from(&orders);
            finding.text = format!(
                "{} orders of the turn, the same angle at any speed",
                orders.len()
            );
        }
        std::mem::take(&mut first)
    });
}

/// Edges of a disc that are so few that each is told by itself.
const FEW: usize = 16;

/// The disc's pattern as a finding.
fn disc(settled: &Settled) -> Option<Finding> {
    let pattern = settled.pattern.as_ref()?;
    let unit = Mechanism::LineError.card().unit("rms_rad");
    let parameter = |value: f64, standard_error: f64| Parameter {
        value,
        unit: unit.to_owned(),
        // Where the likelihood does not bend, there is no bound.
        ci95: standard_error
            .is_finite()
            .then_some([value - 1.96 * standard_error, value + 1.96 * standard_error]),
    };
    let mut rms = (pattern.rms_rad, pattern.standard_error_rad);
    let mut parameters = BTreeMap::new();
    let count = pattern.errors_rad.len();
    if count <= FEW {
        let squares: f64 = pattern.errors_rad.iter().map(|e| e * e).sum();
        let share = 1.0 / count as f64;
        rms = (
            (share * squares).sqrt(),
            pattern.edge_error_rad * share.sqrt(),
        );
        let each = pattern.errors_rad.iter().enumerate();
        parameters.extend(each.map(|(k, error)| {
            (
                format!("e_{k:02}_rad"),
                parameter(*error, pattern.edge_error_rad),
            )
        }));
    }
    parameters.insert("rms_rad".to_owned(), parameter(rms.0, rms.1));
    Some(Finding {
        mechanism: Mechanism::LineError,
        text: format!(
            "every edge has an error of its own, {:.3e} rad RMS, once a turn",
            rms.0
        ),
        confidence: 1.0,
        parameters,
        place: Place::default(),
        evidence: Evidence {
            delta_bic: pattern.score,
            p_value: p_value(settled, pattern.score),
            held_out_rms_ratio: settled.held.disc,
            runner_up: None,
        },
        look_alikes: Vec::new(),
        next_recording: None,
    })
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
        stamp_rms_s: Some(bench.noise.stamp_s),
        disturbed_s: one.track.slips.iter().map(|slip| slip.time_s).collect(),
    }
}

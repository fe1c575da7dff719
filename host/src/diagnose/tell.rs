//! The diagnosis in the user's terms.

use std::collections::BTreeMap;

use super::basis::{Basis, Change, change_of};
use super::beside::put_in;
use super::board::Bench;
use super::conclude::Name;
use super::diagnosis::{
    Diagnosis, Evidence, Finding, NextRecording, Parameter, Place, RecordingFacts, RunnerUp,
    Verdict,
};
use super::named::parameters;
use super::plots;
use super::run::{Diagnosed, Recorded};
use super::settle::Settled;
use crate::mechanism::Mechanism;

const R_MIN: f64 = 60.0 / std::f64::consts::TAU;

/// Everything that comes of what was settled.
#[must_use]
pub fn tell(rig: &[Recorded], settled: &Settled, beside: Vec<Finding>) -> Diagnosed {
    let mut findings: Vec<Finding> = settled
        .concluded
        .named
        .iter()
        .zip(&settled.estimates)
        .map(|(name, estimate)| finding(settled, name, parameters(estimate)))
        .collect();
    let numbers: Vec<Finding> = findings.clone();
    one_disc(&mut findings);
    findings.extend(
        disc(settled).filter(|_| !findings.iter().any(|f| f.mechanism == Mechanism::LineError)),
    );
    findings.extend(unknown(settled));
    let mut twins = settled.twins.clone();
    for twin in &mut twins {
        put_in(twin, &beside);
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
    let next = findings
        .iter()
        .find_map(|finding| finding.next_recording.clone());
    Diagnosed {
        shown: plots::shown(settled, &drawn),
        diagnosis: Diagnosis {
            version: 1,
            verdict,
            summary: summary(verdict, &findings),
            recordings: rig.iter().zip(&settled.given.benches).map(facts).collect(),
            fit: settled.fit,
            findings,
            next_recording: next,
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
        (false, _) if findings.iter().any(|f| f.next_recording.is_some()) => Verdict::Ambiguous,
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

fn finding(settled: &Settled, name: &Name, parameters: BTreeMap<String, Parameter>) -> Finding {
    let mechanism = name.hypothesis.mechanism;
    let place = place(settled, name, &parameters);
    let mut look_alikes = name.alike.clone();
    if mechanism == Mechanism::GearMesh && !look_alikes.contains(&Mechanism::Bearing) {
        look_alikes.push(Mechanism::Bearing);
    }
    Finding {
        mechanism,
        text: text(settled, name, &place),
        confidence: name.confidence,
        parameters,
        place,
        evidence: Evidence {
            delta_bic: name.score,
            p_value: p_value(settled, name.score),
            held_out_rms_ratio: None,
            runner_up: name.runner_up.map(|(mechanism, delta_bic)| RunnerUp {
                mechanism,
                delta_bic,
            }),
        },
        look_alikes,
        next_recording: (!name.alike.is_empty()).then(|| NextRecording {
            text: mechanism.separated_by().to_owned(),
            expected_delta_bic: None,
        }),
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
    let parameter = |value: f64, standard_error: f64| Parameter {
        value,
        unit: "rad".to_owned(),
        ci95: Some([value - 1.96 * standard_error, value + 1.96 * standard_error]),
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
            held_out_rms_ratio: None,
            runner_up: None,
        },
        look_alikes: Vec::new(),
        next_recording: None,
    })
}

fn unknown(settled: &Settled) -> Option<Finding> {
    let nameless = settled.concluded.nameless.as_ref()?;
    Some(Finding {
        mechanism: Mechanism::Unknown,
        text: nameless.text.clone(),
        confidence: 1.0,
        parameters: BTreeMap::new(),
        place: Place {
            orders: nameless.orders.clone(),
            frequencies_hz: nameless.frequencies_hz.clone(),
            ..Place::default()
        },
        evidence: Evidence {
            delta_bic: nameless.squares,
            p_value: nameless.p_value,
            held_out_rms_ratio: None,
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
        stamp_rms_s: bench.noise.stamp_s,
        disturbed_s: one.track.slips.iter().map(|slip| slip.time_s).collect(),
    }
}

const CHANNELS: [&str; 3] = ["A", "B", "C"];

fn place(settled: &Settled, name: &Name, parameters: &BTreeMap<String, Parameter>) -> Place {
    let mut place = Place::default();
    let value = |name: &str| parameters.get(name).map(|p| p.value);
    place.orders.extend(value("order"));
    place
        .frequencies_hz
        .extend(value("f_hz").or(value("task_hz")));
    place.times_s.extend(value("from_s"));
    place.times_s.extend(value("until_s"));
    if let Basis::Round { order } = name.hypothesis.bases[0]
        && place.orders.is_empty()
    {
        place.orders.push(order);
    }
    let Some(first) = settled.given.benches.first() else {
        return place;
    };
    let names = settled.class_names();
    let hit: Vec<usize> = (0..first.seen.classes as usize)
        .filter(|class| {
            hits(
                name.hypothesis.bases[0],
                change_of(*class, first.seen.classes),
            )
        })
        .collect();
    if hit.len() < names.len() {
        place.edge_classes = hit.iter().map(|class| names[*class].to_owned()).collect();
    }
    match name.hypothesis.bases[0] {
        Basis::Bump {
            angle_rad, channel, ..
        } => {
            place.angles_deg = vec![value("angle_rad").unwrap_or(angle_rad).to_degrees()];
            place
                .channels
                .extend(channel.map(|c| CHANNELS[c].to_owned()));
        }
        Basis::LevelTone { channel, .. } => {
            place
                .channels
                .extend(channel.map(|c| CHANNELS[c].to_owned()));
        }
        Basis::Shift { channel } | Basis::Late { channel } => {
            place.channels.push(CHANNELS[channel].to_owned());
        }
        _ => {}
    }
    place
}

/// Whether a pattern is on an edge.
fn hits(basis: Basis, change: Change) -> bool {
    match basis {
        Basis::Bump { channel, rises, .. } => {
            channel.is_none_or(|c| c == change.channel) && rises.is_none_or(|r| r == change.rises)
        }
        Basis::LevelTone { channel, .. } => channel.is_none_or(|c| c == change.channel),
        Basis::Width { channel } => !change.rises && channel.is_none_or(|c| c == change.channel),
        Basis::RiseLate { channel } => change.rises && channel.is_none_or(|c| c == change.channel),
        Basis::Shift { channel } | Basis::Late { channel } => channel == change.channel,
        _ => true,
    }
}

fn text(settled: &Settled, name: &Name, place: &Place) -> String {
    let first = |list: &[f64]| list.first().copied().unwrap_or(0.0);
    let (order, f_hz) = (first(&place.orders), first(&place.frequencies_hz));
    let edges = if place.edge_classes.is_empty() {
        "all edges alike".to_owned()
    } else {
        place.edge_classes.join(", ")
    };
    match name.hypothesis.bases[0] {
        Basis::Round { .. } | Basis::Lagged { .. } => {
            format!("order {order}, {edges}, the same angle at any speed")
        }
        Basis::TorqueOrder { .. } => {
            format!("order {order:.4}, {edges}, smaller the faster it turns")
        }
        Basis::TorqueTone { .. } => format!("{f_hz:.4} Hz, {edges}"),
        Basis::LevelTone { .. } => format!("{f_hz:.4} Hz, rising against falling edges ({edges})"),
        Basis::Width { .. } => format!("{edges} against the others, the same angle throughout"),
        Basis::RiseLate { .. } => {
            "rising against falling edges, the same time throughout".to_owned()
        }
        Basis::Shift { .. } => format!("{edges} against the others, the same angle throughout"),
        Basis::Late { .. } => format!("{edges} against the others, the same time throughout"),
        Basis::LevelDrift { .. } => {
            format!(
                "rising against falling edges, from {:.3} s on",
                first(&place.times_s)
            )
        }
        Basis::Bump { .. } => format!(
            "{edges}, at {:.2} degrees, once a turn",
            first(&place.angles_deg)
        ),
        Basis::Load { .. } => match place.times_s.as_slice() {
            [from, until] => format!("a push from {from:.4} to {until:.4} s"),
            _ => "a push from beginning or to the end".to_owned(),
        },
        Basis::Drift => "the speed changes evenly from beginning to end".to_owned(),
        Basis::Direction => "forward against reverse, all edges alike".to_owned(),
        Basis::Coulomb | Basis::Viscous | Basis::Drag | Basis::Stribeck { .. } => {
            "the course of the run-down".to_owned()
        }
        Basis::Task { .. } => {
            let _ = settled;
            format!("late captures at {f_hz:.3} Hz")
        }
    }
}

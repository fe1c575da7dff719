//! Findings that are no pattern in the angle: other motion, events in the count, and what the noise lacks.

use std::collections::BTreeMap;

use super::diagnosis::{Evidence, Finding, Parameter, Place, RunnerUp};
use super::events::{Event, undeclared};
use super::mend::FaultKind;
use super::motion::MotionFinding;
use super::noise::NoiseFinding;
use super::pushed::{Push, pushes};
use super::run::Recorded;
use super::track::Track;
use crate::mechanism::Mechanism;
use crate::twin::Twin;

const NORMAL_95: f64 = 1.959_964;

fn parameter(value: f64, standard_error: f64, unit: &str) -> Parameter {
    let half = NORMAL_95 * standard_error;
    Parameter {
        value,
        unit: unit.to_owned(),
        ci95: (half.is_finite() && half > 0.0).then_some([value - half, value + half]),
    }
}

/// A number that is known exactly.
fn number(mechanism: Mechanism, name: &str, value: f64) -> Parameter {
    parameter(value, 0.0, mechanism.card().unit(name))
}

/// A finding without a place yet.
pub(super) fn plain(mechanism: Mechanism, text: String, delta_bic: f64) -> Finding {
    Finding {
        mechanism,
        text,
        confidence: 1.0,
        parameters: BTreeMap::new(),
        place: Place::default(),
        evidence: Evidence {
            delta_bic,
            p_value: 0.0,
            held_out_rms_ratio: None,
            runner_up: None,
        },
        look_alikes: Vec::new(),
        next_recording: None,
    }
}

/// Another motion as a finding.
#[must_use]
pub fn of_motion(motion: &MotionFinding) -> Finding {
    let card = motion.mechanism.card();
    let named = motion.parameters.iter().map(|(name, value, error)| {
        let parameter = parameter(*value, *error, card.unit(name));
        ((*name).to_owned(), parameter)
    });
    Finding {
        parameters: named.collect(),
        ..plain(motion.mechanism, motion.text.clone(), motion.delta_bic)
    }
}

/// Pushes of all recordings as a finding.
#[must_use]
pub fn of_pushes(rig: &[Recorded]) -> Option<Finding> {
    let each = rig.iter().map(|one| (one, pushes(&one.track, &one.twin)));
    let all: Vec<(f64, Push)> = each
        .flat_map(|(one, pushes)| {
            let inertia = one.twin.shaft.inertia_kg_m2;
            pushes.into_iter().map(move |push| (inertia, push))
        })
        .collect();
    let (_, first) = all.first()?;
    let count = all.len() as f64;
    let long = |push: &Push| push.until_s - push.from_s;
    let seconds = all.iter().map(|(_, push)| long(push)).sum::<f64>() / count;
    let torques: Vec<f64> = all
        .iter()
        .map(|(inertia, push)| inertia * (push.speeds[1] - push.speeds[0]) / long(push))
        .collect();
    let mean = torques.iter().sum::<f64>() / count;
    let square = torques.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let text = format!(
        "{count} pushes while no drive is on, {seconds:.2} s each in the mean, the first at {:.4} s; only what lies between them \
         was compared with the twin",
        first.from_s
    );
    let mut finding = plain(Mechanism::LoadStep, text, EVENT);
    let parameters = [
        ("count", number(Mechanism::LoadStep, "count", count)),
        (
            "torque_n_m",
            parameter(mean, (square / count).sqrt(), "N m"),
        ),
    ];
    finding
        .parameters
        .extend(parameters.map(|(name, one)| (name.to_owned(), one)));
    finding.place.times_s = all.iter().map(|(_, push)| push.from_s).collect();
    Some(finding)
}

/// Evidence of one event: what a whole edge out of place would cost without it, at the least.
const EVENT: f64 = 1000.0;

/// Events of all recordings as findings.
#[must_use]
pub fn of_events(rig: &[Recorded]) -> Vec<Finding> {
    let each = rig.iter();
    let all: Vec<Event> = each
        .flat_map(|one| undeclared(&one.track, &one.twin))
        .collect();
    let mut found = Vec::new();
    for mechanism in [Mechanism::LostEdges, Mechanism::ExtraEdges] {
        let own: Vec<&Event> = all
            .iter()
            .filter(|event| event.mechanism == mechanism)
            .collect();
        if own.is_empty() {
            continue;
        }
        let what = if mechanism == Mechanism::LostEdges {
            "missing"
        } else {
            "too many"
        };
        let text = match own.len() {
            1 => format!("an edge {what} at {:.4} s", own[0].time_s),
            count => format!(
                "edges {what} at {count} places, the first at {:.4} s",
                own[0].time_s
            ),
        };
        let mut finding = plain(mechanism, text, EVENT * own.len() as f64);
        finding.parameters.insert(
            "count".to_owned(),
            number(mechanism, "count", own.len() as f64),
        );
        finding.place.times_s = own.iter().map(|event| event.time_s).collect();
        let mut channels: Vec<usize> = own.iter().filter_map(|event| event.channel).collect();
        channels.sort_unstable();
        channels.dedup();
        finding.place.channels = channels
            .iter()
            .map(|c| ["A", "B", "C"][(*c).min(2)].to_owned())
            .collect();
        found.push(finding);
    }
    for slip in all
        .iter()
        .filter(|event| event.mechanism == Mechanism::IndexSlip)
    {
        let text = format!(
            "the index moved by {} edges against the disc between {:.4} and {:.4} s",
            slip.edges, slip.between_s[0], slip.between_s[1]
        );
        let mut finding = plain(Mechanism::IndexSlip, text, EVENT);
        let at = Parameter {
            ci95: Some(slip.between_s),
            ..number(Mechanism::IndexSlip, "at_s", slip.time_s)
        };
        finding.parameters.insert("at_s".to_owned(), at);
        finding.parameters.insert(
            "edges".to_owned(),
            number(Mechanism::IndexSlip, "edges", f64::from(slip.edges)),
        );
        finding.place.times_s = vec![slip.time_s];
        found.push(finding);
    }
    found
}

/// What the noise lacks as a finding. A jitter is told as the twin has it: all of it, what was declared included, and so is the mean of
/// a latency.
#[must_use]
pub fn of_noise(noise: &NoiseFinding, one: &Recorded) -> Finding {
    let twin = &one.twin;
    let mut finding = plain(noise.mechanism, noise.text.clone(), noise.delta_bic);
    for one in &noise.parameters {
        let (mut value, mut error) = (one.value, one.standard_error);
        let late_s = twin.capture_latency.and_then(|latency| latency.mean_s);
        let declared = match one.name {
            "jitter_s" => twin.timer.jitter_s,
            "mean_s" => late_s.unwrap_or(0.0),
            _ => 0.0,
        };
        if declared > 0.0 {
            value = one.value.hypot(declared);
            error *= one.value / value;
        }
        let unit = noise.mechanism.card().unit(one.name);
        finding
            .parameters
            .insert(one.name.to_owned(), parameter(value, error, unit));
    }
    finding
        .place
        .frequencies_hz
        .clone_from(&noise.frequencies_hz);
    finding.place.times_s.clone_from(&noise.times_s);
    let names = one.plan.kind.class_names();
    let named = noise
        .edge_classes
        .iter()
        .filter_map(|class| names.get(*class));
    finding.place.edge_classes = named.map(|&name| name.to_owned()).collect();
    finding.evidence.p_value = noise.p_value;
    finding.evidence.runner_up = noise.runner_up.map(|(mechanism, delta_bic)| RunnerUp {
        mechanism,
        delta_bic,
    });
    if let Some((mechanism, worse)) = noise.runner_up {
        finding.confidence = 1.0 / (1.0 + (-0.5 * worse).exp());
        if worse < super::rivals::ALIKE && noise.mechanism != Mechanism::Unknown {
            finding.look_alikes.push(mechanism);
        }
    }
    finding
}

/// Puts findings that are no pattern into a twin.
pub fn put_in(twin: &mut Twin, findings: &[Finding]) {
    for finding in findings {
        (finding.mechanism.card().handling.puts_in)(twin, &finding.parameters);
    }
}

/// Puts the edges that a recording lacks into its twin, as far as they are counted for certain.
pub fn put_lost(twin: &mut Twin, track: &Track) {
    let sure = track.faults.iter().take_while(|fault| !fault.doubtful);
    let lost = sure.filter(|fault| fault.kind == FaultKind::Lost);
    let numbers = lost.filter_map(|fault| Some((fault.number?, u64::from(fault.edges))));
    let all = &mut twin.faults.lost_edges;
    all.extend(numbers.flat_map(|(first, count)| first..first + count));
    all.sort_unstable();
    all.dedup();
}

#[cfg(test)]
mod tests;

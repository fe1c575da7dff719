//! The numbers behind an answer: evidence, identifiable parameters, recordings.

use crate::diagnose::diagnosis::Answer;
use crate::diagnose::diagnosis::{Diagnosis, Finding, Parameter, RecordingFacts};
use crate::diagnose::edges::{Stretch, Unused};
use crate::report::{Body, Cell, si, si_digits};
use crate::reports::diagnose::recordings::{origin, speed, table};
use crate::reports::diagnose::words::{in_order, list, probability};

use super::sure::{confidence, determined};
use super::told::{self, title};

/// What is known beside the findings: a disc and a drive that were learned, and what could not be determined.
pub(super) fn beside(answer: &Answer) -> Vec<String> {
    let disc = answer.learned_disc_rms_rad.map(|rms| {
        format!(
            "The twin does not give the disc: its edges were learned here, {} RMS off their places (--write-twin keeps them).",
            si(rms, "rad")
        )
    });
    let sized = |value: f64, unit: &str, digits: usize| {
        let (number, unit) = si_digits(value, unit, digits);
        format!("{number} {unit}")
    };
    let looped = answer.learned_speed_loop.map(|looped| {
        format!(
            "The twin does not give the drive: the edges show a speed loop that samples at {}, with gains of about {} and {}.",
            sized(looped.f_hz, "Hz", 7),
            sized(looped.kp_n_m_s, "N m s", 3),
            sized(looped.ki_n_m, "N m", 2),
        )
    });
    let rings = answer.learned_ringing.map(|ringing| {
        format!(
            "The twin does not give the drive: noise keeps it or the machine ringing at about {}, with a damping ratio of about {}. \
             Torques near that frequency are stated too large, as such a mode amplifies them.",
            sized(ringing.f_hz, "Hz", 2),
            si_digits(ringing.damping_ratio, "", 1).0,
        )
    });
    let open = (!answer.not_identifiable.is_empty()).then(|| {
        format!(
            "Not determined by these recordings: {}.",
            answer.not_identifiable.join("; ")
        )
    });
    let drive = looped.into_iter().chain(rings);
    disc.into_iter().chain(drive).chain(open).collect()
}

/// Evidence and parameters of each finding.
pub(super) fn numbers(answer: &Answer) -> Body {
    let mut body = Body::new();
    let findings = &answer.diagnosis.findings;
    for text in beside(answer) {
        body.section("", &[&text]);
    }
    if findings.is_empty() {
        body.section("", &["Nothing was found."]);
        return body;
    }
    let names = |index: usize, finding: &Finding| {
        Cell::from(format!(
            "{}. {}",
            index + 1,
            title(finding, told::effects(answer, index))
        ))
    };
    let rows = findings.iter().enumerate().map(|(index, finding)| {
        let evidence = &finding.evidence;
        let next = evidence.runner_up.as_ref();
        let ratio = evidence.held_out_rms_ratio;
        vec![
            names(index, finding),
            Cell::Number(confidence(finding)),
            criterion(evidence.delta_bic),
            Cell::Number(probability(evidence.p_value)),
            ratio.map_or(Cell::Empty, |ratio| Cell::Number(si_digits(ratio, "", 3).0)),
            next.map_or_else(|| "–".into(), |next| next.mechanism.id().into()),
            next.map_or(Cell::Empty, |next| criterion(next.delta_bic)),
        ]
    });
    body.table(
        "Evidence. ΔBIC: Schwarz's criterion without the finding less that with it; 10 is strong. p: noise alone shows as much.",
        &[
            "Finding",
            "Confidence",
            "ΔBIC",
            "p",
            "Held-out RMS ratio",
            "Next best",
            "ΔBIC of that",
        ],
        rows.collect(),
    );
    let mut rows = Vec::new();
    for (index, finding) in findings.iter().enumerate() {
        for (name, parameter) in in_order(&finding.parameters) {
            let unit = told::unit(answer, index, name, parameter);
            let parameter = Parameter {
                unit,
                ..parameter.clone()
            };
            rows.push(vec![
                names(index, finding),
                name.as_str().into(),
                Cell::Number(told::number(&parameter)),
                match determined(name, &parameter) {
                    Some(true) => "yes",
                    Some(false) => "no",
                    None => "exact",
                }
                .into(),
            ]);
        }
    }
    if !rows.is_empty() {
        body.table(
            "Parameters. One is identifiable where its 95 % interval leaves zero out; a phase, where that is within 1 rad to either side.",
            &["Finding", "In twin and JSON", "Value, 95 % interval", "Identifiable"],
            rows,
        );
    }
    body
}

fn criterion(delta: f64) -> Cell {
    match delta.is_finite() {
        true if delta.abs() < 1e5 => Cell::fixed(delta, 1),
        true => Cell::Number(si_digits(delta, "", 3).0),
        false => Cell::Empty,
    }
}

/// What was read.
pub(super) fn recordings(diagnosis: &Diagnosis) -> Body {
    let mut body = Body::new();
    table(&mut body, &diagnosis.recordings);
    for facts in &diagnosis.recordings {
        if !facts.disturbed_s.is_empty() {
            let times = facts.disturbed_s.iter().map(|t| format!("{t:.4} s"));
            let times: Vec<String> = times.collect();
            let text = format!(
                "The count of {} was disturbed at {}.",
                facts.file,
                first_of(&times)
            );
            body.section("", &[&text]);
        }
    }
    body
}

/// The first of some instants or stretches.
fn first_of(all: &[String]) -> String {
    const LISTED: usize = 10;
    match all.len().saturating_sub(LISTED) {
        0 => list(all),
        more => format!(
            "{} and {more} more (--json lists all)",
            all[..LISTED].join(", ")
        ),
    }
}

/// A recording in a line.
pub(super) fn recording(facts: &RecordingFacts) -> String {
    let of = match facts.edges_recorded {
        all if all > facts.edges => format!(" of {all}"),
        _ => String::new(),
    };
    let mut text = format!(
        "{} against {}: {}{of} edges in {:.1} turns, {} at {}; ",
        facts.file,
        facts.twin,
        facts.edges,
        facts.turns,
        si(facts.seconds, "s"),
        speed(facts.speed_r_min),
    );
    if let Some(stamp) = facts.stamp_rms_s {
        text += &format!("time stamps to {}, ", si(stamp, "s"));
    }
    text += &format!("angles from {}", origin(facts));
    match facts.disturbed_s.len() {
        0 => {}
        1 => text += "; count disturbed at 1 instant",
        times => text += &format!("; count disturbed at {times} instants"),
    }
    for why in [Unused::EitherWay, Unused::OffPattern, Unused::Bounces] {
        let own = facts.left_out.iter().filter(|stretch| stretch.why == why);
        let edges: usize = own.clone().map(|stretch| stretch.rows).sum();
        let each = own.map(
            |Stretch {
                 from_s, until_s, ..
             }| format!("{from_s:.2} to {until_s:.2} s"),
        );
        let each: Vec<String> = each.collect();
        if !each.is_empty() {
            text += &format!("; left out: {}, {}", first_of(&each), because(why, edges));
        }
    }
    text
}

/// Why some edges were left out.
fn because(why: Unused, edges: usize) -> String {
    match why {
        Unused::EitherWay => {
            "as it stops and one channel does not show which way it goes on".to_owned()
        }
        Unused::OffPattern => {
            format!(
                "as the {edges} edges there do not follow the wheel: it rocks back, or pulses are lost in a row"
            )
        }
        Unused::Bounces => {
            format!("as the {edges} edges there come far too fast for the speed beside them")
        }
    }
}

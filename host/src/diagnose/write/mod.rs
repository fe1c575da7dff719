//! The twins with the findings in them. A named finding changes the section of its mechanism; what no section can say is an
//! `[[effect]]`; so the new twin does what was fitted, and no more.

mod rhythm;
mod signal;
mod torque;

pub use rhythm::Span;

use super::diagnosis::{Answer, Finding, LearnedDisc, Sized};
use super::edges::CountKind;
use super::effect::{Carrier, Growth, Site};
use super::events::ROWS_A_GLITCH;
use super::numbers::{self, Knob};
use super::rig::Recorded;
use crate::mechanism::Mechanism;
use crate::sim;
use crate::twin::{CaptureLatency, DeclaredEffect, IndexSlip, Twin, TwinError};

/// A twin with findings in it.
#[derive(Clone, Debug)]
pub struct Written {
    /// The twin.
    pub twin: Twin,
    /// Its disc, where that was learned: for a list beside it.
    pub disc: Option<LearnedDisc>,
}

/// The twin of each recording with the findings in it.
///
/// # Errors
/// As [`sim::true_errors`].
pub fn twins(rig: &[Recorded], answer: &Answer) -> Result<Vec<Written>, TwinError> {
    let each = rig.iter().zip(&answer.corrected).enumerate();
    each.map(|(at, (one, corrected))| written(at, one, corrected, answer))
        .collect()
}

fn written(
    at: usize,
    one: &Recorded,
    corrected: &[(Knob, Vec<f64>)],
    answer: &Answer,
) -> Result<Written, TwinError> {
    let corrected = corrected.iter();
    let corrected: Vec<(&Knob, &[f64])> = corrected.map(|(knob, now)| (knob, &now[..])).collect();
    let mut twin = one.twin.clone();
    let keep = |twin: &mut Twin, new: Option<Twin>| {
        let new = new.filter(|new| new.check().is_ok());
        new.map(|new| *twin = new).is_some()
    };
    keep(&mut twin, numbers::changed(&one.twin, &corrected));
    let span = Span::of(one);
    let elsewhere = |cell: &Sized| cell.effect.only.is_some_and(|only| usize::from(only) != at);
    for (finding, cells) in answer.diagnosis.findings.iter().zip(&answer.cells) {
        if cells.iter().any(elsewhere) {
            continue;
        }
        // A section that can't take the numbers leaves them to effects.
        let mut new = twin.clone();
        let took = match cells.is_empty() {
            true => put_counted(&mut new, finding, one).is_some(),
            false => cells
                .iter()
                .filter(|cell| !matches!(cell.effect.site, Site::Declared(_)))
                .all(|cell| finding.mechanism != Mechanism::Unknown && put(&mut new, cell, &span)),
        };
        if keep(&mut twin, took.then_some(new)) {
            continue;
        }
        for cell in cells {
            let mut new = twin.clone();
            new.effect
                .extend(DeclaredEffect::of(&cell.effect, &cell.sizes));
            keep(&mut twin, Some(new));
        }
    }
    let pattern = answer.pattern.as_ref();
    let disc = pattern.map(|pattern| learned(&twin, pattern)).transpose()?;
    Ok(Written { twin, disc })
}

/// The disc that a twin gives with what was learned beside it. What sections add to a list stays out of it.
fn learned(twin: &Twin, pattern: &LearnedDisc) -> Result<LearnedDisc, TwinError> {
    let more = &pattern.errors_rad;
    let plain = Twin {
        local_defect: Vec::new(),
        effect: Vec::new(),
        ..twin.clone()
    };
    let known = sim::true_errors(&plain)?;
    // Of a wheel recorded with one edge of each tooth the other goes along.
    let every = (known.len() / more.len().max(1)).max(1);
    let each = known.iter().step_by(every).zip(more);
    Ok(LearnedDisc {
        errors_rad: each.map(|(known, more)| known + more).collect(),
        spread: pattern.spread.clone(),
    })
}

/// Changes the section of an effect; false where none can say it.
fn put(twin: &mut Twin, cell: &Sized, span: &Span) -> bool {
    let (carrier, size) = (cell.effect.carrier, cell.sizes[0]);
    match cell.effect.site {
        _ if cell.effect.growth != Growth::Constant => false,
        Site::Disc(on) => signal::put_disc(twin, on, cell, span),
        Site::Level(on) => signal::put_level(twin, on, cell, span),
        Site::Stamp(on) => carrier == Carrier::Steady && signal::put_delay(twin, on, size),
        Site::Torque => torque::put_torque(twin, cell, span),
        Site::Drive => torque::put_drift(twin, carrier, size),
        Site::Declared(_) => false,
    }
}

/// What is counted, or is noise of the stamps; none where a twin has no key for it.
fn put_counted(twin: &mut Twin, finding: &Finding, one: &Recorded) -> Option<()> {
    let number = |name: &str| finding.parameters.get(name).map(|number| number.value);
    let edges = &one.edges;
    match finding.mechanism {
        Mechanism::TimestampJitter => {
            twin.timer.jitter_s = number("jitter_s")?;
        }
        Mechanism::CaptureLatency => {
            let there = twin.capture_latency.and_then(|latency| latency.mean_s);
            twin.capture_latency = Some(match number("mean_s") {
                // On top of what is declared.
                Some(mean_s) => CaptureLatency {
                    mean_s: Some(mean_s.hypot(there.unwrap_or(0.0))),
                    ..CaptureLatency::default()
                },
                None => CaptureLatency {
                    mean_s: None,
                    task_hz: Some(number("task_hz")?),
                    busy_s: number("busy_s"),
                    phase_s: number("phase_s"),
                },
            });
        }
        Mechanism::LostEdges => {
            let mut before = 0;
            let mut lost = Vec::new();
            let events = edges.events.iter();
            for event in events.filter(|event| event.kind == CountKind::Lost) {
                // The first row only says where the levels start.
                let seen = 1 + edges.time_s.partition_point(|time| *time < event.time_s);
                let first = seen as u64 + before;
                let count = u64::from(event.edges.unsigned_abs());
                lost.extend(first..first + count);
                before += count;
            }
            twin.faults.lost_edges = lost;
        }
        Mechanism::ExtraEdges => {
            let extra = edges.events.iter();
            let extra = extra.filter(|event| event.kind == CountKind::Extra);
            let rows: i32 = extra.map(|event| event.edges).sum();
            let count = edges.time_s.len().max(1) as f64;
            twin.faults.glitch_probability =
                (f64::from(rows) / (f64::from(ROWS_A_GLITCH) * count)).min(1.0);
            if twin.faults.glitch_width_s == 0.0 {
                // The recording does not show it: a tenth of the mean interval.
                twin.faults.glitch_width_s = 0.1 * Span::of(one).seconds / count;
            }
        }
        Mechanism::IndexSlip => twin.index_slip.push(IndexSlip {
            at_s: number("at_s")?,
            edges: number("edges")? as i32,
        }),
        _ => return None,
    }
    Some(())
}

#[cfg(test)]
mod tests;

//! What swings in a machine at a rate of its own: gears, belts and bearings at orders that are not whole, tones at a frequency. A
//! diagnosis of each recording beside its sensor finds them; where they were in their cycle when it began is each recording's own.

use super::estimate::{Placed, bare};
use super::sensor::Found;
use super::{Estimate, StartingError};
use crate::diagnose::diagnosis::{Answer, Sized};
use crate::diagnose::pipeline;
use crate::diagnose::rig::Recorded;
use crate::diagnose::search::FINDINGS;
use crate::diagnose::write::Span;
use crate::effect::words::words;
use crate::effect::{Carrier, Effect, Growth, On, Site};

/// How often what is found is put into the twin, as a diagnosis says so many findings at the most.
const ROUNDS: usize = 3;
/// Part of a cycle over a recording by which two rates have to part to be two.
const APART: f64 = 1.0;

/// What swings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rhythm {
    /// A torque or a run-out at an order, or a torque at a frequency.
    effect: Effect,
    /// Cycles a turn, or Hz.
    pub rate: Estimate,
    /// Amplitude: of a torque over the inertia, rad/s^2; of a run-out rad.
    pub size: Estimate,
    /// Phase of the sine where the recording that showed it began, rad.
    pub phase_rad: f64,
}

impl Rhythm {
    /// Of what was found in a recording; none where it is not of the machine, or is of the disc.
    fn of(cell: &Sized) -> Option<Self> {
        let Effect {
            site,
            carrier,
            growth: Growth::Constant,
            ..
        } = cell.effect
        else {
            return None;
        };
        let rate = match (site, carrier) {
            (Site::Torque | Site::Disc(On::ALL), Carrier::Order(order)) if order.fract() != 0.0 => {
                order
            }
            (Site::Torque, Carrier::Tone(f_hz)) => f_hz,
            _ => return None,
        };
        let [cos, sin] = cell.sizes[..] else {
            return None;
        };
        let estimate = |value: f64, at: usize| {
            let ci95 = (*cell.ci95.get(at)?)?;
            Some(Estimate { value, ci95 })
        };
        Some(Self {
            effect: cell.effect,
            rate: estimate(rate, 1).unwrap_or(Estimate::normal(rate, 0.0)),
            size: estimate(f64::hypot(cos, sin), 0)?,
            phase_rad: f64::atan2(cos, sin),
        })
    }

    /// Its section, keys of its rate and its size there, and the size's unit.
    pub(super) const fn keys(&self) -> (&'static str, &'static str, &'static str, &'static str) {
        match (self.effect.site, self.effect.carrier) {
            (Site::Torque, Carrier::Tone(_)) => ("torque_tone", "f_hz", "torque_n_m", "N m"),
            (Site::Torque, _) => ("gear_mesh", "order", "torque_n_m", "N m"),
            _ => ("bearing", "order", "runout_rad", "rad"),
        }
    }

    /// It in words.
    pub(super) fn words(&self) -> String {
        words(&self.effect)
    }

    /// Whether another one may be the same in a recording that goes so far.
    fn is(&self, other: &Self, span: &Span) -> bool {
        let length = match (self.effect.carrier, other.effect.carrier) {
            (Carrier::Tone(_), Carrier::Tone(_)) => span.seconds,
            (Carrier::Order(_), Carrier::Order(_)) => span.turns,
            _ => return false,
        };
        (self.rate.value - other.rate.value).abs() * length < APART
    }
}

/// Finds what swings in any of the recordings.
///
/// # Errors
/// [`StartingError`] where a recording can't be compared.
pub fn find(
    found: &Found,
    clock_hz: u64,
    recordings: &[Placed],
    progress: &mut dyn FnMut(f64, &'static str),
) -> Result<Vec<Rhythm>, StartingError> {
    let mut all: Vec<Rhythm> = Vec::new();
    for (at, one) in recordings.iter().enumerate() {
        for _ in 0..ROUNDS {
            let mut rig = [Recorded {
                file: one.file.clone(),
                edges: one.edges.clone(),
                twin: bare(found, clock_hz, &all)?,
            }];
            let span = Span::of(&rig[0]);
            // What can't be diagnosed may still have a twin.
            let Ok(answer) = pipeline::diagnose(&mut rig, &mut |done, _| {
                let done = (at as f64 + done) / recordings.len() as f64;
                progress(done, "Looking for gears and tones");
            }) else {
                break;
            };
            let full = answer.diagnosis.findings.len() >= FINDINGS;
            let new = swings(&answer);
            let new: Vec<Rhythm> = { new.into_iter() }
                .filter(|one| !all.iter().any(|other| one.is(other, &span)))
                .collect();
            let done = new.is_empty() || !full;
            all.extend(new);
            if done {
                break;
            }
        }
    }
    Ok(all)
}

fn swings(answer: &Answer) -> Vec<Rhythm> {
    let cells = answer.cells.iter().flatten();
    cells.filter_map(Rhythm::of).collect()
}

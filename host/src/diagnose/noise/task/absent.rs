//! A task that a twin declares and its recording has not: edges were captured at once at every phase that the task could have.

use rayon::prelude::*;

use super::super::super::board::Board;
use super::super::super::run::Recorded;
use super::super::NoiseFinding;
use super::super::NoiseParameter;
use super::busy::Busy;
use super::declared::declared;
use super::stamps::Stamps;
use crate::mechanism::Mechanism;
use crate::report::si;

/// Fall of the logarithm of the likelihood at every phase from which on a task is not there.
const ABSENT: f64 = 20.0;
/// Phases that a busy time covers.
const STEPS: f64 = 4.0;
/// Phases at the most: of a task that is busy for less of its period few edges tell.
const PHASES: f64 = 1000.0;
/// Edges that are enough.
const EDGES: usize = 20_000;

/// The twins' task as a finding, of no busy time, if no recording has it; `left` is what everything else leaves, white.
#[must_use]
pub fn absent(rig: &[Recorded], board: &Board, left: &[Vec<f64>]) -> Option<NoiseFinding> {
    let (f_hz, busy_s) = declared(&rig.first()?.twin)?;
    let mut gain = 0.0;
    for ((one, bench), left) in rig.iter().zip(&board.benches).zip(left) {
        let best = best(&Stamps::of(bench, left), declared(&one.twin)?);
        if best > -ABSENT {
            return None;
        }
        gain += best;
    }
    Some(NoiseFinding {
        mechanism: Mechanism::CaptureLatency,
        parameters: vec![NoiseParameter {
            name: "busy_s",
            value: 0.0,
            standard_error: 0.0,
        }],
        delta_bic: -2.0 * gain,
        p_value: gain.exp(),
        text: format!(
            "no task holds up captures here; the twin's does {f_hz:.3} times a second for {}",
            si(busy_s, "s")
        ),
        frequencies_hz: vec![f_hz],
        times_s: Vec::new(),
        edge_classes: Vec::new(),
        runner_up: None,
        busy: None,
    })
}

/// The largest gain in the logarithm of the likelihood that a task has at any phase.
fn best(row: &Stamps<'_>, (f_hz, busy_s): (f64, f64)) -> f64 {
    let phases = (STEPS / (busy_s * f_hz)).ceil().min(PHASES);
    let before = row.len().saturating_sub(EDGES) / 2;
    let middle = before..row.len().min(before + EDGES);
    let each = (0..phases as usize).into_par_iter().map(|phase| {
        let task = Busy {
            f_hz,
            busy_s,
            ends_s: vec![row.middle_s() + phase as f64 / (phases * f_hz)],
        };
        row.gain_of(middle.clone(), &task, 0)
    });
    each.reduce(|| f64::NEG_INFINITY, f64::max)
}

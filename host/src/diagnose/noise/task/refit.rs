//! A task fitted once more, with all else that was found taken off and in the noise that is left without its delays; and how late
//! edges are along its period.

use super::super::super::board::Board;
use super::super::NoiseFinding;
use super::busy::Busy;
use super::fit::fitted;
use super::number;
use super::stamps::Stamps;
use crate::diagnose::ends::Ends;
use crate::diagnose::shown::{FindingPlot, Line};
use crate::mechanism::Mechanism;

/// Cells of the period that is drawn.
const CELLS: usize = 120;
/// Busy times before and after that are drawn beside it.
const BESIDE: f64 = 1.0;

/// A task fitted once more.
#[derive(Clone, Debug)]
pub struct Refit {
    /// As a finding.
    pub finding: NoiseFinding,
    /// Stamps of each recording that may have been held up.
    pub ends: Vec<Option<Ends>>,
    /// Lateness along its period.
    pub plot: FindingPlot,
}

/// Fits a task once more; `left` is what everything else leaves, white, with the task's delays in it.
#[must_use]
pub fn refit(board: &Board, left: &[Vec<f64>], finding: &NoiseFinding) -> Option<Refit> {
    let first = finding.busy.clone()?;
    let pairs = board.benches.iter().zip(left);
    let mut rows: Vec<Stamps<'_>> = pairs.map(|(bench, left)| Stamps::of(bench, left)).collect();
    let found = fitted(&mut rows, first)?;
    let mut finding = finding.clone();
    number(&mut finding, &found);
    Some(Refit {
        ends: found.task.ends(&rows),
        plot: plot(&rows, &found.task),
        finding,
    })
}

/// How late edges are against where the others let them cross, about the busy time.
fn plot(rows: &[Stamps<'_>], task: &Busy) -> FindingPlot {
    let period = 1.0 / task.f_hz;
    let from = (-BESIDE * task.busy_s).max(-0.5 * (period - task.busy_s));
    let until = (1.0 + BESIDE) * task.busy_s;
    let wide = (until.min(from + period) - from) / CELLS as f64;
    let mut cells = vec![[0.0; 4]; CELLS];
    for (row, end_s) in rows.iter().zip(&task.ends_s) {
        for at in (0..row.len()).filter(|at| row.weight(*at) > 0.0) {
            let begun = end_s - task.busy_s + from;
            let since = (row.crossed_s(at) - begun).rem_euclid(period);
            let Some(cell) = cells.get_mut((since / wide) as usize) else {
                continue;
            };
            let x = since + from;
            let makes = if (0.0..task.busy_s).contains(&x) {
                task.busy_s - x
            } else {
                0.0
            };
            let more = [x, row.late_s[at], makes, 1.0];
            cell.iter_mut()
                .zip(more)
                .for_each(|(sum, more)| *sum += more);
        }
    }
    let line = |y: &dyn Fn(&[f64; 4]) -> f64| -> Line {
        let there = cells.iter().filter(|cell| cell[3] > 0.0);
        there
            .map(|cell| (1e6 * cell[0] / cell[3], 1e6 * y(cell) / cell[3]))
            .collect()
    };
    FindingPlot {
        mechanism: Mechanism::CaptureLatency,
        x_label: "time since the task began, us".to_owned(),
        y_label: "how late edges come, us".to_owned(),
        before: line(&|cell| cell[1]),
        after: line(&|cell| cell[1] - cell[2]),
        model: line(&|cell| cell[2]),
    }
}

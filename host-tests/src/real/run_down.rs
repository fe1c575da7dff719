//! Run-downs of a wheel by themselves: where it is pushed, and by which power of the speed it slows down. Shares no code with the
//! diagnosis.

use std::f64::consts::TAU;

/// What the run-downs of a wheel say.
#[derive(Clone, Copy, Debug)]
pub struct RunDowns {
    /// How many.
    pub count: usize,
    /// Power of the speed that the deceleration goes with.
    pub exponent: f64,
    /// Deceleration over the square of the speed, 1/rad.
    pub drag: f64,
}

/// From the times of pulses, s, so many a turn.
#[must_use]
pub fn run_downs(times_s: &[f64], a_turn: usize) -> Option<RunDowns> {
    // A wheel that slows down for ten turns, without two on either side.
    let (least, side) = (10 * a_turn, 2 * a_turn);
    let half = a_turn / 2;
    let speeds: Vec<f64> = (half..times_s.len() - half)
        .map(|at| TAU / (times_s[at + half] - times_s[at - half]))
        .collect();
    let mut runs = Vec::new();
    let mut from = a_turn;
    for at in a_turn..=speeds.len() {
        if at == speeds.len() || speeds[at] >= speeds[at - a_turn] {
            if at - from > least {
                runs.push(from + side..at - side);
            }
            from = at;
        }
    }
    let (mut x, mut y, mut drag) = (Vec::new(), Vec::new(), 0.0);
    for run in &runs {
        let middle = (run.start + run.end) / 2;
        for part in [run.start..middle, middle..run.end] {
            let time = |at: usize| times_s[at + half];
            let (slope, mean) = slope(part.clone().map(|at| (time(at), speeds[at])))?;
            if slope < 0.0 {
                x.push(mean.ln());
                y.push((-slope).ln());
                drag -= slope / (mean * mean);
            }
        }
    }
    let (exponent, _) = slope(x.iter().copied().zip(y.iter().copied()))?;
    Some(RunDowns {
        count: runs.len(),
        exponent,
        drag: drag / x.len() as f64,
    })
}

/// Slope of a straight line through points, and the mean of y.
fn slope(points: impl Iterator<Item = (f64, f64)> + Clone) -> Option<(f64, f64)> {
    let count = points.clone().count() as f64;
    let (sx, sy) = points
        .clone()
        .fold((0.0, 0.0), |s, p| (s.0 + p.0, s.1 + p.1));
    let (mx, my) = (sx / count, sy / count);
    let (xy, xx) = points.fold((0.0, 0.0), |s, (x, y)| {
        (s.0 + (x - mx) * (y - my), s.1 + (x - mx) * (x - mx))
    });
    (xx > 0.0).then_some((xy / xx, my))
}

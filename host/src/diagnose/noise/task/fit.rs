//! The fit of a task, by turns (A. P. Dempster, N. M. Laird, D. B. Rubin, J. R. Stat. Soc. B 39, 1977): which edges it held up, the line
//! through their stamps, how long it blocks, and where edges beside them are expected.

use rayon::prelude::*;

use super::busy::Busy;
use super::stamps::Stamps;

/// Turns at the most.
const TURNS: usize = 6;
/// Standard errors of the busy time that are no change any more.
const NEAR: f64 = 0.03;
/// Busy times over the last one that are tried: single edges decide between them, so that a likelihood that is narrow may be another's.
const AROUND: [f64; 2] = [0.3, 1.5];
/// Busy times that are tried at once, and times that they are narrowed down.
const TRIED: usize = 24;
const NARROWED: usize = 5;
/// Fall of the logarithm of the likelihood beyond which a busy time is out of the question.
const OUT: f64 = 9.0;

/// A task with what is known of it.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// It.
    pub task: Busy,
    /// Standard errors of rate, busy time and the first recording's end at the clock's zero.
    pub errors: [f64; 3],
    /// Edges that it held up.
    pub held: f64,
    /// Gain in the logarithm of the likelihood.
    pub gain: f64,
}

/// Fits a task; the rows are left without it.
#[must_use]
pub fn fitted(rows: &mut [Stamps<'_>], first: Busy) -> Option<Fitted> {
    let mut task = first;
    let mut busy_error = 0.0;
    let mut errors = None;
    for _ in 0..TURNS {
        let before = (task.busy_s, busy_error);
        (task.busy_s, busy_error) = busy(rows, &task)?;
        errors = lined(rows, &mut task);
        errors?;
        for (number, row) in rows.iter_mut().enumerate() {
            row.clear(&task, number);
        }
        let near = |now: f64, before: f64| (now - before).abs() < NEAR * busy_error;
        if near(task.busy_s, before.0) && near(busy_error, before.1) {
            break;
        }
    }
    let (rate_error, end_error, held) = errors?;
    let gains = rows
        .iter()
        .enumerate()
        .map(|(number, row)| row.gain(&task, number));
    let gain = gains.sum();
    Some(Fitted {
        errors: [rate_error, busy_error, end_error],
        held,
        gain,
        task,
    })
}

/// Gain of the edges of each recording that hang on it.
fn gain(rows: &[Stamps<'_>], near: &[Vec<usize>], task: &Busy) -> f64 {
    rows.iter()
        .zip(near)
        .enumerate()
        .map(|(number, (row, near))| row.gain_of(near.iter().copied(), task, number))
        .sum()
}

/// How long it blocks, and the standard error of that: mean and deviation of the likelihood, which does not bend evenly, as single edges
/// at the beginning of the busy time decide it.
fn busy(rows: &[Stamps<'_>], task: &Busy) -> Option<(f64, f64)> {
    let (least, most) = (1e-3 * task.busy_s, 0.9 / task.f_hz);
    let [low, high] = AROUND.map(|part| part * task.busy_s);
    let (mut low, mut high) = (low.max(least), high.min(most));
    let mut known = None;
    for _ in 0..NARROWED {
        let step = (high - low) / (TRIED - 1) as f64;
        let longest = Busy {
            busy_s: high,
            ..task.clone()
        };
        let rows_near = rows.iter().enumerate();
        let near: Vec<Vec<usize>> = rows_near
            .map(|(number, row)| row.all_near(&longest, number))
            .collect();
        let gains: Vec<(f64, f64)> = (0..TRIED)
            .into_par_iter()
            .map(|i| {
                let busy_s = low + i as f64 * step;
                let with = Busy {
                    busy_s,
                    ..task.clone()
                };
                (busy_s, gain(rows, &near, &with))
            })
            .collect();
        let top = gains
            .iter()
            .map(|one| one.1)
            .fold(f64::NEG_INFINITY, f64::max);
        let (mut sum, mut mean, mut square) = (0.0, 0.0, 0.0);
        for (busy_s, gain) in &gains {
            let weight = (gain - top).exp();
            sum += weight;
            mean += weight * busy_s;
            square += weight * busy_s * busy_s;
        }
        mean /= sum;
        let own = (square / sum - mean * mean).max(0.0);
        // Between two that were tried nothing is known.
        known = Some((mean, (own + step * step / 12.0).sqrt()));
        let there = |one: &&(f64, f64)| one.1 > top - OUT;
        let from = gains.iter().find(there)?.0;
        let until = gains.iter().rfind(there)?.0;
        if until - from > 0.4 * (high - low) {
            break;
        }
        (low, high) = ((from - step).max(least), (until + step).min(most));
    }
    known.filter(|(mean, _)| *mean > 0.0)
}

/// Puts the line through the stamps of the edges that were held up into a task; standard errors of the rate and of the first recording's end
/// at the clock's zero, and how many edges there are.
fn lined(rows: &[Stamps<'_>], task: &mut Busy) -> Option<(f64, f64, f64)> {
    // About each recording's own middle the lines share nothing but their slope.
    let (mut wide, mut along) = (0.0, 0.0);
    let mut lines = Vec::with_capacity(rows.len());
    let mut all = 0.0;
    for (number, row) in rows.iter().enumerate() {
        let weight = 1.0 / (row.jitter_s * row.jitter_s);
        let end_s = task.ends_s[number];
        let points: Vec<(f64, f64, f64)> = row
            .held(task, number)
            .into_iter()
            .map(|(at, held, period)| {
                let off = row.bench.seen.times_s[at] - end_s - period / task.f_hz;
                (held, period, off)
            })
            .collect();
        let count: f64 = points.iter().map(|p| p.0).sum();
        all += count;
        let mean = |value: &dyn Fn(&(f64, f64, f64)) -> f64| {
            points.iter().map(|p| p.0 * value(p)).sum::<f64>() / count.max(f64::MIN_POSITIVE)
        };
        let (period, off) = (mean(&|p| p.1), mean(&|p| p.2));
        wide += weight
            * points
                .iter()
                .map(|p| p.0 * (p.1 - period).powi(2))
                .sum::<f64>();
        along += weight
            * points
                .iter()
                .map(|p| p.0 * (p.1 - period) * (p.2 - off))
                .sum::<f64>();
        lines.push((count, period, off));
    }
    if all < 3.0 || wide <= 0.0 {
        return None;
    }
    let slope = along / wide;
    let before = task.f_hz;
    task.f_hz = 1.0 / (1.0 / before + slope);
    for (end, (count, period, off)) in task.ends_s.iter_mut().zip(&lines) {
        if *count > 0.5 {
            *end += off - slope * period;
        }
    }
    let slope_error = wide.sqrt().recip();
    let (row, (count, period, _)) = (rows.first()?, lines.first()?);
    let own = row.jitter_s * count.max(0.1).sqrt().recip();
    let periods = period + task.ends_s[0] * task.f_hz;
    // Ticks are counted, not rounded.
    let tick_s = row.bench.least_stamp_s;
    let end_error = own.hypot(periods * slope_error).hypot(tick_s);
    Some((task.f_hz * task.f_hz * slope_error, end_error, all))
}

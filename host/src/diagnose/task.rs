//! A task that holds captures up, found from the recording: late edges whose stamps have one phase of a rate, and none in the busy time
//! before (A. Schuster, Terrestrial Magnetism 3, 1898).

use std::f64::consts::TAU;

use rayon::prelude::*;
use realfft::num_complex::Complex;
use statrs::distribution::{ContinuousCDF, Normal};

use super::bench::Bench;
use super::disc;
use super::edges::median;
use super::held_up::{self, Task};
use super::lsq;
use super::model::{Board, Fit};
use super::name::NINETY_FIVE;
use super::noise::FAR;
use super::record::Record;
use super::scan::SURE;
use crate::diagnose::diagnosis::{Finding, Parameter, Place};
use crate::mechanism::Mechanism;
use crate::report::si;

/// Late edges that make a rate; so many are looked at at once, and so many such runs.
const LEAST: usize = 10;
/// Points of a periodogram for each 1 / span of it, and at the most.
const FINE: f64 = 4.0;
const POINTS: usize = 200_000;
/// How many times as long as any other one the time without edges has to be.
const EMPTY: f64 = 3.0;

/// Puts the task that holds each recording's edges up into its twin, where there is one that the twin does not declare so; whether any
/// was found.
pub fn find(board: &mut Board, fit: &Fit) -> bool {
    let mut found = false;
    let rests = disc::rests(board, &fit.model);
    let noise = board.noise;
    for (at, rest) in rests.iter().enumerate() {
        let bench = &board.benches[at];
        let declared = Task::of(&bench.twin);
        if bench.twin.capture_latency.is_some() && declared.is_none() {
            continue;
        }
        // As if it were not declared: edges that it did not hold up are none then.
        let plain = declared.and_then(|_| bench.held_up_by(None, &noise));
        let mut rest = rest.clone();
        if let Some(plain) = &plain {
            let each = rest.iter_mut().zip(&plain.residual).zip(&bench.residual);
            each.for_each(|((rest, plain), was)| *rest += plain - was);
        }
        let task = of(plain.as_ref().unwrap_or(bench), &rest, noise.stamp_s);
        let Some(task) = task.filter(|task| declared.is_none_or(|one| !task.is(&one))) else {
            continue;
        };
        let mut other = board.clone();
        let Some(with) = bench.held_up_by(Some(task.task), &noise) else {
            continue;
        };
        other.benches[at] = with;
        let near_s = noise.stamp_s.hypot(bench.record.tick_s);
        let denied = declared.map_or(0.0, |task| against(bench, &task, near_s));
        let (other, _, lost) = other.at_its_noise(&fit.model);
        if lost < board.at_its_noise(&fit.model).2 + denied - SURE {
            *board = other;
            found = true;
        }
    }
    found
}

/// Whether a recording beside its twin alone shows edges that come late together: all of them are needed then.
pub fn shows(bench: &Bench) -> bool {
    of(bench, &bench.residual, bench.noise().stamp_s).is_some()
}

/// Twice the logarithm of a likelihood ratio that stamps within a task's busy times are against it.
fn against(bench: &Bench, task: &Task, near_s: f64) -> f64 {
    let mut record = bench.record.clone();
    held_up::restore(&mut record);
    SURE * task.denied(&record.time_s, near_s) as f64
}

/// A task as far as a recording shows it.
#[derive(Clone, Copy, Debug)]
struct Shown {
    task: Task,
    /// How far its rate, Hz, and the ends of its busy time, s, are off, 95 %.
    rate_hz: f64,
    end_s: f64,
    /// The same of its start.
    start_s: f64,
}

impl Shown {
    /// Whether a declared one is as shown.
    fn is(&self, declared: &Task) -> bool {
        let turns = (declared.phase_s + declared.busy_s - self.task.phase_s - self.task.busy_s)
            * self.task.rate_hz;
        (declared.rate_hz - self.task.rate_hz).abs() <= 2.0 * self.rate_hz
            && (turns - turns.round()).abs() <= self.end_s * self.task.rate_hz
            && (declared.busy_s - self.task.busy_s).abs() <= self.start_s + self.end_s
    }
}

/// The task that residual angles of a recording show.
fn of(bench: &Bench, rest: &[f64], stamp_s: f64) -> Option<Shown> {
    let record = &bench.record;
    // In time, beside both neighbours: what a filter makes of one late edge lasts.
    let beside_s = (1..record.len().saturating_sub(1)).map(|at| {
        let times = &record.time_s;
        let share = (times[at] - times[at - 1]) / (times[at + 1] - times[at - 1]);
        let apart = rest[at] - rest[at - 1] - share * (rest[at + 1] - rest[at - 1]);
        -apart / bench.course.speed[at]
    });
    let beside_s: Vec<f64> = beside_s.collect();
    let middle_s = median(beside_s.iter().map(|late_s| late_s.abs()).collect())?;
    let usual_s = middle_s / Normal::standard().inverse_cdf(0.75);
    let late = beside_s.iter().zip(&record.time_s[1..]);
    let late = late.filter(|(late_s, _)| **late_s > FAR * usual_s);
    let late: Vec<f64> = late.map(|(_, time_s)| *time_s).collect();
    let near_s = stamp_s.max(bench.twin.timer.jitter_s).hypot(record.tick_s);
    let (rate_hz, turns) = ends(&late, rate(&late)?, near_s)?;
    let apart = |time_s: f64| turns_beside(time_s, rate_hz, turns);
    let at_end = |time_s: &f64| apart(*time_s) / rate_hz;
    let is_near = |apart_s: &f64| apart_s.abs() <= FAR * near_s;
    let near: Vec<f64> = late.iter().map(at_end).filter(is_near).collect();
    if near.len() < LEAST || 2 * near.len() < late.len() {
        return None;
    }
    // How long before an end all others are.
    let others = record.time_s.iter().map(at_end);
    let mut before: Vec<f64> = others
        .filter(|apart_s| !is_near(apart_s))
        .map(|apart_s| (-apart_s).rem_euclid(1.0 / rate_hz))
        .collect();
    before.sort_by(f64::total_cmp);
    let empty_s = *before.first()?;
    let widest_s = (before.windows(2).map(|pair| pair[1] - pair[0])).fold(0.0, f64::max);
    if empty_s < EMPTY * widest_s || empty_s < 2.0 * FAR * near_s {
        return None;
    }
    let apart_s = (1.0 / rate_hz - empty_s) / before.len() as f64;
    let busy_s = empty_s - apart_s;
    let end_s = turns / rate_hz;
    let phase_s = (end_s - busy_s).rem_euclid(1.0 / rate_hz);
    let count = near.len() as f64;
    let deviation_s = (near.iter().map(|apart| apart * apart).sum::<f64>() / count).sqrt();
    let task = Task {
        rate_hz,
        busy_s,
        phase_s,
    };
    let deviation_s = deviation_s.max(record.tick_s);
    let span_s = late.last()? - late.first()?;
    Some(shown(record, task, deviation_s, near.len(), span_s))
}

/// Rate, Hz, and turns after the recording's start at which busy times end, by all late edges that come at an end, about a rate; stamps are off
/// by so much. None of edges that have no rhythm.
fn ends(late: &[f64], mut rate_hz: f64, near_s: f64) -> Option<(f64, f64)> {
    let least_hz = 0.5 * rate_hz;
    let mut turns = vector(late, rate_hz).arg() / TAU;
    // Others shift it: from those that are ever closer, down to what stamps are off.
    let mut within = 0.25;
    while within > FAR * near_s * rate_hz {
        let aparts = late.iter();
        let aparts = aparts.map(|time_s| turns_beside(*time_s, rate_hz, turns));
        let near = late.iter().copied().zip(aparts);
        let (times, aparts): (Vec<f64>, Vec<f64>) =
            near.filter(|(_, apart)| apart.abs() < within).unzip();
        let solved = lsq::solve(&[&vec![1.0; times.len()], &times], &aparts);
        turns += solved.sizes[0];
        rate_hz -= solved.sizes[1];
        // Instants of one turn have any rate, and none as well.
        if rate_hz < least_hz {
            return None;
        }
        within *= 0.5;
    }
    Some((rate_hz, turns))
}

/// By how many turns an instant comes after the end of a busy time that is nearest.
fn turns_beside(time_s: f64, rate_hz: f64, turns: f64) -> f64 {
    let apart = time_s * rate_hz - turns;
    apart - apart.round()
}

/// How far so many held edges over a time show a task, if their stamps are off by so much.
fn shown(record: &Record, task: Task, deviation_s: f64, held: usize, span_s: f64) -> Shown {
    let end_s = NINETY_FIVE * deviation_s / (held.max(1) as f64).sqrt();
    let others = record.len().saturating_sub(held).max(1) as f64;
    Shown {
        task,
        // A slope through points that are spread evenly.
        rate_hz: 12_f64.sqrt() * end_s * task.rate_hz / span_s,
        end_s: 2.0 * end_s,
        // Distances of the others' phases are spread exponentially: 19 of 20 within this.
        start_s: 2.0 * end_s + 20_f64.ln() * (1.0 / task.rate_hz - task.busy_s) / others,
    }
}

/// The lowest rate at which instants have one phase, Hz.
fn rate(late: &[f64]) -> Option<f64> {
    let runs = late.chunks_exact(LEAST);
    let each = runs.len().div_ceil(LEAST).max(1);
    let runs: Vec<&[f64]> = runs.step_by(each).collect();
    let span = |run: &[f64]| run[run.len() - 1] - run[0];
    let longest_s = runs.iter().map(|run| span(run)).fold(0.0, f64::max);
    let step = 1.0 / (FINE * longest_s);
    let [lowest_hz, highest_hz] = Mechanism::CaptureLatency.card().range("task_hz");
    let points = ((highest_hz - lowest_hz) / step) as usize;
    if longest_s <= 0.0 || points > POINTS {
        return None;
    }
    let power = |rate_hz: f64| {
        let each = runs.iter().map(|run| vector(run, rate_hz).norm_sqr());
        each.sum::<f64>()
    };
    let all: Vec<f64> = (0..points)
        .into_par_iter()
        .map(|point| power(lowest_hz + step * point as f64))
        .collect();
    let most = all.iter().copied().fold(0.0, f64::max);
    // Its multiples have as much.
    let first = all.iter().position(|power| *power >= 0.5 * most)?;
    let peak = (first..(first + 2 * FINE as usize).min(points))
        .max_by(|a, b| all[*a].total_cmp(&all[*b]))?;
    let mut rate_hz = lowest_hz + step * peak as f64;
    // Over ever longer spans.
    let mut within = step;
    let mut last = 1;
    loop {
        let span_s = FINE / within;
        last = late
            .partition_point(|time_s| time_s - late[0] <= span_s)
            .max(last);
        let coherence = |rate_hz: f64| vector(&late[..last], rate_hz).norm_sqr();
        let points = 4 * FINE as i32;
        let best = (-points..=points)
            .map(|point| rate_hz + within * f64::from(point) / f64::from(points))
            .max_by(|a, b| coherence(*a).total_cmp(&coherence(*b)));
        rate_hz = best?;
        if within * span(late) < 1.0 {
            return Some(rate_hz);
        }
        within *= 0.5;
    }
}

/// Sum of unit vectors at the phases of instants.
fn vector(times_s: &[f64], rate_hz: f64) -> Complex<f64> {
    let phases = times_s.iter().map(|time_s| (time_s * rate_hz).fract());
    phases.map(|turns| Complex::cis(TAU * turns)).sum()
}

/// The finding of a task that the twin of a recording, as it was given, does not declare so.
pub fn finding(given: &Bench, board: &Board, fit: &Fit, at: usize) -> Option<Finding> {
    let now = &board.benches[at];
    let declared = Task::of(&given.twin);
    let task = Task::of(&now.twin).filter(|task| declared != Some(*task))?;
    let mut other = board.clone();
    other.benches[at] = now.held_up_by(declared, &board.noise)?;
    let near_s = board.noise.stamp_s.hypot(now.record.tick_s);
    let denied = declared.map_or(0.0, |task| against(now, &task, near_s));
    let lost = other.lost(&other.fit(&fit.model)) - board.lost(fit) + denied;
    // What was taken for another task may have been what was found since.
    if lost < SURE {
        return None;
    }
    let held = now.record.held.len();
    let shown = shown(&now.record, task, near_s, held, now.record.seconds());
    let numbers = [
        ("task_hz", task.rate_hz, "Hz", shown.rate_hz),
        ("busy_s", task.busy_s, "s", shown.start_s),
        ("phase_s", task.phase_s, "s", shown.start_s),
    ];
    let parameters =
        numbers.map(|(name, value, unit, by)| (name.to_owned(), Parameter::about(value, unit, by)));
    let words = |task: Task, that: &str| {
        let [busy, from] = [task.busy_s, task.phase_s].map(|time_s| si(time_s, "s"));
        let rate = si(task.rate_hz, "Hz");
        format!("a task at {rate}{that} holds captures up for {busy}, from {from} on")
    };
    let is = words(task, "") + &format!(": {held} edges are stamped at its end");
    let text = match declared {
        Some(was) => format!("the twin declares {}; measured: {is}", words(was, " that")),
        None => is,
    };
    Some(Finding {
        parameters: parameters.into(),
        place: Place::of_stamps(),
        ..Finding::of(Mechanism::CaptureLatency, text, lost)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn late_edges_of_one_turn_alone_are_of_no_task() {
        let late: Vec<f64> = (0..9).map(|at| 0.1 + 1e-4 * f64::from(at)).collect();
        for rate_hz in [3.0, 9.286, 40.0] {
            assert_eq!(ends(&late, rate_hz, 1e-9), None);
        }
        let late: Vec<f64> = (0..9).map(|at| 0.013 + 0.1 * f64::from(at)).collect();
        let (rate_hz, turns) = ends(&late, 10.01, 1e-9).unwrap();
        assert!((rate_hz - 10.0).abs() < 1e-9 && (turns - 0.13).abs() < 1e-9);
    }
}

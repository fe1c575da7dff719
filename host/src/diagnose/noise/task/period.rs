//! Rates of a task from single edges that are far too late: their stamps are at the ends of its busy times, a whole number of periods apart.
//!
//! Such stamps are as good as pulses, so they have the same power at the rate and at all its multiples. For each rate that stands out,
//! a straight line through the stamps against the number of the period says rate and end; the rate whose line has most stamps for what
//! chance would put there (the divergence of S. Kullback and R. A. Leibler, Ann. Math. Stat. 22, 1951) comes first.

use super::super::super::spectrum::Spectrum;
use super::busy::Busy;
use super::folded::cell_s;
use super::stamps::Stamps;
use super::{FASTEST_HZ, SLOWEST_HZ};

/// Deviations from which on an edge is far too late, how many are looked at, and how many it takes.
const LATE: f64 = 4.5;
const MOST: usize = 3_000;
const LEAST: usize = 8;
/// Power that a rate must have, and its share of the greatest.
const POWER: f64 = 6.0;
const SHARE: f64 = 0.4;
/// Rates that a line is fitted to, slowest and strongest ones, and those that are handed on.
const RATES: usize = 60;
const HANDED_ON: usize = 4;
/// RMS errors of a stamp within which it is on the line.
const ON_LINE: f64 = 4.0;
/// Times that a line is fitted.
const ROUNDS: usize = 12;

/// A line through stamps.
struct Line {
    f_hz: f64,
    end_s: f64,
    /// How far it is from chance.
    score: f64,
}

/// Tasks by the stamps that are too late, best first.
#[must_use]
pub fn by_stamps(rows: &[Stamps<'_>]) -> Vec<Busy> {
    let late: Vec<Vec<f64>> = rows.iter().map(late).collect();
    let Some(most) = (0..rows.len()).max_by_key(|row| late[*row].len()) else {
        return Vec::new();
    };
    let times_s = &late[most];
    if times_s.len() < LEAST {
        return Vec::new();
    }
    let mut lines: Vec<Line> = rates(&rows[most], times_s)
        .into_iter()
        .filter_map(|f_hz| line(times_s, f_hz, &rows[most]))
        .collect();
    lines.sort_by(|a, b| b.score.total_cmp(&a.score));
    lines.dedup_by(|a, b| (a.f_hz / b.f_hz - 1.0).abs() < 1e-7);
    lines.truncate(HANDED_ON);
    let tasks = lines.into_iter().map(|line| {
        let ends = rows.iter().zip(&late).enumerate();
        let ends_s = ends
            .map(|(row, (stamps, late))| match row == most {
                true => line.end_s,
                false => fullest(late, line.f_hz, ON_LINE * stamps.jitter_s),
            })
            .collect();
        let busy_s = longest(&rows[most], &on_line(times_s, &line, &rows[most]));
        Busy {
            f_hz: line.f_hz,
            busy_s,
            ends_s,
        }
        .centred(rows)
    });
    tasks.collect()
}

/// Stamps of the edges that are far too late, by time.
pub(super) fn late(row: &Stamps<'_>) -> Vec<f64> {
    let deviations = (0..row.len()).map(|at| (at, row.deviation(at)));
    let mut late: Vec<(usize, f64)> = deviations.filter(|one| one.1 > LATE).collect();
    late.sort_by(|a, b| b.1.total_cmp(&a.1));
    late.truncate(MOST);
    late.sort_unstable_by_key(|one| one.0);
    late.iter()
        .map(|one| row.bench.seen.times_s[one.0])
        .collect()
}

/// The task of about a rate by the stamps of a recording that are too late.
pub(super) fn by_pulses(row: &Stamps<'_>, times_s: &[f64], f_hz: f64) -> Option<Busy> {
    if times_s.len() < LEAST {
        return None;
    }
    let line = line(times_s, f_hz, row)?;
    let busy_s = longest(row, &on_line(times_s, &line, row));
    let task = Busy {
        f_hz: line.f_hz,
        busy_s,
        ends_s: vec![line.end_s],
    };
    Some(task.centred(std::slice::from_ref(row)))
}

/// Stamps that are on a line.
fn on_line(times_s: &[f64], line: &Line, row: &Stamps<'_>) -> Vec<f64> {
    let on = |time: &&f64| off(**time, line.f_hz, line.end_s).abs() < ON_LINE * row.jitter_s;
    times_s.iter().filter(on).copied().collect()
}

/// Spectrum of stamps, each a pulse.
pub(super) fn pulses(row: &Stamps<'_>, times_s: &[f64]) -> Spectrum {
    let first = times_s.first().copied().unwrap_or(0.0);
    let length = row.bench.seen.seconds().max(f64::MIN_POSITIVE);
    let cell = cell_s(length);
    let pulses = times_s.iter().map(|time| (time - first, 1.0));
    Spectrum::of(pulses, length, cell, FASTEST_HZ.min(1.0 / (3.0 * cell)))
}

/// Rates that stand out, Hz.
fn rates(row: &Stamps<'_>, times_s: &[f64]) -> Vec<f64> {
    let spectrum = pulses(row, times_s);
    let from = (SLOWEST_HZ / spectrum.step) as usize;
    let top = spectrum
        .powers
        .iter()
        .skip(from)
        .copied()
        .fold(0.0, f64::max);
    let mut peaks = spectrum.peaks(POWER.max(SHARE * top), usize::MAX);
    peaks.retain(|peak| peak.0 >= SLOWEST_HZ);
    let strongest: Vec<f64> = peaks.iter().take(RATES).map(|peak| peak.0).collect();
    peaks.sort_by(|a, b| a.0.total_cmp(&b.0));
    let slowest = peaks.iter().take(RATES).map(|peak| peak.0);
    slowest.chain(strongest).collect()
}

/// How far a time is from the nearest end.
fn off(time_s: f64, f_hz: f64, end_s: f64) -> f64 {
    let periods = (time_s - end_s) * f_hz;
    (periods - periods.round()) / f_hz
}

/// The line through most stamps, from about a rate on.
fn line(times_s: &[f64], f_hz: f64, row: &Stamps<'_>) -> Option<Line> {
    let middle = row.middle_s();
    let (mut f_hz, mut end_s) = (f_hz, middle);
    // Where they are on the whole.
    let (sin, cos) = times_s.iter().fold((0.0, 0.0), |(sin, cos), time| {
        let (s, c) = (std::f64::consts::TAU * (time - middle) * f_hz).sin_cos();
        (sin + s, cos + c)
    });
    end_s += sin.atan2(cos) / (std::f64::consts::TAU * f_hz);
    let least = ON_LINE * row.jitter_s;
    let mut within = 0.3 / f_hz;
    for _ in 0..ROUNDS {
        let on: Vec<(f64, f64)> = times_s
            .iter()
            .map(|time| (((time - end_s) * f_hz).round(), off(*time, f_hz, end_s)))
            .filter(|(_, off)| off.abs() < within)
            .collect();
        let (shift, slope) = straight(&on)?;
        end_s += shift;
        f_hz = 1.0 / (1.0 / f_hz + slope);
        let mut sizes: Vec<f64> = on
            .iter()
            .map(|(period, off)| (off - shift - slope * period).abs())
            .collect();
        let half = sizes.len() / 2;
        let (_, usual, _) = sizes.select_nth_unstable_by(half, f64::total_cmp);
        within = (5.0 * *usual).min(within).max(least);
    }
    let count = times_s.len() as f64;
    let on = times_s
        .iter()
        .filter(|time| off(**time, f_hz, end_s).abs() < least)
        .count() as f64;
    let (share, chance) = (on / count, (2.0 * least * f_hz).min(1.0));
    let rest = if share < 1.0 {
        (1.0 - share) * ((1.0 - share) / (1.0 - chance)).ln()
    } else {
        0.0
    };
    let there = on >= LEAST as f64 && share > chance && f_hz > 0.0;
    there.then(|| Line {
        f_hz,
        end_s,
        score: count * (share * (share / chance).ln() + rest),
    })
}

/// Shift and slope of the straight line through points.
fn straight(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    if points.len() < 3 {
        return None;
    }
    let count = points.len() as f64;
    let (x, y) = points
        .iter()
        .fold((0.0, 0.0), |(x, y), point| (x + point.0, y + point.1));
    let (x, y) = (x / count, y / count);
    let wide: f64 = points.iter().map(|point| (point.0 - x).powi(2)).sum();
    let along: f64 = points
        .iter()
        .map(|point| (point.0 - x) * (point.1 - y))
        .sum();
    let slope = if wide > 0.0 { along / wide } else { 0.0 };
    Some((y - slope * x, slope))
}

/// The end about which most stamps are, of a known rate.
fn fullest(times_s: &[f64], f_hz: f64, within_s: f64) -> f64 {
    let mut phases: Vec<f64> = times_s
        .iter()
        .map(|time| (time * f_hz).rem_euclid(1.0))
        .collect();
    phases.sort_by(f64::total_cmp);
    let wide = 2.0 * within_s * f_hz;
    let wrapped: Vec<f64> = phases
        .iter()
        .copied()
        .chain(phases.iter().map(|phase| phase + 1.0))
        .collect();
    let (mut best, mut to) = ((0, 0.0), 0);
    for (from, phase) in phases.iter().enumerate() {
        while to < wrapped.len() && wrapped[to] <= phase + wide {
            to += 1;
        }
        if to - from > best.0 {
            let there = &wrapped[from..to];
            best = (to - from, there.iter().sum::<f64>() / there.len() as f64);
        }
    }
    best.1 / f_hz
}

/// The latest of the edges with these stamps, s: about the busy time.
fn longest(row: &Stamps<'_>, times_s: &[f64]) -> f64 {
    let stamps = &row.bench.seen.times_s;
    let late = times_s.iter().filter_map(|time| {
        let at = stamps.partition_point(|stamp| stamp < time);
        row.late_s.get(at).copied()
    });
    late.fold(row.jitter_s, f64::max)
}

//! How far edges stand away from the twin's course, as people read it: RMS angles, apart from what is slow and of what is slow.
//!
//! The residual of each edge less the mean of all edges within a turn of way to either side is what is faster than about two turns:
//! an error that comes again each turn keeps its whole size in it, offset and speed are gone, and so is the slow wander of the shaft.
//! Those means, less a straight line in time and what is left of the speed at the start, are what is slow. Edges against each other show under neither where the shaft wanders
//! more: for them there is how far each comes from where those before it let it expect. The floor is what noise alone makes of each.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::bench::Bench;
use super::board::{Board, PARTS};
use super::seen::Seen;
use super::shaft::Leap;

/// Runs of the noise that the floor is the mean of.
const RUNS: u64 = 4;
/// Turns from which on the mean is over two of them; over one in shorter recordings.
const LONG_TURNS: f64 = 6.0;
/// Part of what fades from the start that is no straight line, from which on it is told from one.
const LINE: f64 = 1e-3;
/// Times in which a speed fades to the e-th part after which nothing is left of it.
const FADES: f64 = 5.0;

/// Sums of squares over edges.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spread {
    fast: f64,
    slow: f64,
    count: f64,
    steps: f64,
    step_count: f64,
}

impl Spread {
    /// RMS of what is faster than two turns, rad.
    #[must_use]
    pub fn fast_rad(self) -> f64 {
        (self.fast / self.count.max(1.0)).sqrt()
    }

    /// RMS of what is slower, rad.
    #[must_use]
    pub fn slow_rad(self) -> f64 {
        (self.slow / self.count.max(1.0)).sqrt()
    }

    /// RMS of how far each edge comes from where those before it let it expect, rad.
    #[must_use]
    pub fn steps_rad(self) -> f64 {
        (self.steps / self.step_count.max(1.0)).sqrt()
    }

    /// All of them: turn by turn, slow, edge by edge.
    #[must_use]
    pub fn all_rad(self) -> [f64; 3] {
        [self.fast_rad(), self.slow_rad(), self.steps_rad()]
    }

    fn add(&mut self, other: Self) {
        self.fast += other.fast;
        self.slow += other.slow;
        self.count += other.count;
        self.steps += other.steps;
        self.step_count += other.step_count;
    }
}

/// Spread of what is left, white, over some parts of each recording.
#[must_use]
pub fn spread(board: &Board, left: &[Vec<f64>], parts: std::ops::Range<usize>) -> Spread {
    let mut sum = Spread::default();
    for (bench, left) in board.benches.iter().zip(left) {
        let mut angles = left.clone();
        bench.whitener().restore(&mut angles);
        sum.add(of_bench(bench, left, &angles, &parts));
    }
    sum
}

/// Spread of the noise alone.
#[must_use]
pub fn floor(board: &Board, parts: std::ops::Range<usize>) -> Spread {
    let benches = board.benches.iter().enumerate();
    let runs: Vec<(usize, &Bench, u64)> = benches
        .flat_map(|(number, bench)| (0..RUNS).map(move |run| (number, bench, run)))
        .collect();
    let each = runs.into_par_iter().map(|(number, bench, run)| {
        let mut random = ChaCha8Rng::seed_from_u64(run);
        random.set_stream(number as u64);
        let angles = noise(bench, &mut random);
        let white = bench.whitened(angles.clone());
        of_bench(bench, &white, &angles, &parts)
    });
    let mut sum = Spread::default();
    each.collect::<Vec<Spread>>()
        .into_iter()
        .for_each(|one| sum.add(one));
    sum
}

/// A run of a recording's noise: the shaft's wander as the filter has it (see [`super::kalman`]), and errors of stamps.
fn noise(bench: &Bench, random: &mut ChaCha8Rng) -> Vec<f64> {
    let noise = bench.noise;
    if bench.law.spring.is_some() {
        let mut angles: Vec<f64> = (0..bench.seen.len()).map(|_| normal(random)).collect();
        bench.whitener().restore(&mut angles);
        return angles;
    }
    let (mut angle, mut drift) = (0.0, 0.0);
    let mut speed: Option<f64> = None;
    let each = bench.seen.readings.iter().enumerate().map(|(at, reading)| {
        if bench.seen.follows(at) {
            // The course goes along with what a push makes of the shaft.
            (angle, speed) = (0.0, Some(0.0));
            return reading.speed * noise.stamp_s * normal(random);
        }
        let leap = Leap {
            damping: reading.leap.damping + noise.forgets_per_s,
            ..reading.leap
        };
        let h = leap.after_s;
        // As fast or slow as the noise has made it until here; where nothing holds it, that is part of its mean speed.
        let before = speed.unwrap_or_else(|| {
            let usual = noise.acceleration / (2.0 * leap.damping);
            if leap.damping > 0.0 {
                usual.sqrt() * normal(random)
            } else {
                0.0
            }
        });
        let (reach, stays) = leap.reach(h);
        let (one, two) = (normal(random), normal(random));
        let kick = (noise.acceleration * h).sqrt();
        angle += reach * before + h * drift + kick * h * (0.5 * one + two / 12_f64.sqrt());
        speed = Some(stays * before + kick * one);
        drift += (noise.drift * h).sqrt() * normal(random);
        angle + reading.speed * noise.stamp_s * normal(random)
    });
    each.collect()
}

/// Standard normal, by Box and Muller.
fn normal(random: &mut ChaCha8Rng) -> f64 {
    let (one, two): (f64, f64) = (random.random(), random.random());
    // 1 - u is never 0, so the logarithm is finite.
    (-2.0 * (1.0 - one).ln()).sqrt() * (TAU * two).cos()
}

fn of_bench(
    bench: &Bench,
    white: &[f64],
    angles: &[f64],
    parts: &std::ops::Range<usize>,
) -> Spread {
    let range = bench.part(parts.start).start..bench.part((parts.end - 1).min(PARTS - 1)).end;
    let mut sum = Spread::default();
    let pairs = white.iter().zip(bench.deviations());
    for (at, (white, deviation)) in pairs.enumerate().skip(range.start).take(range.len()) {
        if let Some(deviation) = deviation.filter(|_| !bench.seen.follows(at)) {
            sum.steps += (white * deviation).powi(2);
            sum.step_count += 1.0;
        }
    }
    let angles = steady(bench, angles);
    let means = means(&bench.seen, &angles);
    let there: Vec<(f64, f64, f64)> = range
        .filter(|at| !bench.seen.follows(*at))
        .filter_map(|at| means[at].map(|mean| (bench.seen.times_s[at], mean, angles[at] - mean)))
        .collect();
    Spread {
        fast: there.iter().map(|one| one.2 * one.2).sum(),
        slow: off_line(&there).iter().map(|off| off * off).sum(),
        count: there.len() as f64,
        ..sum
    }
}

/// Angles less what the speed at the start, which is anyone's guess, made of them: it fades as the shaft's law has it.
fn steady(bench: &Bench, angles: &[f64]) -> Vec<f64> {
    let readings = &bench.seen.readings;
    if readings
        .iter()
        .skip(1)
        .any(|reading| reading.fresh || reading.anew)
    {
        return angles.to_vec();
    }
    let (mut way, mut speed) = (0.0, 1.0);
    let fading = readings.iter().map(|reading| {
        let (reach, stays) = reading.leap.reach(reading.leap.after_s);
        way += reach * speed;
        speed *= stays;
        way
    });
    let fading: Vec<f64> = fading.collect();
    // What happens later is none of it.
    let times = &bench.seen.times_s;
    let damping = readings.last().map_or(0.0, |last| last.leap.damping);
    let until_s = times.first().map_or(0.0, |first| first + FADES / damping);
    let early = times.partition_point(|time| *time < until_s);
    let rows = |values: &[f64]| -> Vec<(f64, f64, f64)> {
        let each = times.iter().zip(values).take(early);
        each.map(|(time, value)| (*time, *value, 0.0)).collect()
    };
    // What a line does as well is taken off already.
    let apart = off_line(&rows(&fading));
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let own = product(&apart, &apart);
    let all = product(&fading[..early], &fading[..early]);
    if own <= LINE * all || all == 0.0 {
        return angles.to_vec();
    }
    let size = product(&apart, &off_line(&rows(angles))) / own;
    let each = angles.iter().zip(&fading);
    each.map(|(angle, way)| angle - size * way).collect()
}

/// Mean of all edges within a turn of way, or half of one, to either side; none where there is not so much.
fn means(seen: &Seen, angles: &[f64]) -> Vec<Option<f64>> {
    let mut means = vec![None; angles.len()];
    let mut start = 0;
    for end in 1..=angles.len() {
        if end == angles.len() || seen.readings[end].fresh {
            unbroken(seen, angles, start..end, &mut means);
            start = end;
        }
    }
    means
}

/// The same for edges whose count goes on from one to the next.
fn unbroken(seen: &Seen, angles: &[f64], range: std::ops::Range<usize>, means: &mut [Option<f64>]) {
    // Way and sums up to each edge, the edge included; sums start anew at the first angle, which may be far from zero.
    let (mut way, mut sum) = (0_i64, 0.0);
    let first = angles[range.start];
    let mut ways = Vec::with_capacity(range.len());
    let mut sums = Vec::with_capacity(range.len() + 1);
    sums.push(0.0);
    for at in range.clone() {
        if at > range.start {
            way += (seen.places[at] - seen.places[at - 1]).abs();
        }
        sum += angles[at] - first;
        ways.push(way);
        sums.push(sum);
    }
    let half = if way as f64 >= LONG_TURNS * seen.edges as f64 {
        seen.edges
    } else {
        (seen.edges / 2).max(1)
    };
    let (mut low, mut high) = (0, 0);
    for (at, here) in ways.iter().enumerate() {
        if here - half < 0 || here + half > way {
            continue;
        }
        while ways[low] < here - half {
            low += 1;
        }
        while high + 1 < ways.len() && ways[high + 1] <= here + half {
            high += 1;
        }
        // The edges at both ends are one of the turn together.
        let mut weight = (high + 1 - low) as f64;
        let mut total = sums[high + 1] - sums[low];
        for (edge, far) in [(low, here - half), (high, here + half)] {
            if ways[edge] == far {
                weight -= 0.5;
                total -= 0.5 * (angles[range.start + edge] - first);
            }
        }
        means[range.start + at] = Some(first + total / weight);
    }
}

/// Values of rows of time and value, less the straight line through them.
fn off_line(rows: &[(f64, f64, f64)]) -> Vec<f64> {
    let count = rows.len() as f64;
    let mean =
        |value: &dyn Fn(&(f64, f64, f64)) -> f64| rows.iter().map(value).sum::<f64>() / count;
    let (time, value) = (mean(&|row| row.0), mean(&|row| row.1));
    let (mut across, mut own) = (0.0, 0.0);
    for row in rows {
        across += (row.0 - time) * (row.1 - value);
        own += (row.0 - time).powi(2);
    }
    let slope = if own > 0.0 { across / own } else { 0.0 };
    let each = rows.iter();
    each.map(|row| row.1 - value - slope * (row.0 - time))
        .collect()
}

#[cfg(test)]
mod tests;

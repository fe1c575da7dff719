//! A speed loop that nobody declared, found by what it saw: it pushes by the error of whichever interval came just before each of its
//! samples, so that only samples at its own instants foretell what pushed the shaft.

use std::ops::Range;

use rayon::prelude::*;
use statrs::statistics::Statistics;

use super::{Tie, Unsaid};
use crate::diagnose::bench::{self, Bench};
use crate::diagnose::cells::Bank;
use crate::diagnose::disc;
use crate::diagnose::lsq;
use crate::diagnose::model::{Board, Fit};
use crate::diagnose::plant::Hold;
use crate::diagnose::scan::{SURE, spectrum};
use crate::diagnose::search;
use crate::twin::{Drive, Gains, SpeedLoop};

/// Edges of each recording that are looked at first. Four times as many follow each time.
const FIRST: usize = 1_000;
const MORE: usize = 4;
/// Part of an interval by which the instants of two rates that are tried differ at the end of a stretch.
const APART: f64 = 0.5;
/// Rates to either side that none of the edges shows, and how far they are from each other as parts of the one that they show.
const OTHERS: i32 = 40;
const OTHER: f64 = 3.7e-3;
/// Slowest and fastest rate that is looked for, of edges.
const RATES: Range<f64> = 0.02..20.0;
/// Rates that are looked at closer at first; of more edges half as many each time.
const KEPT: usize = 64;
/// A rate that samples the right instants among others shows as well: ratios to the right one are of numbers up to this, and so many of
/// the first edges tell them apart.
const RELATED: u32 = 32;
const COMPARED: usize = FIRST * MORE * MORE;
/// Rounds in which the best one is looked for closer, and steps to either side in each.
const ROUNDS: usize = 4;
const STEPS: i32 = 32;
/// Rounds in which gains and the samples that came close to an edge are found, as each bears on the other.
const FITTED: usize = 3;
/// Intervals of the mean speed without an edge after which a loop sees a standstill.
const TIMEOUT: f64 = 20.0;

/// Effects that may do as much as a loop.
const FEW: usize = 2;
/// Frequencies at which a few missing effects may do most, and how many steps of the spectrum each is wide to either side.
const LINES: usize = 8;
const WIDE: usize = 2;

/// Puts the speed loop that drives the shaft of undeclared drives into what was found of each recording, where the edges show one. How the
/// drive holds the shaft otherwise goes by `some` edges of the recordings, which tell that as well.
pub fn find(benches: &mut [Bench], some: Vec<Bench>) {
    let undriven = benches
        .iter()
        .all(|bench| bench.twin.drive == Drive::Unknown);
    if !undriven {
        return;
    }
    let mut board = Board::new(some);
    if board.edges() < benches.iter().map(|bench| bench.record.len()).sum() {
        let all = benches.iter().map(|bench| bench.record.clone());
        let Some(more) = board.along(all.collect(), &search::nuisances(&board)) else {
            return;
        };
        board = more;
    }
    let (board, fit, before) = board.at_its_noise(&search::nuisances(&board));
    // As many rates are tried as differ by a part of an interval.
    let tried = (RATES.end / RATES.start).ln() * board.edges() as f64 / APART;
    let sure = SURE + 2.0 * tried.ln();
    let seen_first = seen(&board, &fit);
    let Some(rate_hz) = rate(&seen_first).filter(|rate| apart(&seen_first, *rate) > sure) else {
        return;
    };
    let looped = board.looped(rate_hz).and_then(|looped| {
        // In noise without what the loop does its samples are told more exactly.
        let mut quiet = board.clone();
        quiet.set_noise(looped.noise);
        looped.looped(nearby(&seen(&quiet, &quiet.fit(&fit.model)), rate_hz))
    });
    let Some(looped) = looped else {
        return;
    };
    let holds = looped.benches.iter().all(|bench| {
        let own = bench.found.speed_loop.as_ref();
        own.is_some_and(|own| own.own.gains.kp > 0.0)
    });
    let (_, _, after) = looped.at_its_noise(&search::nuisances(&looped));
    let fall = before - after;
    // A tone or two do as much as a loop that samples twice in each of their periods.
    let few = || search::together(&board, &Bank::new(&board), &fit, FEW, fall);
    if holds && fall > sure && broad(&board, &looped) > sure && few() < fall {
        for (bench, with) in benches.iter_mut().zip(looped.benches) {
            bench.found = with.found;
        }
    }
}

/// Square of how far what a rate explains stands out from what others near it do, in their standard deviations: where a loop at any other
/// instants explains as much, it is friction.
fn apart(seen: &[Seen], rate_hz: f64) -> f64 {
    let most = most(seen);
    let steps = (-OTHERS..=OTHERS).filter(|step| *step != 0);
    let others = steps.map(|step| rate_hz * (1.0 + f64::from(step) * OTHER));
    let others: Vec<f64> = others.collect();
    let each = others.par_iter();
    let each: Vec<f64> = each.map(|rate| sigmas(seen, *rate, most)).collect();
    let (mean, spread) = (each.iter().mean(), each.iter().population_std_dev());
    ((sigmas(seen, rate_hz, most) - mean).max(0.0) / spread).powi(2)
}

/// By how much a loop makes a board likelier but for the frequencies at which it does most: samples at some rate turn errors of the disc
/// into any tone, but only a loop's own instants do so for all of them.
fn broad(without: &Board, with: &Board) -> f64 {
    let mut without = without.clone();
    without.set_noise(with.noise);
    let powers = |board: &Board| {
        let left = board.fit(&search::nuisances(board)).left;
        let each = bench::parts(&board.benches, &left);
        each.map(|(_, own)| powers(own)).collect::<Vec<_>>()
    };
    let (before, after) = (powers(&without), powers(with));
    let each = before.iter().zip(&after).map(|(before, after)| {
        let gains = before
            .iter()
            .zip(after)
            .map(|(before, after)| before - after);
        let mut gains: Vec<f64> = gains.collect();
        for _ in 0..LINES {
            let most = (0..gains.len()).max_by(|a, b| gains[*a].total_cmp(&gains[*b]));
            let most = most.unwrap_or(0);
            let line = most.saturating_sub(WIDE)..(most + WIDE + 1).min(gains.len());
            gains[line].fill(0.0);
        }
        gains.iter().sum::<f64>()
    });
    each.sum()
}

/// Powers of a row at its frequencies; their sum is that of its squares.
fn powers(row: &[f64]) -> Vec<f64> {
    let each = spectrum(row.to_vec()).into_iter();
    each.map(|value| 2.0 * value.norm_sqr() / row.len() as f64)
        .collect()
}

impl Board {
    /// The board with a loop that samples at a rate, with the gains that fit best beside what the twins leave open.
    fn looped(&self, rate_hz: f64) -> Option<Self> {
        let mut board = self.clone();
        let plain = |bench: &mut Bench| {
            let gains = bench.found.speed_loop.as_ref();
            let gains = gains.map_or(Gains { kp: 0.0, ki: 0.0 }, |before| before.own.gains);
            let own = at(rate_hz, gains, bench);
            bench.found.hold = Hold::default();
            bench.found.speed_loop = Some(Unsaid::of(own, &bench.record, &bench.twin));
        };
        for _ in 0..FITTED {
            board.benches.iter_mut().for_each(plain);
            board = board.found_anew()?;
            let model = &search::nuisances(&board);
            for _ in 0..FITTED {
                if !board.regain(model) {
                    break;
                }
                board = board.at_its_noise(model).0;
            }
            let rests = disc::rests(&board, &board.fit(model).model);
            for (bench, rest) in board.benches.iter_mut().zip(&rests) {
                let Some(own) = &bench.found.speed_loop else {
                    continue;
                };
                let others = bench.other_ties(&own.own, rest).into_iter();
                let others: Vec<Tie> = others.map(|(tie, ..)| tie).collect();
                bench.found.speed_loop = Some(own.tied(&others));
            }
            board = board.found_anew()?.at_its_noise(model).0;
        }
        Some(board)
    }
}

/// A loop that samples a recording at a rate.
fn at(rate_hz: f64, gains: Gains, bench: &Bench) -> SpeedLoop {
    let record = &bench.record;
    let (from, until) = (record.time_s[0], record.time_s[record.len() - 1]);
    let way = record.grid_rad(record.len() - 1) - record.grid_rad(0);
    let mean = way / (until - from);
    SpeedLoop {
        target_rad_s: mean,
        rate_hz,
        gains,
        limit: f64::INFINITY,
        timeout_s: TIMEOUT * record.step_rad() / mean.abs(),
        start: 0.0,
    }
}

/// What a loop sees of a recording, and what its pushes would explain.
struct Seen {
    time_s: Vec<f64>,
    /// Speed of the interval that ends at each edge, less the shaft's, rad/s.
    off: Vec<f64>,
    /// By how much a unit push up to each edge raises the likelihood.
    pushed: Vec<f64>,
}

impl Seen {
    fn of(bench: &Bench, left: &[f64]) -> Self {
        let record = &bench.record;
        let course = &bench.course;
        let score = bench.score(left);
        let each = bench.plant.sensitivity(course, &score);
        let pushed = each.iter().scan(0.0, |sum, each| {
            *sum += each;
            Some(*sum)
        });
        let off = (0..record.len()).map(|at| {
            let before = at.checked_sub(1)?;
            let h = record.time_s[at] - record.time_s[before];
            let way = record.grid_rad(at) - record.grid_rad(before);
            let same = record.way[at] == record.way[before];
            (same && h > 0.0).then(|| way / h - course.steady[at])
        });
        Self {
            time_s: record.time_s.clone(),
            off: off.map(Option::unwrap_or_default).collect(),
            pushed: pushed.collect(),
        }
    }

    /// Sum of what a loop that samples at a rate would explain by the first edges, and of its squares.
    fn explained(&self, rate_hz: f64, edges: usize) -> (f64, f64) {
        let edges = edges.min(self.time_s.len());
        let (mut sum, mut squares) = (0.0, 0.0);
        let mut at = 0;
        let mut last: Option<(f64, f64)> = None;
        let mut sample = (self.time_s[0] * rate_hz).ceil().max(0.0);
        loop {
            let now_s = sample / rate_hz;
            while at + 1 < edges && self.time_s[at + 1] <= now_s {
                at += 1;
            }
            if at + 1 >= edges {
                break;
            }
            let (from_s, until_s) = (self.time_s[at], self.time_s[at + 1]);
            let slope = (self.pushed[at + 1] - self.pushed[at]) / (until_s - from_s);
            let here = self.pushed[at] + (now_s - from_s) * slope;
            if let Some((before, push)) = last {
                let own = push * (here - before);
                sum += own;
                squares += own * own;
            }
            // Those that follow before the next edge see the same, and push alike.
            let more = ((until_s * rate_hz).ceil() - sample - 1.0).max(0.0);
            let (push, each) = (-self.off[at], slope / rate_hz);
            let own = push * each;
            sum += more * own;
            squares += more * own * own;
            last = Some((here + more * each, push));
            sample += 1.0 + more;
        }
        (sum, squares)
    }
}

/// By how many standard deviations a loop of a rate explains some edges of each recording.
fn sigmas(seen: &[Seen], rate_hz: f64, edges: usize) -> f64 {
    let (sum, squares) = sums(seen, rate_hz, edges);
    sum / squares.sqrt().max(f64::MIN_POSITIVE)
}

/// [`Seen::explained`] of all recordings.
fn sums(seen: &[Seen], rate_hz: f64, edges: usize) -> (f64, f64) {
    let each = seen.iter().map(|seen| seen.explained(rate_hz, edges));
    each.fold((0.0, 0.0), |all, one| (all.0 + one.0, all.1 + one.1))
}

/// What a loop sees of each recording of a board, and what it would explain of what a fit leaves.
fn seen(board: &Board, fit: &Fit) -> Vec<Seen> {
    let each = bench::parts(&board.benches, &fit.left);
    each.map(|(bench, own)| Seen::of(bench, own)).collect()
}

/// The rate next to one that explains most.
fn nearby(seen: &[Seen], mut rate: f64) -> f64 {
    let mut step = APART / most(seen) as f64;
    for _ in 0..ROUNDS {
        let steps = -STEPS..=STEPS;
        let near = steps.map(|by| rate * (1.0 + f64::from(by) * step / f64::from(STEPS)));
        rate = explains_most(seen, near.collect(), usize::MAX).unwrap_or(rate);
        step *= 4.0 / f64::from(STEPS);
    }
    rate
}

/// The one of some rates that explains most of the first edges.
fn explains_most(seen: &[Seen], rates: Vec<f64>, edges: usize) -> Option<f64> {
    let each = rates.into_par_iter();
    let each = each.map(|rate| (sums(seen, rate, edges).0, rate));
    let each: Vec<(f64, f64)> = each.collect();
    let best = each.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, rate)| rate)
}

/// Edges of the longest recording.
fn most(seen: &[Seen]) -> usize {
    let each = seen.iter().map(|seen| seen.time_s.len());
    each.max().unwrap_or(0)
}

/// The rate that explains most.
fn rate(seen: &[Seen]) -> Option<f64> {
    let most = most(seen);
    // Edges a second.
    let per_s = seen.iter().map(|Seen { time_s, .. }| {
        let last = time_s.len() - 1;
        last as f64 / (time_s[last] - time_s[0])
    });
    let (slow, fast) = lsq::ends(per_s);
    let range_hz = slow * RATES.start..fast * RATES.end;
    let span = range_hz.end / range_hz.start;
    let mut edges = FIRST.min(most);
    let mut apart = APART / edges as f64;
    let count = (span.ln() / apart) as usize;
    let rates = (0..count).map(|at| range_hz.start * (at as f64 * apart).exp());
    let mut rates: Vec<f64> = rates.collect();
    let mut kept = KEPT;
    let best = loop {
        let each = rates.par_iter();
        let each = each.map(|rate| (sigmas(seen, *rate, edges), *rate));
        let mut each: Vec<(f64, f64)> = each.collect();
        each.sort_by(|a, b| b.0.total_cmp(&a.0));
        each.truncate(kept);
        kept = (kept / 2).max(1);
        if edges == most {
            break each.first()?.1;
        }
        apart /= MORE as f64;
        edges = (edges * MORE).min(most);
        let around = each.iter().flat_map(|(_, rate)| {
            let steps = -(MORE as i64)..=MORE as i64;
            steps.map(move |step| rate * (1.0 + step as f64 * apart))
        });
        rates = around.collect();
    };
    let best = nearby(seen, best);
    let related = (1..=RELATED).flat_map(|up| (1..=RELATED).map(move |down| (up, down)));
    let lowest = related.filter(|(up, down)| (2..=*up).all(|by| up % by + down % by > 0));
    let related = lowest.map(|(up, down)| best * f64::from(up) / f64::from(down));
    let related = related.filter(|rate| range_hz.contains(rate));
    let rate = explains_most(seen, related.collect(), COMPARED)?;
    Some(nearby(seen, rate))
}

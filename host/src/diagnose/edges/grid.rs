//! The edges that a turn really has, as a row of ranks on the grid, what an observation may say of them, and how fast they go by.

use std::collections::VecDeque;
use std::f64::consts::{PI, TAU};

use super::median;

/// Turns in which an edge has to be seen for its place, and for what the speed does there, to be known.
pub(super) const TURNS: usize = 3;
/// Share of intervals that no smooth speed explains.
const OUTLIERS: f64 = 1e-3;
/// Standard deviation of a log interval about its prediction at the least: clocks and discs are no better.
const SPREAD_LEAST: f64 = 0.004;
/// Rounds of classes over which an acceleration is looked at.
const ROUNDS: usize = 2;
/// Gains of the speed and its slope, and of the spread's mean, as parts of an innovation.
const GAINS: [f64; 3] = [0.6, 0.15, 0.08];

/// One pulse or change of state, as the search sees it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight {
    /// Time, ticks.
    pub ticks: u64,
    /// Class of the sector that the levels show, 0 where they say nothing; none where no sector shows them.
    pub class: Option<u8>,
}

/// Which sectors a turn has. A rank counts the edges that are there, through all turns; the sector of a rank lies behind its edge.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// Grid edges a turn.
    edges: i64,
    /// Classes that levels tell apart.
    classes: i64,
    /// Edges that are there, in order; empty where all are.
    present: Vec<i64>,
    /// Where the edges stand by the recording itself, in grid edges, with the whole turn behind them; empty where that is not known.
    measured: Vec<f64>,
    /// Whether the levels tell the direction.
    pub reversible: bool,
    /// Acceleration that the shaft is known to reach, grid edges a tick squared; 0 where none is.
    pub reached: f64,
}

impl Grid {
    /// A grid of `edges` that are all there, whose sectors show `classes` patterns of levels in turn.
    pub fn full(edges: u32, classes: u8) -> Self {
        Self {
            edges: edges.into(),
            classes: classes.into(),
            present: Vec::new(),
            measured: Vec::new(),
            reversible: classes > 2,
            reached: 0.0,
        }
    }

    /// The same grid with the largest acceleration that changes of levels show: over whole rounds of classes, so that their own errors do
    /// not count, and twice in a row the same way, as rows that are no edges do not show it.
    pub fn moved(self, ticks: &[u64]) -> Self {
        let round = ROUNDS * self.classes as usize;
        let ends: Vec<f64> = ticks.iter().step_by(round).map(|at| *at as f64).collect();
        let speeds = ends.windows(2).map(|two| {
            let lasts = (two[1] - two[0]).max(1.0);
            (round as f64 / lasts, lasts)
        });
        let speeds: Vec<(f64, f64)> = speeds.collect();
        let gains = speeds.windows(2);
        let gains = gains.map(|two| 2.0 * (two[1].0 - two[0].0) / (two[0].1 + two[1].1));
        let gains: Vec<f64> = gains.collect();
        let twice = gains.windows(2).filter(|two| two[0] * two[1] > 0.0);
        let twice = twice.map(|two| two[0].abs().min(two[1].abs()));
        Self {
            reached: twice.fold(0.0, f64::max),
            ..self
        }
    }

    /// A wheel's teeth; at least one is there.
    pub fn teeth(present: &[bool]) -> Self {
        let there = (0..).zip(present).filter(|(_, there)| **there);
        let there: Vec<i64> = there.map(|(place, _)| place).collect();
        let all = there.len() == present.len();
        Self {
            present: if all { Vec::new() } else { there },
            ..Self::full(present.len() as u32, 1)
        }
    }

    /// Ranks a turn.
    pub fn ranks(&self) -> i64 {
        if self.present.is_empty() {
            self.edges
        } else {
            self.present.len() as i64
        }
    }

    /// Ranks that a start has to choose from: those of a turn where gaps tell them apart, else one for each class.
    pub fn starts(&self) -> i64 {
        if self.present.is_empty() {
            1
        } else {
            self.ranks()
        }
    }

    /// Grid place of a rank.
    #[inline]
    pub fn place(&self, rank: i64) -> i64 {
        if self.present.is_empty() {
            return rank;
        }
        let ranks = self.present.len() as i64;
        rank.div_euclid(ranks) * self.edges + self.present[rank.rem_euclid(ranks) as usize]
    }

    /// Way between two edges, in grid edges, at least a small one.
    #[inline]
    pub fn distance(&self, from: i64, to: i64) -> f64 {
        if self.measured.is_empty() {
            return (self.place(to) - self.place(from)).abs().max(1) as f64;
        }
        let ranks = self.measured.len() as i64;
        let at = |rank: i64| {
            let turns = rank.div_euclid(ranks) * self.edges;
            turns as f64 + self.measured[rank.rem_euclid(ranks) as usize]
        };
        (at(to) - at(from)).abs().max(1e-3)
    }

    /// Sectors this far apart look alike.
    pub fn alike(&self) -> i64 {
        if self.present.is_empty() && self.measured.is_empty() {
            self.classes
        } else {
            self.ranks()
        }
    }

    /// The same grid with each edge where it stands at a speed that is the same all the turn, from steps between edges that follow each
    /// other: ticks and ranks of their ends. None where a step did not come often enough within a whole turn.
    pub fn measure(&self, steps: impl Iterator<Item = [(u64, i64); 2]>) -> Option<Self> {
        let ranks = self.ranks() as usize;
        let mut each = vec![Vec::new(); ranks];
        let mut turn: VecDeque<u64> = VecDeque::with_capacity(ranks + 1);
        let mut last = None;
        for [from, to] in steps {
            if last != Some(from) || to.1 != from.1 + 1 {
                turn.clear();
                turn.push_back(from.0);
            }
            last = Some(to);
            turn.push_back(to.0);
            if turn.len() <= ranks {
                continue;
            }
            let (middle, whole) = (ranks / 2, (to.0 - turn[0]) as f64);
            let rank = to.1 - (ranks - middle) as i64 + 1;
            let step = (turn[middle + 1] - turn[middle]) as f64;
            each[rank.rem_euclid(ranks as i64) as usize].push(step / whole);
            turn.pop_front();
        }
        if each.iter().any(|steps| steps.len() < TURNS) {
            return None;
        }
        let shares: Vec<f64> = each.into_iter().filter_map(median).collect();
        let scale = self.edges as f64 / shares.iter().sum::<f64>();
        // The step of rank 0 leads to it, from the last edge of the turn before.
        let mut at = 0.0;
        let measured = (0..ranks).map(|rank| {
            at += if rank == 0 { 0.0 } else { shares[rank] * scale };
            at
        });
        Some(Self {
            measured: measured.collect(),
            ..self.clone()
        })
    }

    /// Steps forward, 0 to classes - 1, from the sector of `rank` to the next one that shows `class`.
    #[inline]
    pub fn ahead(&self, rank: i64, class: u8) -> i64 {
        (i64::from(class) - rank).rem_euclid(self.classes)
    }

    /// Classes that levels tell apart.
    #[inline]
    pub fn classes(&self) -> i64 {
        self.classes
    }
}

/// From one edge to the next: ticks, as a log, and grid edges.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    pub log: f64,
    pub distance: f64,
}

/// A speed that changes smoothly.
#[derive(Clone, Copy, Debug)]
pub(super) struct Speed {
    /// Log of grid edges a tick.
    pub log: f64,
    /// Its change an edge.
    pub slope: f64,
    /// Variance of a log interval about its prediction.
    pub variance: f64,
}

impl Speed {
    /// Of which nothing else is known.
    pub const fn alone(log: f64) -> Self {
        Self {
            log,
            slope: 0.0,
            variance: 0.0,
        }
    }

    /// As a first interval tells it. Of a spread the standard deviations of a log interval at a start and at the most are given.
    pub fn first([start, _]: [f64; 2], interval: Interval) -> Self {
        Self {
            variance: start * start,
            ..Self::alone(interval.distance.ln() - interval.log)
        }
    }

    /// How the log speed changes along a way of edges.
    fn ahead(&self, distance: f64) -> f64 {
        self.slope * 0.5 * (distance + 1.0).min(4.0)
    }

    /// By how much a log interval is off its prediction.
    pub fn off(&self, Interval { log, distance }: Interval) -> f64 {
        self.log + self.ahead(distance) + log - distance.ln()
    }

    /// Log likelihood of a log interval that is so much off its prediction, and how sure it is that it belongs to smooth motion.
    pub fn likelihood(&self, off: f64) -> (f64, f64) {
        let inner =
            (-0.5 * off * off / self.variance).exp() / self.variance.sqrt() * TAU.sqrt().recip();
        let outer = OUTLIERS / (PI * (1.0 + off * off));
        let sum = inner + outer;
        (sum.ln(), inner / sum)
    }

    /// What it is after an interval.
    pub fn after(&self, [start, most]: [f64; 2], interval: Interval, off: f64, sure: f64) -> Self {
        let gain = GAINS[0] * sure + (1.0 - sure);
        let square = (off * off).min(9.0 * self.variance);
        let spread = self.variance + GAINS[2] * sure * (square - self.variance);
        let loose = (off * off).min(start * start) * (1.0 - sure);
        let least = SPREAD_LEAST * SPREAD_LEAST;
        // An innovation is what the interval lacks of speed: too long is too slow.
        Self {
            log: self.log + self.ahead(interval.distance) - gain * off,
            slope: ((self.slope - GAINS[1] * off / interval.distance) * sure).clamp(-0.3, 0.3),
            variance: spread.max(loose).clamp(least, most * most),
        }
    }
}

/// Log likelihood of a log interval that is about as the last one and `r` off it (Cauchy).
pub(super) fn broad(r: f64) -> f64 {
    -(PI * (1.0 + r * r)).ln()
}

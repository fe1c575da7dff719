//! Stamps of one recording against a task that may have held them up.
//!
//! An edge's crossing is expected by its neighbours to c, give or take p, and its stamp is off by the jitter j. Outside of the busy time
//! the stamp t is normal about c; within, it is normal about the busy time's end E whatever c is. So each edge has the likelihood
//! `(1 - P(crossing within | t, c)) N(t; c, p^2 + j^2) + P(crossing within | c) N(t; E, j^2)`.
//! A stamp far off for any other reason is as likely at one time of the task's period as at another.

use super::super::super::board::Bench;
use super::super::super::pace::pace;
use super::super::odds::normal_above;
use super::busy::Busy;

/// Share of stamps that may be off for some other reason.
const STRAY: f64 = 1e-3;
/// Deviations from the busy time beyond which an edge says nothing.
const FAR: f64 = 5.0;
/// Speed over the fastest from which on a stamp says when an edge came.
const SLOWEST: f64 = 0.1;
/// Deviations from either end of the busy time from which on an edge is surely within.
const INSIDE: f64 = 4.0;

/// One recording.
#[derive(Clone, Debug)]
pub struct Stamps<'a> {
    /// It.
    pub bench: &'a Bench,
    left: &'a [f64],
    /// How much later each edge came than the others let expect, s.
    pub late_s: Vec<f64>,
    /// Variance of that, s^2, where nothing holds edges up.
    variances: Vec<f64>,
    /// RMS error of a stamp, s.
    pub jitter_s: f64,
    /// What was taken off each stamp, s.
    removed_s: Vec<f64>,
    /// Speed at each edge as the edges beside it have it, rad/s, negative in reverse: over a long delay the shaft's wander counts.
    pace: Vec<f64>,
}

impl<'a> Stamps<'a> {
    /// Of what is left, white.
    #[must_use]
    pub fn of(bench: &'a Bench, left: &'a [f64]) -> Self {
        let precisions = bench.whitener().precisions();
        let speeds = &bench.seen.speeds;
        let fastest = speeds.iter().fold(0.0_f64, |most, w| most.max(w.abs()));
        // Where the shaft all but stands a stamp says nothing of the time.
        let weights = precisions.iter().zip(speeds).map(|(d, w)| {
            let turns = w.abs() > SLOWEST * fastest;
            if turns { d * w * w } else { 0.0 }
        });
        // What is in doubt is held against what the others let expect as if it were not.
        let doubts = bench.seen.readings.iter().map(|reading| reading.doubt_s);
        let variances: Vec<f64> = weights
            .zip(doubts)
            .map(|(weight, doubt)| {
                if weight > 0.0 {
                    (1.0 / weight - doubt * doubt).max(bench.least_stamp_s.powi(2))
                } else {
                    f64::INFINITY
                }
            })
            .collect();
        let mut row = Self {
            bench,
            left,
            late_s: Vec::new(),
            variances,
            jitter_s: bench.noise.stamp_s,
            removed_s: vec![0.0; left.len()],
            pace: Vec::new(),
        };
        row.pace = pace(&bench.seen, &row.removed_s);
        row.late_s = row.later(left);
        // Stamps that a task holds up make all of them look worse than they are.
        let quiet = row.usual_deviation().min(1.0);
        row.jitter_s *= quiet;
        row.variances.iter_mut().for_each(|v| *v *= quiet * quiet);
        row
    }

    /// Edges.
    #[must_use]
    pub fn len(&self) -> usize {
        self.late_s.len()
    }

    /// When the others let expect an edge, s.
    #[must_use]
    pub fn crossed_s(&self, at: usize) -> f64 {
        self.bench.seen.times_s[at] - self.late_s[at]
    }

    /// What an edge's lateness says, 1/s^2.
    #[must_use]
    pub fn weight(&self, at: usize) -> f64 {
        1.0 / self.variances[at]
    }

    /// Lateness over its standard deviation.
    #[must_use]
    pub fn deviation(&self, at: usize) -> f64 {
        self.late_s[at] / self.variances[at].sqrt()
    }

    /// Middle of the recording, s.
    #[must_use]
    pub fn middle_s(&self) -> f64 {
        let times_s = &self.bench.seen.times_s;
        let ends = times_s.first().zip(times_s.last());
        ends.map_or(0.0, |(first, last)| 0.5 * (first + last))
    }

    /// Median size of the deviations, over that of normal ones.
    fn usual_deviation(&self) -> f64 {
        const NORMAL: f64 = 0.674_49;
        let sizes = (0..self.len()).map(|at| self.deviation(at).abs());
        let mut sizes: Vec<f64> = sizes.filter(|size| *size > 0.0).collect();
        let middle = sizes.len() / 2;
        if sizes.is_empty() {
            return 1.0;
        }
        let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
        *median / NORMAL
    }

    fn later(&self, white: &[f64]) -> Vec<f64> {
        let mut rows = white.to_vec();
        self.bench.transposed(&mut rows);
        let seen = &self.bench.seen;
        let each = rows.iter().zip(&self.variances).enumerate();
        each.map(|(at, (u, variance))| {
            if variance.is_finite() {
                let all2 = variance + seen.readings[at].doubt_s.powi(2);
                -u * all2 * seen.speeds[at].powi(2) / self.pace[at]
            } else {
                0.0
            }
        })
        .collect()
    }

    /// End of the busy time nearest to a time.
    fn end_s(task: &Busy, end_s: f64, time_s: f64) -> f64 {
        end_s + ((time_s - end_s) * task.f_hz).round() / task.f_hz
    }

    /// Whether a task may have held up an edge, or missed one that it should have.
    fn near(&self, at: usize, task: &Busy, end_s: f64) -> bool {
        let (time, late) = (self.bench.seen.times_s[at], self.late_s[at]);
        let crossed = time - late;
        let reach = FAR * self.variances[at].sqrt();
        let end = Self::end_s(task, end_s, time);
        let near = |end: f64| {
            let (low, high) = (end - task.busy_s - reach, end + reach);
            (low..high).contains(&time) || (low..high).contains(&crossed)
        };
        near(end) || near(end + 1.0 / task.f_hz)
    }

    /// Edges of which a task's likelihood hangs.
    #[must_use]
    pub fn all_near(&self, task: &Busy, number: usize) -> Vec<usize> {
        let sure = (0..self.len()).filter(|at| self.variances[*at].is_finite());
        sure.filter(|at| self.near(*at, task, task.ends_s[number]))
            .collect()
    }

    /// Gain in the logarithm of the likelihood of an edge by a task, and the probability that it was held up.
    fn edge(&self, at: usize, task: &Busy, end_s: f64) -> (f64, f64) {
        let (time, late) = (self.bench.seen.times_s[at], self.late_s[at]);
        let (all2, own2) = (self.variances[at], self.jitter_s * self.jitter_s);
        if !all2.is_finite() {
            return (0.0, 0.0);
        }
        if !self.near(at, task, end_s) {
            return (0.0, 0.0);
        }
        let crossed = time - late;
        let end = Self::end_s(task, end_s, time);
        let next = end + 1.0 / task.f_hz;
        let expected2 = (all2 - own2).max(0.01 * all2);
        // Where it crossed if its stamp is its own.
        let (mean, spread) = (
            crossed + late * expected2 / all2,
            (expected2 * own2 / all2).sqrt(),
        );
        let within = |end: f64, mean: f64, spread: f64| {
            normal_above((end - task.busy_s - mean) / spread) - normal_above((end - mean) / spread)
        };
        let inside: f64 = [end, next]
            .iter()
            .map(|end| within(*end, mean, spread))
            .sum();
        let normal = |off: f64, variance: f64| {
            (-0.5 * off * off / variance).exp() / (std::f64::consts::TAU * variance).sqrt()
        };
        let stray = STRAY * task.f_hz;
        let free = normal(late, all2);
        let held = within(end, crossed, expected2.sqrt()).max(0.0) * normal(time - end, own2);
        let own = free * (1.0 - inside).max(STRAY) + stray;
        (((own + held) / (free + stray)).ln(), held / (own + held))
    }

    /// RMS by which stamps that were held up are off the ends of the busy times, s, but no less than other stamps are off.
    pub fn scatter_s(&self, task: &Busy, number: usize) -> f64 {
        let end_s = task.ends_s[number];
        let held = self.held(task, number).into_iter();
        let (sum, count) = held.fold((0.0, 0.0), |(sum, count), (at, held, period)| {
            let off = self.bench.seen.times_s[at] - end_s - period / task.f_hz;
            (sum + held * off * off, count + held)
        });
        self.jitter_s.max((sum / f64::max(count, 1.0)).sqrt())
    }

    /// Edges that surely crossed within the busy time and were not held up.
    #[must_use]
    pub fn passed(&self, task: &Busy, number: usize) -> f64 {
        let mut held = vec![0.0; self.len()];
        for (at, share, _) in self.held(task, number) {
            held[at] = share;
        }
        let passed = (0..self.len()).filter(|&at| {
            let sure = INSIDE * self.variances[at].sqrt();
            let crossed = self.crossed_s(at);
            let end = task.ends_s[number];
            let end = end + ((crossed - end) * task.f_hz).ceil() / task.f_hz;
            let inside = end - task.busy_s + sure < crossed && crossed < end - sure;
            self.variances[at].is_finite() && inside && held[at] < 0.5
        });
        passed.count() as f64
    }

    /// Gain in the logarithm of the likelihood by a task.
    #[must_use]
    pub fn gain(&self, task: &Busy, number: usize) -> f64 {
        self.gain_of(0..self.len(), task, number)
    }

    /// The same of some edges.
    pub fn gain_of(&self, edges: impl Iterator<Item = usize>, task: &Busy, number: usize) -> f64 {
        edges
            .map(|at| self.edge(at, task, task.ends_s[number]).0)
            .sum()
    }

    /// Edges that were held up: which, with what probability, and which of the task's periods it was.
    #[must_use]
    pub fn held(&self, task: &Busy, number: usize) -> Vec<(usize, f64, f64)> {
        let end_s = task.ends_s[number];
        let edges = (0..self.len()).map(|at| (at, self.edge(at, task, end_s).1));
        let held = edges.filter(|(_, held)| *held > 1e-3);
        held.map(|(at, held)| {
            let time = self.bench.seen.times_s[at];
            (at, held, ((time - end_s) * task.f_hz).round())
        })
        .collect()
    }

    /// Takes what a task makes of the stamps off, so that edges beside those that it held up are expected where they are.
    pub fn clear(&mut self, task: &Busy, number: usize) {
        let held = self.held(task, number);
        let mut removed = vec![0.0; self.len()];
        for (at, held, period) in held {
            let end = task.ends_s[number] + period / task.f_hz;
            removed[at] = held * (end - self.crossed_s(at)).clamp(0.0, task.busy_s);
        }
        self.pace = pace(&self.bench.seen, &removed);
        self.removed_s = removed;
        let pairs = self.left.iter().zip(self.pattern());
        let rest: Vec<f64> = pairs.map(|(left, pattern)| left - pattern).collect();
        let more = self.later(&rest);
        self.late_s = self
            .removed_s
            .iter()
            .zip(more)
            .map(|(off, more)| off + more)
            .collect();
    }

    /// What was taken off, white.
    #[must_use]
    pub fn pattern(&self) -> Vec<f64> {
        let each = self.removed_s.iter().zip(&self.pace);
        self.bench
            .whitened(each.map(|(late, w)| -w * late).collect())
    }

    /// Fall of the sum of squares by what was taken off, and what it leaves.
    #[must_use]
    pub fn squares(&self) -> (f64, f64) {
        let square = |x: f64| x * x;
        let before: f64 = self.left.iter().map(|left| square(*left)).sum();
        let pairs = self.left.iter().zip(self.pattern());
        let after: f64 = pairs.map(|(left, pattern)| square(left - pattern)).sum();
        (before - after, after)
    }
}

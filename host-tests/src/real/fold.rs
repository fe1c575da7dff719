//! Edges of a Hall recording by their place on the turn, and how well a fixed pattern explains their intervals.
//!
//! Shares no code with the diagnosis. An interval is held against the mean of the turn around it: its *share* is its length times N
//! over that of a turn centred on it, 1 for a perfect disc at any steady speed or acceleration. Unexplained is the mean square of
//! share less prediction over the variance of the shares: 1 - R^2.

use std::f64::consts::TAU;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use quadcal_host::recording::{ReadOptions, open};

/// States of the sensors in forward order, A the lowest bit.
const FORWARD: [u8; 6] = [0b100, 0b110, 0b010, 0b011, 0b001, 0b101];

/// One edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// When, ticks.
    pub ticks: u64,
    /// Edges counted from the first.
    pub place: i64,
    /// Levels after it.
    pub levels: u8,
    /// Channel that changed, 0 is A.
    pub channel: usize,
    /// Whether it rose.
    pub rises: bool,
}

/// A recording's edges.
#[derive(Clone, Debug)]
pub struct Edges {
    /// They, by time.
    pub all: Vec<Edge>,
    /// How many a turn has, N.
    pub a_turn: usize,
    /// Tick rate, Hz.
    pub clock_hz: f64,
}

/// An interval over the mean of the turn around it.
#[derive(Clone, Copy, Debug)]
pub struct Interval {
    /// The edge that ends it, by its number in the recording.
    pub at: usize,
    /// Its edge of the disc, 0 to N - 1 from the recording's first.
    pub slot: usize,
    /// The turn's duration, s.
    pub turn_s: f64,
    /// Its share.
    pub share: f64,
}

impl Edges {
    /// Of a recording that starts with the levels before the first edge.
    ///
    /// # Errors
    /// Where it can't be read or a sensor jumps.
    pub fn of(path: &Path, a_turn: usize) -> Result<Self> {
        let rows = open(path, &ReadOptions::default())?;
        let clock_hz = rows.header.clock_hz as f64;
        let mut all: Vec<Edge> = Vec::new();
        let (mut before, mut place) = (None, -1);
        for row in rows {
            let row = row?;
            let levels = row.levels.0 & 0b111;
            let number = |state: u8| FORWARD.iter().position(|s| *s == state);
            let here = number(levels).with_context(|| format!("no state {levels:03b}"))?;
            let Some((last, was)) = before.replace((here, levels)) else {
                continue;
            };
            let step = (here + 6 - last) % 6;
            ensure!(step == 1 || step == 5, "a jump at tick {}", row.ticks);
            place += if step == 1 { 1 } else { -1 };
            let changed = levels ^ was;
            all.push(Edge {
                ticks: row.ticks,
                place,
                levels,
                channel: changed.trailing_zeros() as usize,
                rises: levels & changed != 0,
            });
        }
        Ok(Self {
            all,
            a_turn,
            clock_hz,
        })
    }

    /// Every interval with a whole turn around it in one direction, at so many turns a second or more.
    #[must_use]
    pub fn intervals(&self, least_rev_s: f64) -> Vec<Interval> {
        let half = self.a_turn / 2;
        let ticks = |at: usize| self.all[at].ticks as f64;
        (half + 1..self.all.len().saturating_sub(half))
            .filter_map(|at| {
                let whole = self.all[at + half].place - self.all[at - half - 1].place;
                let (last, first) = (ticks(at + half), ticks(at - half - 1));
                let turn = 0.5 * (last - ticks(at - half) + ticks(at + half - 1) - first);
                let turn_s = turn / self.clock_hz;
                let share = (ticks(at) - ticks(at - 1)) * self.a_turn as f64 / turn;
                let slot = self.all[at].place.rem_euclid(self.a_turn as i64) as usize;
                (whole == 2 * half as i64 + 1 && turn_s * least_rev_s <= 1.0).then_some(Interval {
                    at,
                    slot,
                    turn_s,
                    share,
                })
            })
            .collect()
    }

    /// The fixed pattern of these intervals: e(k) of each edge, rad, of zero mean.
    #[must_use]
    pub fn pattern(&self, intervals: &[Interval]) -> Vec<f64> {
        let mut sums = vec![(0.0, 0.0); self.a_turn];
        for interval in intervals {
            let sum = &mut sums[interval.slot];
            *sum = (sum.0 + interval.share, sum.1 + 1.0);
        }
        let shares: Vec<f64> = sums
            .iter()
            .map(|(sum, n)| sum / f64::max(*n, 1.0))
            .collect();
        let mean = shares.iter().sum::<f64>() / self.a_turn as f64;
        let step = TAU / self.a_turn as f64;
        let mut error = 0.0;
        let mut errors: Vec<f64> = Vec::new();
        for share in &shares {
            error += step * (1.0 - share / mean);
            errors.push(error);
        }
        let middle = errors.iter().sum::<f64>() / self.a_turn as f64;
        errors.iter().map(|error| error - middle).collect()
    }

    /// Share of the intervals' variance that errors of the disc, rad, and delays of each edge, s, leave unexplained.
    #[must_use]
    pub fn unexplained(
        &self,
        intervals: &[Interval],
        errors: &[f64],
        delay_s: &dyn Fn(&Edge) -> f64,
    ) -> f64 {
        let step = TAU / self.a_turn as f64;
        let left = intervals.iter().map(|interval| {
            let before = (interval.slot + self.a_turn - 1) % self.a_turn;
            let disc = (errors[interval.slot] - errors[before]) / step;
            let late = delay_s(&self.all[interval.at]) - delay_s(&self.all[interval.at - 1]);
            let expected = 1.0 - disc + late * self.a_turn as f64 / interval.turn_s;
            (interval.share - expected).powi(2)
        });
        left.sum::<f64>() / intervals.len() as f64 / variance(intervals)
    }

    /// The share that stamps in whole ticks alone leave: each end of an interval is off by 1/12 tick^2 of variance.
    #[must_use]
    pub fn quantisation(&self, intervals: &[Interval]) -> f64 {
        let each = intervals.iter().map(|interval| {
            let ticks = interval.turn_s * self.clock_hz / self.a_turn as f64;
            2.0 / 12.0 / (ticks * ticks)
        });
        each.sum::<f64>() / intervals.len() as f64 / variance(intervals)
    }

    /// Rows of the recording from the edge at `from` on until before that at `until`, as a recording of its own that starts with the
    /// levels before its first edge.
    #[must_use]
    pub fn cut(&self, from: usize, until: usize) -> String {
        let mut text = format!("# clock_hz = {}\nticks,a,b,c\n", self.clock_hz);
        let start = from.saturating_sub(1);
        let bit = |levels: u8, channel: usize| levels >> channel & 1;
        for edge in &self.all[start..until] {
            let ticks = edge.ticks - self.all[start].ticks;
            let [a, b, c] = [0, 1, 2].map(|channel| bit(edge.levels, channel));
            text += &format!("{ticks},{a},{b},{c}\n");
        }
        text
    }

    /// The first edge from a place on that starts a turn: that is the edge of the disc which the recording began with.
    #[must_use]
    pub fn turn_from(&self, at: usize) -> usize {
        let starts = |at: &usize| self.all[*at].place.rem_euclid(self.a_turn as i64) == 0;
        (at..self.all.len()).find(starts).unwrap_or(at)
    }
}

fn variance(intervals: &[Interval]) -> f64 {
    let count = intervals.len() as f64;
    let mean = intervals.iter().map(|i| i.share).sum::<f64>() / count;
    let squares = intervals.iter().map(|i| (i.share - mean).powi(2));
    squares.sum::<f64>() / count
}

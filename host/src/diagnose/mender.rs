//! Takes rows one by one, or several read again.

use super::code::Code;
use super::mend::{Fault, FaultKind};
use super::repair::{Kept, Repair, Surroundings};
use super::widths::widths;
use crate::recording::Row;

/// A row at which a channel that counts changes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub row: usize,
    pub ticks: u64,
    pub levels: u8,
    /// Whether another channel, the index, changes with it.
    pub shared: bool,
}

/// An interval so much longer than the one before, or shorter, is looked at.
const LONG: f64 = 1.9;
const SHORT: f64 = 0.45;
/// Rows of a window that is read again.
pub(super) const WINDOW: usize = 5;

/// What is kept of the rows so far, and what is to be changed in them.
pub(super) struct Mender {
    pub code: Code,
    pub edges: Vec<Edge>,
    /// Share of each state in a round, relative to the mean.
    pub widths: Vec<f64>,
    pub kept: Vec<Kept>,
    pub faults: Vec<Fault>,
    /// Edges that were lost and put in.
    pub lost: u64,
    /// Levels to be taken out again: from row, to row, bit.
    pub flips: Vec<(usize, usize, u8)>,
    /// Rows to be left out.
    pub dropped: Vec<usize>,
    /// Rows whose time is not that of their edge.
    pub untimed: Vec<usize>,
    /// Edges to be put in: before which row at the latest, when, and their levels.
    pub put_in: Vec<(usize, u64, u8)>,
}

impl Mender {
    pub fn new(code: Code, rows: &[Row]) -> Self {
        let mut edges: Vec<Edge> = Vec::with_capacity(rows.len());
        let mut others = None;
        for (row, sample) in rows.iter().enumerate() {
            let levels = sample.levels.0 & code.mask();
            let now = sample.levels.0 & !code.mask();
            let shared = others.replace(now).is_some_and(|before| before != now);
            if edges.last().is_none_or(|last| last.levels != levels) {
                edges.push(Edge {
                    row,
                    ticks: sample.ticks,
                    levels,
                    shared,
                });
            }
        }
        let widths = widths(code, &edges);
        Self {
            code,
            kept: Vec::with_capacity(edges.len()),
            edges,
            widths,
            faults: Vec::new(),
            lost: 0,
            flips: Vec::new(),
            dropped: Vec::new(),
            untimed: Vec::new(),
            put_in: Vec::new(),
        }
    }

    /// Takes an edge, or as many as are read again with it; returns the next.
    pub fn take(&mut self, at: usize) -> usize {
        let edge = self.edges[at];
        let state = self.code.state(edge.levels);
        let Some(&last) = self.kept.last() else {
            if let Some(state) = state {
                self.kept.push(Kept::first(at, edge.ticks, state));
            } else {
                self.dropped.push(edge.row);
            }
            return at + 1;
        };
        if let Some(state) = state
            && let Some(way) = self.way(last.state, state)
        {
            let next = Kept {
                edge: Some(at),
                ticks: edge.ticks,
                state,
                way,
                pace: self.pace(&last, edge.ticks, way, 1),
            };
            let usual = last.way == 0
                || way == last.way && next.pace < LONG * last.pace && next.pace > SHORT * last.pace;
            if edge.shared && usual {
                return self.take_shared(at, next);
            }
            if usual {
                self.kept.push(next);
                return at + 1;
            }
            if let Some(repair) = self.repair(at) {
                return self.mended(&repair);
            }
            self.kept.push(next);
            return at + 1;
        }
        if let Some(repair) = self.repair(at) {
            return self.mended(&repair);
        }
        self.give_up(at, state);
        at + 1
    }

    /// Takes an edge that came in one row with a change of the index. Two rows would have come had its own not been lost.
    fn take_shared(&mut self, at: usize, next: Kept) -> usize {
        let before = self.kept.len();
        let late = Surroundings::of(self, before, at).is_some_and(|around| around.late(self, at));
        if let Some(last) = self.kept.last()
            && late
        {
            let after = self.edges.get(at + 1).map_or(next.ticks, |edge| edge.ticks);
            self.faults.push(Fault {
                kind: FaultKind::Lost,
                ticks: last.ticks + (after - last.ticks) / 2,
                edges: 1,
                // The row is the index's, near enough at this edge's own time.
                number: Some(before as u64 + self.lost),
                channel: self.code.channel(last.state, next.way),
                doubtful: false,
            });
            self.untimed.push(self.edges[at].row);
            let pace = last.pace;
            self.kept.push(Kept { pace, ..next });
            // The interval after it is as much too short.
            if let Some(edge) = self.edges.get(at + 1)
                && let Some(state) = self.code.state(edge.levels)
                && self.way(next.state, state) == Some(next.way)
            {
                self.kept.push(Kept {
                    edge: Some(at + 1),
                    ticks: edge.ticks,
                    state,
                    way: next.way,
                    pace,
                });
                return at + 2;
            }
            return at + 1;
        }
        self.kept.push(next);
        at + 1
    }

    /// Direction of a step from state to state; none where it is no single step.
    pub fn way(&self, from: i64, to: i64) -> Option<i64> {
        let states = self.code.states();
        match (to - from).rem_euclid(states) {
            1 => Some(1),
            back if back == states - 1 => Some(-1),
            _ => None,
        }
    }

    /// Ticks an edge over some edges after a kept one, as if all states were equally wide.
    pub fn pace(&self, from: &Kept, ticks: u64, way: i64, edges: i64) -> f64 {
        let states = self.code.states();
        let width = |n: i64| {
            let state = (from.state + way * n).rem_euclid(states);
            self.widths[usize::try_from(state).unwrap_or(0)]
        };
        let width: f64 = (0..edges).map(width).sum();
        ticks.saturating_sub(from.ticks) as f64 / width
    }

    /// How the rows around an edge are best read, where the motion around is steady.
    fn repair(&self, at: usize) -> Option<Repair> {
        let first = match self.kept.last()?.edge {
            Some(last) if last + 1 == at && self.kept.len() > 1 => last,
            _ => at,
        };
        let before = self.kept.len() - usize::from(first < at);
        let around = Surroundings::of(self, before, first)?;
        around.best(self, first)
    }

    fn mended(&mut self, repair: &Repair) -> usize {
        self.kept.truncate(repair.from_kept);
        if let Some([from, to]) = repair.pulse {
            let bit = self.edges[from].levels ^ self.edges[from - 1].levels;
            let rows = [self.edges[from].row, self.edges[to].row];
            self.flips.push((rows[0], rows[1], bit));
            self.faults.push(Fault {
                kind: FaultKind::Extra,
                ticks: self.edges[from].ticks,
                edges: 2,
                number: None,
                channel: bit.trailing_zeros() as usize,
                doubtful: false,
            });
            self.untimed
                .extend(repair.untimed.iter().map(|edge| self.edges[*edge].row));
        }
        for (next, edges) in &repair.kept {
            if let Some(last) = self.kept.last().copied()
                && *edges > 1
            {
                self.lose(&last, next, *edges, false);
            }
            self.kept.push(*next);
        }
        repair.next
    }

    /// Books edges lost between two kept ones and puts them in.
    fn lose(&mut self, last: &Kept, next: &Kept, edges: i64, doubtful: bool) {
        let each = next.ticks.saturating_sub(last.ticks) as f64 / edges as f64;
        for n in 1..edges {
            let ticks = last.ticks + (n as f64 * each) as u64;
            let levels = self.code.levels(last.state + n * next.way);
            let row = next.edge.map_or(usize::MAX, |edge| self.edges[edge].row);
            self.put_in.push((row, ticks, levels));
        }
        self.faults.push(Fault {
            kind: FaultKind::Lost,
            ticks: last.ticks + each as u64,
            edges: u32::try_from(edges - 1).unwrap_or(0),
            number: Some(self.kept.len() as u64 + self.lost),
            channel: self.code.channel(last.state, next.way),
            doubtful,
        });
        self.lost += u64::try_from(edges - 1).unwrap_or(0);
    }

    /// Levels that can't be, where nothing tells how they came about: the shorter way, else on as before.
    fn give_up(&mut self, at: usize, state: Option<i64>) {
        let edge = self.edges[at];
        let (Some(state), Some(&last)) = (state, self.kept.last()) else {
            self.dropped.push(edge.row);
            self.faults.push(Fault {
                kind: FaultKind::Extra,
                ticks: edge.ticks,
                edges: 1,
                number: None,
                channel: 0,
                doubtful: true,
            });
            return;
        };
        let states = self.code.states();
        let ahead = (state - last.state).rem_euclid(states);
        let way = match (2 * ahead).cmp(&states) {
            std::cmp::Ordering::Less => 1,
            std::cmp::Ordering::Greater => -1,
            std::cmp::Ordering::Equal if last.way != 0 => last.way,
            std::cmp::Ordering::Equal => 1,
        };
        let edges = ahead.min(states - ahead);
        if edges == 0 {
            return;
        }
        let next = Kept {
            edge: Some(at),
            ticks: edge.ticks,
            state,
            way,
            pace: self.pace(&last, edge.ticks, way, edges),
        };
        self.lose(&last, &next, edges, true);
        self.kept.push(next);
    }
}

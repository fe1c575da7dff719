//! Sensors whose levels say where in a line or pole pair the shaft is, and so which way it turns; and the index, which says which edge of
//! the disc a place is, and where it moved against it.

use quadcal::decoder::class_of;
use quadcal::edge::Levels;
use quadcal::hall::state_of;

use super::follow::{Seen, follow};
use super::grid::{Grid, Sight};
use super::{CountEvent, CountKind, Edges, Stretch, Unused};
use crate::recording::Row;

/// How levels stand for sectors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Code {
    /// A and B.
    Quadrature,
    /// A, B and C.
    Hall,
}

impl Code {
    const fn mask(self) -> u8 {
        match self {
            Self::Quadrature => Levels::A | Levels::B,
            Self::Hall => Levels::A | Levels::B | Levels::C,
        }
    }

    /// Class of the edge that leads forward to the levels; none where no sector shows them.
    fn class(self, levels: u8) -> Option<u8> {
        match self {
            Self::Quadrature => Some(class_of(Levels(levels)) as u8),
            // Edge 0 leads from state 0 to state 1.
            Self::Hall => state_of(Levels(levels)).map(|state| ((state + 5) % 6) as u8),
        }
    }

    /// The channel that changes at an edge of a class.
    fn channel(self, class: i64) -> u8 {
        let channels: &[u8] = match self {
            Self::Quadrature => &[Levels::A, Levels::B],
            Self::Hall => &[Levels::B, Levels::C, Levels::A],
        };
        channels[class.rem_euclid(channels.len() as i64) as usize]
    }
}

/// Rows at the start that a capture may have held from before, at the most.
const HELD: usize = 16;
/// How many times as long as theirs each of as many intervals after them is: no shaft slows down so from one edge to the next.
const SLOWER: u64 = 20;

/// Rows at the start that are no edges of this recording: they come all at once, and then the shaft goes on at its speed. The last of them
/// says where it is.
fn held_before(rows: &[Row], mask: u8) -> usize {
    let changes = rows.windows(2).enumerate().filter(|(_, pair)| {
        let changed = pair[0].levels.0 ^ pair[1].levels.0;
        changed & mask != 0
    });
    let changes: Vec<(usize, u64)> = changes
        .take(3 * HELD)
        .map(|(at, pair)| (at, pair[1].ticks))
        .collect();
    let apart: Vec<u64> = changes.windows(2).map(|two| two[1].1 - two[0].1).collect();
    let ends = |&last: &usize| {
        let (before, after) = apart.split_at(last);
        let longest = before.iter().max().map_or(0, |most| SLOWER * most);
        let mut after = after.iter().take(HELD);
        after.len() == HELD && after.all(|apart| *apart > longest)
    };
    // A single interval may be short by a glitch or a reversal.
    let last = (2..HELD.min(apart.len())).rev().find(ends);
    last.map_or(0, |last| changes[last].0 + 1)
}

/// Places the edges of a quadrature encoder or of Hall sensors.
pub(super) fn place(code: Code, index_state: Option<Levels>, rows: &[Row], edges: &mut Edges) {
    let mask = code.mask();
    let class = |row: &Row| code.class(row.levels.0 & mask);
    let held = held_before(rows, mask);
    if held > 0 {
        edges.unused.push(Stretch {
            from_s: edges.seconds(rows[0].ticks),
            until_s: edges.seconds(rows[held].ticks),
            rows: held,
            why: Unused::Bounces,
        });
    }
    let rows = &rows[held..];
    let Some(first) = rows.iter().position(|row| class(row).is_some()) else {
        return;
    };
    let start = class(&rows[first]).map(|class| (rows[first].ticks, class));
    let changes = || {
        let pairs = rows[first..].windows(2);
        pairs.filter_map(|pair| {
            let changed = (pair[0].levels.0 ^ pair[1].levels.0) & mask;
            (changed != 0).then_some((pair[1], changed))
        })
    };
    let ticks: Vec<u64> = changes().map(|(row, _)| row.ticks).collect();
    let grid = Grid::full(edges.grid_edges, edges.classes as u8).moved(&ticks);
    let sights = changes().map(|(row, _)| Sight {
        ticks: row.ticks,
        class: class(&row),
    });
    let way = follow(&grid, start, sights);
    edges.fit = way.score / way.seen.len().max(1) as f64;

    let mut last: Option<(i64, bool)> = None;
    let mut open_extra = false;
    for ((row, changed), seen) in changes().zip(&way.seen) {
        let Seen::Edge {
            rank,
            forward,
            fresh,
        } = *seen
        else {
            // Rows of one pulse are one event.
            if let Some(event) = edges.events.last_mut().filter(|_| open_extra) {
                event.edges += 1;
            } else {
                let (time_s, place) = (edges.seconds(row.ticks), last.map_or(0, |(edge, _)| edge));
                let extra = CountEvent::at(time_s, CountKind::Extra, 1, changed, place);
                edges.events.push(extra);
            }
            open_extra = true;
            continue;
        };
        open_extra = false;
        if let Some((edge, was_forward)) = last {
            let on = if forward { 1 } else { -1 };
            // Turning back, the first edge is the last one again.
            let next = edge + if forward == was_forward { on } else { 0 };
            let lost = (rank - next) * on;
            if lost > 0 {
                // When the first of them would have come.
                let until_s = edges.seconds(row.ticks);
                let from_s = edges.time_s.last().copied().unwrap_or(until_s);
                let time_s = from_s + (until_s - from_s) / (lost + 1) as f64;
                let (count, channel) = (lost as i32, code.channel(next));
                let lost = CountEvent::at(time_s, CountKind::Lost, count, channel, next);
                edges.events.push(lost);
            }
        }
        edges.push(row.ticks, rank, forward, fresh);
        last = Some((rank, forward));
    }
    if let Some(state) = index_state {
        let zs = rows.windows(2).filter_map(|pair| {
            let changed = pair[0].levels.z() != pair[1].levels.z();
            changed.then(|| (pair[1].ticks as f64 * edges.tick_s, pair[1].levels.z()))
        });
        let zs: Vec<_> = zs.collect();
        anchor(edges, &zs, class_of(state).into());
    }
    edges.events.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
}

/// One pass of the index, high from one place to another.
#[derive(Clone, Copy, Debug)]
struct Pass {
    time_s: f64,
    ends: [f64; 2],
}

impl Pass {
    fn middle(&self) -> f64 {
        0.5 * (self.ends[0] + self.ends[1])
    }

    /// The sector of a class that lies most within the pass.
    fn sector(&self, class: i64, classes: i64) -> i64 {
        let middle = (self.middle() - 0.5).round() as i64;
        let within = |sector: i64| {
            let ends = [sector as f64, sector as f64 + 1.0];
            self.ends[1].min(ends[1]) - self.ends[0].max(ends[0])
        };
        let near = middle - classes..=middle + classes;
        near.filter(|sector| (sector - class).rem_euclid(classes) == 0)
            .max_by(|a, b| within(*a).total_cmp(&within(*b)))
            .unwrap_or(middle)
    }
}

/// Makes places those of the disc, by the first pass of the index, and books where later ones stand elsewhere. `zs` are the
/// changes of Z; a high Z in the sector of `class` marks line 0.
fn anchor(edges: &mut Edges, zs: &[(f64, bool)], class: i64) {
    let passes = passes(edges, zs);
    let Some(first) = passes.first() else {
        return;
    };
    let classes = i64::from(edges.classes);
    let origin = first.sector(class, classes) - class;
    edges.place.iter_mut().for_each(|place| *place -= origin);
    edges.events.iter_mut().for_each(|e| e.place -= origin);
    edges.anchored = true;

    let turn = f64::from(edges.grid_edges);
    let (mut stands, mut after_s) = (first.middle(), first.time_s);
    for pass in &passes[1..] {
        let way = pass.middle() - stands;
        let off = (way - turn * (way / turn).round()).round();
        if off != 0.0 {
            edges.events.push(CountEvent {
                kind: CountKind::IndexSlip,
                time_s: pass.time_s,
                after_s,
                place: pass.middle().round() as i64 - origin,
                channel: Levels::Z,
                edges: off as i32,
            });
            stands = pass.middle();
        }
        after_s = pass.time_s;
    }
}

/// Passes with both ends in one direction; their ends are places between edges, by time.
fn passes(edges: &Edges, zs: &[(f64, bool)]) -> Vec<Pass> {
    let mut next = 0;
    let mut risen: Option<(f64, bool)> = None;
    let mut passes = Vec::new();
    for &(time_s, level) in zs {
        while edges.time_s.get(next).is_some_and(|&t| t < time_s) {
            next += 1;
        }
        let at = next.checked_sub(1).and_then(|last| {
            let there = |n: usize| Some((*edges.time_s.get(n)?, *edges.place.get(n)? as f64));
            let ((from_s, from), (until_s, until)) = (there(last)?, there(next)?);
            let part = (time_s - from_s) / (until_s - from_s).max(f64::MIN_POSITIVE);
            // Where it turns round between two edges, nothing says how far it went.
            let way = edges.forward[next];
            (edges.forward[last] == way).then_some((from + (until - from) * part, way))
        });
        if level {
            risen = at;
        } else if let (Some((start, way)), Some((end, same))) = (risen.take(), at)
            && way == same
        {
            passes.push(Pass {
                time_s,
                ends: [start.min(end), start.max(end)],
            });
        }
    }
    passes
}

//! Where a shaft with one channel turned round.
//!
//! Rises and falls take turns whichever way the shaft goes, so one channel does not show a reversal: the twin says that there is one. From
//! the last edge P before it on, the edge counted as p is the disc's S - p, with S = 2 P + 1. No disc is quite even: what each edge is off
//! the middle of its neighbours comes again in reverse, mirrored, and says S whatever the shaft did in between. Where a ripple may have
//! sent it to and fro, the edges that may have been passed again are left out.

use std::f64::consts::TAU;
use std::ops::Range;

use thiserror::Error;

use super::grid::TURNS;
use super::{Edges, SURE, Stretch, Unused, median};
use crate::diagnose::noise::FAR;
use crate::twin::{Drive, Twin};

/// Share of the top speed below which a shaft may stop if it loses speed fast enough; at a tenth of that it does.
const MAY_STOP: f64 = 0.2;
/// Part of the top speed from which on an edge's place between its neighbours is the disc's.
const FAST: f64 = 0.3;
/// Edges that are to be seen again: so many make up for what a few say by chance.
const AGAIN: usize = 50;
/// How much slower than two teeth before and after, in logarithms of both together, a shaft may have stopped in between.
const FALLS: f64 = 0.5;
/// How many times as much energy as a ripple can take a shaft is to have: friction takes some as well.
const OVER: f64 = 3.0;

/// Why it is not known where a shaft turned round.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Undecided {
    /// The reverse shows other flanks than forward.
    #[error("it reverses, and of its teeth only one flank is recorded")]
    OneFlank,
    /// Between stops there is too little.
    #[error(
        "it stops, after which one channel does not show which way it goes on, and no stretch between stops is long enough"
    )]
    Stops,
    /// No two edges differ enough.
    #[error(
        "it reverses, which one channel does not show, and its edges are too alike to say where"
    )]
    Alike,
}

/// Edges of one channel with the reversal in them that their twin has; any others as they are.
///
/// # Errors
/// [`Undecided`] where the recording does not say where it turned round.
pub fn turned(mut edges: Edges, twin: &Twin) -> Result<Edges, Undecided> {
    if edges.classes <= 2 && twin.drive == Drive::Unknown {
        return Ok(between_stops(edges));
    }
    if edges.classes > 2 || !twin.drive.reverses() || edges.forward.contains(&false) {
        return Ok(edges);
    }
    if edges.classes < 2 {
        return Err(Undecided::OneFlank);
    }
    let way = Way::of(&edges).ok_or(Undecided::Alike)?;
    let last = way.last_forward().ok_or(Undecided::Alike)?;
    let left_out = way.doubtful(last, still_rad_s(twin));
    let Range { start, mut end } = left_out.unwrap_or_else(|| {
        let split = edges.place.partition_point(|place| *place <= last);
        split..split
    });
    // Where edges are left out, it must not seem to go on from edge to edge.
    let apart = |end: usize| (2 * last + 1 - edges.place[end] - edges.place[start - 1]).abs();
    while end > start && end + 1 < edges.len() && apart(end) <= i64::from(edges.classes) {
        end += 1;
    }
    edges.mirror(end, last);
    edges.drain(start..end);
    Ok(edges)
}

/// The longest stretch in which the shaft did not stop: where nobody declared how it is driven, it may go on either way.
fn between_stops(mut edges: Edges) -> Edges {
    let stops = stops(&edges);
    let mut from = 0;
    let mut longest = 0..0;
    for end in stops.into_iter().chain([edges.len()]) {
        // The first one goes forward, and begins where the twin says: another one has to be twice as long.
        let enough = if longest.start == 0 { 2 } else { 1 };
        if end.saturating_sub(from) > enough * longest.len() {
            longest = from..end;
        }
        from = end + 1;
    }
    if longest.len() == edges.len() {
        return edges;
    }
    let (first, end) = (longest.start, longest.end);
    let (starts_s, ends_s) = (edges.time_s[first], edges.time_s[end - 1]);
    let (after, last_s) = (edges.len() - end, edges.time_s[edges.len() - 1]);
    edges.drain(end..edges.len());
    edges.drain(0..first);
    let ends = [(first, edges.begins_s, starts_s), (after, ends_s, last_s)];
    for (rows, from_s, until_s) in ends.into_iter().filter(|(rows, ..)| *rows > 0) {
        // What is left out with it needs no reason of its own.
        let inside = |own: &Stretch| own.from_s >= from_s && own.until_s <= until_s;
        let own = edges.unused.iter().filter(|own| inside(own));
        let rows = rows + own.map(|own| own.rows).sum::<usize>();
        edges.unused.retain(|own| !inside(own));
        edges.unused.push(Stretch {
            from_s,
            until_s,
            rows,
            why: Unused::EitherWay,
        });
    }
    edges.unused.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
    edges
}

impl Edges {
    /// Whether nothing shows which way these edges were crossed.
    #[must_use]
    pub fn either_way(&self) -> bool {
        let start_s = self.time_s.first().copied().unwrap_or(0.0);
        let mut before = self.unused.iter();
        before.any(|stretch| stretch.why == Unused::EitherWay && stretch.from_s < start_s)
    }

    /// The same crossed the other way.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let mut other = self.clone();
        let first = self.place.first().copied().unwrap_or(0);
        other.mirror(0, first - first.rem_euclid(2));
        other
    }

    /// Counts edges from a number on in reverse, from the last place that was passed forward.
    fn mirror(&mut self, from: usize, last: i64) {
        for at in from..self.len() {
            self.place[at] = 2 * last + 1 - self.place[at];
            self.forward[at] = false;
        }
    }

    /// Leaves edges out.
    fn drain(&mut self, range: Range<usize>) {
        // Where it may have turned to and fro, a long time between edges says nothing of edges between them.
        let from_s = range
            .start
            .checked_sub(1)
            .map_or(f64::NEG_INFINITY, |at| self.time_s[at]);
        let until_s = self.time_s.get(range.end).copied().unwrap_or(f64::INFINITY);
        self.events
            .retain(|event| event.time_s <= from_s || event.time_s >= until_s);
        self.time_s.drain(range.clone());
        self.place.drain(range.clone());
        self.forward.drain(range.clone());
        self.fresh.drain(range);
    }
}

/// Edges at which the shaft may have stopped: where it is slow, and the square of its speed, which changes evenly along the angle under
/// a torque, falls to nearly none and rises again. What comes again at a place of each turn is the wheel's or a ripple's.
fn stops(edges: &Edges) -> Vec<usize> {
    // From each edge on over one tooth, so that teeth and gaps of other widths do not show.
    let tooth = edges.classes as usize;
    let count = edges.time_s.len().saturating_sub(tooth);
    let speed = |at: usize| {
        let way = (edges.place[at + tooth] - edges.place[at]) as f64;
        way / (edges.time_s[at + tooth] - edges.time_s[at]).max(f64::MIN_POSITIVE)
    };
    let speeds: Vec<f64> = (0..count).map(speed).collect();
    let mut quick = speeds.clone();
    quick.sort_by(|a, b| b.total_cmp(a));
    // A few intervals come out too short.
    let Some(top) = quick.get(count / 20) else {
        return Vec::new();
    };
    let by = 2 * tooth;
    let turn = i64::from(edges.grid_edges);
    let place = |at: usize| edges.place[at].rem_euclid(turn) as usize;
    let gains = speeds.windows(by + 1);
    let gains: Vec<f64> = gains.map(|pair| (pair[by] / pair[0]).ln()).collect();
    let mut of_place = vec![Vec::new(); turn as usize];
    for (at, gain) in gains.iter().enumerate() {
        of_place[place(at)].push(*gain);
    }
    let usual = of_place.into_iter().map(|gains| {
        let comes_again = gains.len() >= TURNS;
        median(gains).filter(|_| comes_again).unwrap_or(0.0)
    });
    let usual: Vec<f64> = usual.collect();
    // From an edge on, two teeth further, beside what is usual there.
    let gained = |at: usize| gains.get(at).map_or(0.0, |gain| gain - usual[place(at)]);
    (0..count)
        .filter(|&at| {
            let lost = at.checked_sub(by).map_or(0.0, gained);
            let falls = speeds[at] < MAY_STOP * top && gained(at) - lost > FALLS;
            falls || speeds[at] < MAY_STOP / 10.0 * top
        })
        .map(|at| at + tooth / 2)
        .collect()
}

/// Speed, rad/s, below which the twin's ripple may turn the shaft round; 0 where the drive is stronger.
fn still_rad_s(twin: &Twin) -> f64 {
    let ripples = twin.ripple.iter().chain(&twin.gear_mesh);
    let torques = ripples.filter_map(|ripple| Some((ripple.order, ripple.torque_n_m?.abs())));
    let inertia = twin.shaft.inertia_or_one();
    // Acceleration at the most, and half the square of the speed that the potential gives from its middle to its top.
    let (hardest, thrown) = torques.fold((0.0, 0.0), |(hardest, thrown), (order, torque)| {
        (
            hardest + torque / inertia,
            thrown + torque / inertia / order,
        )
    });
    let slows = match twin.drive {
        Drive::Ramp {
            from_r_min,
            to_r_min,
            over_s,
        } => (to_r_min - from_r_min).abs() * (TAU / 60.0) / over_s,
        Drive::RunDown { .. } => twin.friction_n_m(0.0).abs() / inertia,
        _ => return 0.0,
    };
    if hardest < slows {
        return 0.0;
    }
    // From the top of its potential to the bottom.
    (4.0 * OVER * thrown).sqrt()
}

/// A recording's edges, counted forward.
struct Way<'a> {
    edges: &'a Edges,
    /// Edges a turn.
    turn: i64,
    /// Number of the edge before the longest interval.
    longest: usize,
    /// For each edge how far it is off the middle of its neighbours, as a share of their way; none where it is slow.
    off: Vec<Option<f64>>,
}

impl<'a> Way<'a> {
    fn of(edges: &'a Edges) -> Option<Self> {
        let after = |at: usize| edges.time_s[at + 1] - edges.time_s[at];
        let next = |at: usize| edges.place[at + 1] == edges.place[at] + 1;
        let intervals = 0..edges.len().checked_sub(1)?;
        let longest = intervals.clone().filter(|at| next(*at));
        let longest = longest.max_by(|a, b| after(*a).total_cmp(&after(*b)))?;
        let mut quick: Vec<f64> = intervals.map(after).collect();
        quick.sort_by(f64::total_cmp);
        let slow = quick[quick.len() / 10] / FAST;
        let off = (0..edges.len()).map(|at| {
            if at == 0 || at + 1 >= edges.len() || !next(at - 1) || !next(at) {
                return None;
            }
            let (before, after) = (after(at - 1), after(at));
            (before.max(after) < slow).then(|| before / (before + after) - 0.5)
        });
        Some(Self {
            edges,
            turn: edges.grid_edges.into(),
            longest,
            off: off.collect(),
        })
    }

    fn edge(&self, place: i64) -> usize {
        place.rem_euclid(self.turn) as usize
    }

    /// Place of the last edge before it turned round, as one reversal would have it.
    fn last_forward(&self) -> Option<i64> {
        let (forward, reverse) = self.off.split_at(self.longest + 1);
        let from = forward.iter().rposition(Option::is_some)?;
        let until = self.longest + 1 + reverse.iter().position(Option::is_some)?;
        let places = &self.edges.place;
        let mut means = vec![(0.0, 0.0); self.turn as usize];
        for (place, off) in places.iter().zip(forward) {
            if let Some(off) = off {
                let (sum, count) = &mut means[self.edge(*place)];
                *sum += off;
                *count += 1.0;
            }
        }
        let mean = |place: i64| {
            let (sum, count) = means[self.edge(place)];
            (count > 1.0).then(|| sum / count)
        };
        let here = places.iter().zip(forward);
        let squares = here.filter_map(|(place, off)| Some((*off)? - mean(*place)?));
        let (sum, number) = squares.fold((0.0, 0.0), |(s, n), d| (s + d * d, n + 1.0));
        let variance = 2.0 * sum / f64::max(number, 1.0) + 1e-12;
        let against = |last: i64| {
            let again = places[until..].iter().zip(&self.off[until..]);
            let each = again.filter_map(|(place, off)| {
                // What is ahead forward is behind in reverse.
                let apart = -(*off)? - mean(2 * last + 1 - place)?;
                Some((apart * apart / variance).min(FAR * FAR))
            });
            let (sum, number) = each.fold((0.0, 0), |(s, n), d| (s + d, n + 1));
            (number >= AGAIN).then_some(0.5 * sum)
        };
        // Half a turn on, it would be the same edges a turn further, which only matters to a course that goes on.
        let (turn, around) = (places[self.longest], self.turn / 4);
        let places = places[from].max(turn - around + 1)..=places[until].min(turn + around);
        let mut tried: Vec<(i64, f64)> = places
            .filter_map(|last| Some((last, against(last)?)))
            .collect();
        tried.sort_by(|a, b| a.1.total_cmp(&b.1));
        let best = tried.first()?;
        let next = tried.get(1).map_or(f64::INFINITY, |next| next.1);
        (next - best.1 > SURE).then_some(best.0)
    }

    /// Marks between which a ripple may have sent the shaft to and fro; none where it turned round once.
    fn doubtful(&self, last: i64, still_rad_s: f64) -> Option<Range<usize>> {
        let after = |at: usize| self.edges.time_s[at + 1] - self.edges.time_s[at];
        let turn = self.longest;
        let intervals = 0..self.edges.len() - 1;
        let others = intervals.clone().filter(|at| at.abs_diff(turn) > 1);
        // One that is half as long may be a reversal too.
        let once = self.edges.place[turn] == last
            && others.map(after).fold(0.0, f64::max) < 0.5 * after(turn);
        if still_rad_s == 0.0 || once {
            return None;
        }
        let step = TAU / self.turn as f64;
        let mut slow = intervals.filter(|at| step / after(*at) < still_rad_s);
        let first = slow.next()?.max(1);
        let end = slow.next_back().unwrap_or(first) + 1;
        (end + 1 < self.edges.len()).then_some(first..end)
    }
}

//! Wheels: one channel, whose direction cannot be seen and whose turn is known by its gaps.
//!
//! The search runs along edges of one kind, the leading or the trailing ones of teeth, whichever come more evenly: how wide a tooth is,
//! and how much wider beside a gap, plays no part. The other edges stand between them.

use quadcal::edge::Levels;

use super::follow::{Seen, Way, follow};
use super::grid::{Grid, Sight};
use super::{CountEvent, CountKind, Edges, Stretch, Unused, median};
use crate::diagnose::scan::SURE;
use crate::recording::Row;

/// Intervals of bounces are this much shorter than the pitch beside them.
const BOUNCE: f64 = 0.125;

/// The way along the edges that lead the search.
struct Lead<'a> {
    ticks: &'a [u64],
    grid: Grid,
    way: Way,
}

/// Edges of the other kind, and how they stand between those that lead.
struct Others<'a> {
    ticks: &'a [u64],
    /// The first one behind lead edge n is n plus this.
    ahead: usize,
    /// Whether the lead edges are leading edges of teeth, so that the other edge behind is of the same tooth.
    leading: bool,
    /// From a tooth's lead edge to its other edge, in pitches, negative where that is before.
    width: f64,
}

/// Places pulses, one a tooth.
pub(super) fn place_pulses(present: &[bool], rows: &[Row], edges: &mut Edges) {
    let ticks: Vec<u64> = rows.iter().map(|row| row.ticks).collect();
    let lead = Lead::new(present, &ticks);
    assemble(&lead, None, edges, |tooth, _| tooth);
    finish(&lead, edges);
}

/// Places both edges of teeth.
pub(super) fn place(present: &[bool], rows: &[Row], edges: &mut Edges) {
    let kinds = both(rows);
    let [falls, rises] = kinds.each_ref().map(|ticks| Lead::new(present, ticks));
    let rising = rises.fit() > falls.fit();
    let lead = if rising { rises } else { falls };
    let others = Others::new(&lead, &kinds[usize::from(!rising)], rising);
    let inverted = others.leading != rising;
    edges.inverted = inverted;
    assemble(&lead, Some(&others), edges, |tooth, is_lead| {
        match (is_lead == rising, inverted) {
            (true, false) => 2 * tooth,
            (true, true) => 2 * tooth + 2,
            (false, _) => 2 * tooth + 1,
        }
    });
    finish(&lead, edges);
}

/// Times at which the channel falls, and at which it rises.
pub(super) fn both(rows: &[Row]) -> [Vec<u64>; 2] {
    let of = |rises: bool| {
        let changes = |pair: &&[Row]| pair[0].levels.a() != rises && pair[1].levels.a() == rises;
        let pairs = rows.windows(2).filter(changes);
        pairs.map(|pair| pair[1].ticks).collect()
    };
    [of(false), of(true)]
}

impl<'a> Lead<'a> {
    fn new(present: &[bool], ticks: &'a [u64]) -> Self {
        let along = |grid: Grid| {
            let class = Some(0);
            let sights = ticks.iter().map(|&ticks| Sight { ticks, class });
            let mut way = follow(&grid, None, sights);
            drop_short(&mut way.seen, grid.ranks());
            Self { ticks, grid, way }
        };
        let first = along(Grid::teeth(present));
        // A second look knows what the turn is like: edges beside gaps that are out of place, and torques locked to it.
        let steps = first.steps();
        let stamped = steps.map(|step| step.map(|(n, rank)| (ticks[n], rank)));
        match first.grid.measure(stamped).map(along) {
            Some(second) if second.way.score > first.way.score => second,
            _ => first,
        }
    }

    /// Mean log likelihood of an edge.
    fn fit(&self) -> f64 {
        self.way.score / self.ticks.len().max(1) as f64
    }

    /// Pairs of edges that follow each other: observation and rank of both.
    fn steps(&self) -> impl Iterator<Item = [(usize, i64); 2]> {
        let mut last = None;
        let seen = self.way.seen.iter().enumerate();
        seen.filter_map(move |(n, seen)| {
            let Seen::Edge { rank, fresh, .. } = *seen else {
                return None;
            };
            let step = last.filter(|_| !fresh).map(|last| [last, (n, rank)]);
            last = Some((n, rank));
            step
        })
    }

    /// Ticks a pitch about an observation, of the nearest step that has one.
    fn pitch(&self, at: usize) -> Option<f64> {
        let nearest = self.steps().min_by_key(|[_, (n, _)]| n.abs_diff(at))?;
        let [(from, before), (until, after)] = nearest;
        let places = self.grid.place(after) - self.grid.place(before);
        Some((self.ticks[until] - self.ticks[from]) as f64 / places as f64)
    }
}

/// Drops what was met again for less than a turn: so few edges look like any wheel. The longest piece stays.
fn drop_short(seen: &mut [Seen], ranks: i64) {
    let least = ranks.min(longest(seen));
    for piece in seen.chunk_by_mut(goes_on) {
        if span(piece) < least {
            piece.fill(Seen::Astray);
        }
    }
}

/// Ranks of the longest piece.
fn longest(seen: &[Seen]) -> i64 {
    seen.chunk_by(goes_on).map(span).max().unwrap_or(0)
}

/// Whether two observations are of one piece, in which the count goes on.
fn goes_on(first: &Seen, second: &Seen) -> bool {
    let broken = matches!(second, Seen::Astray | Seen::Edge { fresh: true, .. });
    *first != Seen::Astray && !broken
}

/// Ranks from a piece's first edge to its last.
fn span(piece: &[Seen]) -> i64 {
    let mut ranks = piece.iter().filter_map(|seen| match seen {
        Seen::Edge { rank, .. } => Some(*rank),
        _ => None,
    });
    let first = ranks.next();
    first.map_or(0, |first| ranks.next_back().unwrap_or(first) - first)
}

impl<'a> Others<'a> {
    fn new(lead: &Lead, ticks: &'a [u64], rising: bool) -> Self {
        let ahead = match (lead.ticks.first(), ticks.first()) {
            (Some(lead), Some(other)) => usize::from(other < lead),
            _ => 0,
        };
        // Where in its interval an edge stands, over plain steps and over gaps.
        let mut shares = [Vec::new(), Vec::new()];
        for [(from, before), (until, after)] in lead.steps() {
            if until == from + 1
                && after == before + 1
                && let Some(&at) = ticks.get(from + ahead)
            {
                let span = (lead.ticks[until] - lead.ticks[from]) as f64;
                let share = at.saturating_sub(lead.ticks[from]) as f64 / span.max(1.0);
                let gap = lead.grid.place(after) - lead.grid.place(before) > 1;
                shares[usize::from(gap)].push(share);
            }
        }
        let [plain, gap] = shares.map(median);
        // What is long over a gap is no tooth. Where neither is clearly longer, teeth are high.
        let leading = match gap {
            Some(share) if share < 0.4 => true,
            Some(share) if share > 0.6 => false,
            _ => rising,
        };
        let share = plain.unwrap_or(0.5);
        Self {
            ticks,
            ahead,
            leading,
            width: if leading { share } else { share - 1.0 },
        }
    }

    /// The other edge in a step: which tooth's, and when. Of several, the one that stands most nearly where a tooth's should.
    fn within(&self, lead: &Lead, step: [(usize, i64); 2]) -> Option<(i64, u64)> {
        let [(from, before), (until, after)] = step;
        let [start, end] = [lead.grid.place(before), lead.grid.place(after)];
        let span = (lead.ticks[until] - lead.ticks[from]) as f64;
        let first = before + i64::from(!self.leading);
        let teeth = first..first + after - before;
        let mut best = (f64::INFINITY, None);
        for &at in self.ticks.get(from + self.ahead..until + self.ahead)? {
            let share = at.saturating_sub(lead.ticks[from]) as f64 / span.max(1.0);
            for tooth in teeth.clone() {
                let way = (lead.grid.place(tooth) - start) as f64 + self.width;
                let off = (share - way / (end - start) as f64).abs();
                if off < best.0 {
                    best = (off, Some((tooth, at)));
                }
            }
        }
        best.1
    }
}

/// Writes out edges, and what was lost or too many; `on_grid` gives the place of a tooth's lead or other edge.
fn assemble(
    lead: &Lead,
    others: Option<&Others>,
    edges: &mut Edges,
    on_grid: impl Fn(i64, bool) -> i64,
) {
    let each = edges.classes as i32;
    let mut last: Option<(usize, i64)> = None;
    for (n, (&ticks, seen)) in lead.ticks.iter().zip(&lead.way.seen).enumerate() {
        let event =
            |kind, time_s, place, edges| CountEvent::at(time_s, kind, edges, Levels::A, place);
        match *seen {
            Seen::Edge { rank, fresh, .. } => {
                if let Some((from, before)) = last.filter(|_| !fresh) {
                    let lost = rank - before - 1;
                    if lost > 0 {
                        let ranks = [before, before + 1, rank];
                        let [start, first, end] = ranks.map(|rank| lead.grid.place(rank));
                        let part = (first - start) as f64 / (end - start) as f64;
                        let [from_s, until_s] = [lead.ticks[from], ticks].map(|t| edges.seconds(t));
                        let time_s = from_s + part * (until_s - from_s);
                        let place = on_grid(first, true);
                        let lost = event(CountKind::Lost, time_s, place, each * lost as i32);
                        edges.events.push(lost);
                    }
                    let other = others.and_then(|o| o.within(lead, [(from, before), (n, rank)]));
                    if let Some((tooth, at)) = other {
                        edges.push(at, on_grid(lead.grid.place(tooth), false), true, false);
                    }
                }
                // The recording may begin with an edge of the other kind.
                let before = others.filter(|others| n == 0 && others.ahead > 0);
                if let Some((others, &at)) = before.and_then(|o| Some((o, o.ticks.first()?))) {
                    let tooth = lead.grid.place(rank - i64::from(others.leading));
                    edges.push(at, on_grid(tooth, false), true, fresh);
                }
                edges.push(ticks, on_grid(lead.grid.place(rank), true), true, fresh);
                last = Some((n, rank));
            }
            Seen::Extra => {
                let place = edges.place.last().copied().unwrap_or(0);
                let extra = event(CountKind::Extra, edges.seconds(ticks), place, each);
                edges.events.push(extra);
            }
            Seen::Astray => {}
        }
    }
    // And end with one.
    if let (Some((n, rank)), Some(others)) = (last, others)
        && n + 1 == lead.ticks.len()
        && let Some(&at) = others.ticks.get(n + others.ahead)
    {
        let tooth = lead.grid.place(rank + i64::from(!others.leading));
        edges.push(at, on_grid(tooth, false), true, false);
    }
}

/// Says what was not used, and how good the rest is.
fn finish(lead: &Lead, edges: &mut Edges) {
    let (seen, ticks) = (&lead.way.seen, lead.ticks);
    edges.fit = lead.fit();
    let turn = lead.grid.ranks();
    let whole = longest(seen) >= turn;
    edges.anchored = lead.grid.starts() > 1 && (whole || 2.0 * lead.way.lead > SURE);
    let each = edges.classes as usize;
    let mut unused = Vec::new();
    let mut at = 0;
    for run in seen.chunk_by(|a, b| (*a == Seen::Astray) == (*b == Seen::Astray)) {
        let (from, until) = (at, at + run.len());
        at = until;
        if run[0] == Seen::Astray {
            let intervals = ticks[from..until].windows(2);
            let typical = median(intervals.map(|pair| (pair[1] - pair[0]) as f64).collect());
            let pitch = lead.pitch(until);
            let short = typical
                .zip(pitch)
                .is_some_and(|(t, pitch)| t < BOUNCE * pitch);
            let why = if short {
                Unused::Bounces
            } else {
                Unused::OffPattern
            };
            unused.push(Stretch {
                from_s: edges.seconds(ticks[from]),
                until_s: edges.seconds(ticks[until - 1]),
                rows: each * run.len(),
                why,
            });
        }
    }
    edges.unused = unused;
}

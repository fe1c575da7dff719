//! Where a shaft with one channel turned round.
//!
//! Rises and falls take turns whichever way the shaft goes, so one channel does not show a reversal: the twin says that there is one. From
//! the last edge P before it on, the edge counted as p is the disc's S - p, with S = 2 P + 1. No disc is quite even: what each edge is off
//! the middle of its neighbours comes again in reverse, mirrored, and says S whatever the shaft did in between. Where a ripple may have
//! sent it to and fro, the edges that may have been passed again are left out.

use std::f64::consts::TAU;

use thiserror::Error;

use super::{Edges, Stretch, Unused};
use crate::twin::{Drive, Twin};

/// Share of the top speed below which a shaft may stop, and below which it does; how many teeth on it would, as it slows down or as it
/// gains speed.
const MAY_STOP: f64 = 0.2;
const STOPS: f64 = 0.02;
const TEETH: f64 = 3.0;
/// How many times as long as the first stretch another one has to be.
const FIRST: usize = 2;
/// Share of intervals that are shorter than those of the top speed.
const TOP: f64 = 0.05;

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

/// Part of the top speed from which on an edge's place between its neighbours is the disc's.
const FAST: f64 = 0.3;
/// Evidence for the best place over the next one, as a difference of logarithms of likelihood.
const SURE: f64 = 25.0;
/// What one edge may say against a place, variances.
const FAR: f64 = 16.0;
/// Edges that are to be seen again.
const AGAIN: usize = 50;
/// How much more energy a shaft is to have than a ripple can take.
const OVER: f64 = 3.0;
/// Part of the longest interval above which another one may be a reversal too.
const NEARLY: f64 = 0.5;

/// An edge, counted forward.
#[derive(Clone, Copy, Debug)]
struct Mark {
    time_s: f64,
    place: i64,
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
    let marks = edges.time_s.iter().zip(&edges.place);
    let marks: Vec<Mark> = marks
        .map(|(&time_s, &place)| Mark { time_s, place })
        .collect();
    let way = Way::of(&marks, edges.grid_edges.into()).ok_or(Undecided::Alike)?;
    let last = way.last_forward().ok_or(Undecided::Alike)?;
    let left_out = way.doubtful(last, still_rad_s(twin));
    let (start, mut end) = match left_out {
        Some(range) => (range.start, range.end),
        None => {
            let split = marks.partition_point(|mark| mark.place <= last);
            (split, split)
        }
    };
    // Where edges are left out, it must not seem to go on from edge to edge.
    let apart = |end: usize| (2 * last + 1 - marks[end].place - marks[start - 1].place).abs();
    while end > start && end + 1 < marks.len() && apart(end) <= i64::from(edges.classes) {
        end += 1;
    }
    for place in &mut edges.place[end..] {
        *place = 2 * last + 1 - *place;
    }
    edges.forward[end..].fill(false);
    edges.class = edges
        .place
        .iter()
        .map(|place| place.rem_euclid(edges.classes.into()) as u8)
        .collect();
    edges.time_s.drain(start..end);
    edges.place.drain(start..end);
    edges.class.drain(start..end);
    edges.forward.drain(start..end);
    edges.fresh.drain(start..end);
    Ok(edges)
}

/// The longest stretch in which the shaft did not stop: where nobody declared how it is driven, it may go on either way.
fn between_stops(edges: Edges) -> Edges {
    let stops = stops(&edges);
    let mut from = 0;
    let mut longest = 0..0;
    for end in stops.into_iter().chain([edges.time_s.len()]) {
        // The first one goes forward, and begins where the twin says.
        let enough = if longest.start == 0 { FIRST } else { 1 };
        if end.saturating_sub(from) > enough * longest.len() {
            longest = from..end;
        }
        from = end + 1;
    }
    if longest.len() == edges.time_s.len() {
        return edges;
    }
    let (first, last) = (longest.start, longest.end - 1);
    let (starts_s, ends_s) = (edges.time_s[first], edges.time_s[last]);
    let mut used = edges.clone();
    used.time_s = edges.time_s[longest.clone()].to_vec();
    used.place = edges.place[longest.clone()].to_vec();
    used.class = edges.class[longest.clone()].to_vec();
    used.forward = edges.forward[longest.clone()].to_vec();
    used.fresh = edges.fresh[longest.clone()].to_vec();
    used.events
        .retain(|event| (starts_s..=ends_s).contains(&event.time_s));
    let ends = [
        (0..first, edges.begins_s, starts_s),
        (
            last + 1..edges.time_s.len(),
            ends_s,
            edges.time_s[edges.time_s.len() - 1],
        ),
    ];
    for (rows, from_s, until_s) in ends {
        if !rows.is_empty() {
            used.unused.push(Stretch {
                from_s,
                until_s,
                rows: rows.len(),
                why: Unused::EitherWay,
            });
        }
    }
    used.unused.sort_by(|a, b| a.from_s.total_cmp(&b.from_s));
    used
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
        let last = 2 * self
            .place
            .first()
            .map_or(0, |first| first - first.rem_euclid(2))
            + 1;
        for place in &mut other.place {
            *place = last - *place;
        }
        let classes = i64::from(self.classes);
        let class = other
            .place
            .iter()
            .map(|place| place.rem_euclid(classes) as u8);
        other.class = class.collect();
        other.forward.fill(false);
        other
    }
}

/// Edges at which the shaft may have stopped: where it is slow, and the square of its speed, which falls evenly along the angle under a
/// torque, would be none a few teeth on.
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
    let Some(top) = quick.get((TOP * count as f64) as usize) else {
        return Vec::new();
    };
    let by = 2 * tooth;
    let near = |at: usize, beside: Option<&f64>| {
        let gained = beside.map_or(0.0, |beside| beside * beside - speeds[at] * speeds[at]);
        gained > 0.0 && speeds[at] * speeds[at] / gained * (by as f64) < TEETH * tooth as f64
    };
    (0..count)
        .filter(|&at| {
            let before = at.checked_sub(by).and_then(|before| speeds.get(before));
            let slow = speeds[at] < MAY_STOP * top;
            speeds[at] < STOPS * top || slow && (near(at, before) || near(at, speeds.get(at + by)))
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
    marks: &'a [Mark],
    edges: i64,
    /// Number of the mark before the longest interval.
    longest: usize,
    /// For each mark how far it is off the middle of its neighbours, as a share of their way; none where it is slow.
    off: Vec<Option<f64>>,
}

impl<'a> Way<'a> {
    fn of(marks: &'a [Mark], edges: i64) -> Option<Self> {
        let after = |at: usize| marks[at + 1].time_s - marks[at].time_s;
        let next = |at: usize| marks[at + 1].place == marks[at].place + 1;
        let longest = (0..marks.len().checked_sub(1)?).filter(|at| next(*at));
        let longest = longest.max_by(|a, b| after(*a).total_cmp(&after(*b)))?;
        let mut quick: Vec<f64> = (0..marks.len() - 1).map(after).collect();
        quick.sort_by(f64::total_cmp);
        let slow = quick[quick.len() / 10] / FAST;
        let off = (0..marks.len()).map(|at| {
            if at == 0 || at + 1 >= marks.len() || !next(at - 1) || !next(at) {
                return None;
            }
            let (before, after) = (after(at - 1), after(at));
            (before.max(after) < slow).then(|| before / (before + after) - 0.5)
        });
        Some(Self {
            marks,
            edges,
            longest,
            off: off.collect(),
        })
    }

    fn edge(&self, place: i64) -> usize {
        usize::try_from(place.rem_euclid(self.edges)).unwrap_or(0)
    }

    /// Place of the last edge before it turned round, as one reversal would have it.
    fn last_forward(&self) -> Option<i64> {
        let (forward, reverse) = self.off.split_at(self.longest + 1);
        let from = forward.iter().rposition(Option::is_some)?;
        let until = self.longest + 1 + reverse.iter().position(Option::is_some)?;
        let count = self.edges as usize;
        let (mut sums, mut counts) = (vec![0.0; count], vec![0.0; count]);
        for (mark, off) in self.marks.iter().zip(forward) {
            if let Some(off) = off {
                sums[self.edge(mark.place)] += off;
                counts[self.edge(mark.place)] += 1.0;
            }
        }
        let means: Vec<Option<f64>> = (sums.iter().zip(&counts))
            .map(|(sum, count)| (*count > 1.0).then(|| sum / count))
            .collect();
        let here = self.marks.iter().zip(forward);
        let squares = here.filter_map(|(mark, off)| Some((*off)? - means[self.edge(mark.place)]?));
        let (sum, number) = squares.fold((0.0, 0.0), |(s, n), d| (s + d * d, n + 1.0));
        let variance = 2.0 * sum / f64::max(number, 1.0) + 1e-12;
        let against = |last: i64| {
            let again = self.marks[until..].iter().zip(&self.off[until..]);
            let each = again.filter_map(|(mark, off)| {
                // What is ahead forward is behind in reverse.
                let apart = -(*off)? - means[self.edge(2 * last + 1 - mark.place)]?;
                Some((apart * apart / variance).min(FAR))
            });
            let (sum, number) = each.fold((0.0, 0), |(s, n), d| (s + d, n + 1));
            (number >= AGAIN).then_some(0.5 * sum)
        };
        // Half a turn on, it would be the same edges a turn further, which only matters to a course that goes on.
        let (turn, around) = (self.marks[self.longest].place, self.edges / 4);
        let places = self.marks[from].place.max(turn - around + 1)
            ..=self.marks[until].place.min(turn + around);
        let mut tried: Vec<(i64, f64)> = places
            .filter_map(|last| Some((last, against(last)?)))
            .collect();
        tried.sort_by(|a, b| a.1.total_cmp(&b.1));
        let best = tried.first()?;
        let next = tried.get(1).map_or(f64::INFINITY, |next| next.1);
        (next - best.1 > SURE).then_some(best.0)
    }

    /// Marks between which a ripple may have sent the shaft to and fro; none where it turned round once.
    fn doubtful(&self, last: i64, still_rad_s: f64) -> Option<std::ops::Range<usize>> {
        let after = |at: usize| self.marks[at + 1].time_s - self.marks[at].time_s;
        let turn = self.longest;
        let others = (0..self.marks.len() - 1).filter(|at| at.abs_diff(turn) > 1);
        let once = self.marks[turn].place == last
            && others.map(after).fold(0.0, f64::max) < NEARLY * after(turn);
        if still_rad_s == 0.0 || once {
            return None;
        }
        let step = TAU / self.edges as f64;
        let mut slow = (0..self.marks.len() - 1).filter(|at| step / after(*at) < still_rad_s);
        let first = slow.next()?.max(1);
        let end = slow.next_back().unwrap_or(first) + 1;
        (end + 1 < self.marks.len()).then_some(first..end)
    }
}

//! Where a shaft stands, and the slips between its rests.

use std::f64::consts::TAU;

use crate::diagnose::run::Recorded;
use crate::diagnose::track::Mark;

/// An interval so many mean ones long is a standstill.
const STANDS: f64 = 15.0;
/// Slips needed.
pub const SLIPS_LEAST: usize = 4;
/// Edges that a slip needs.
pub const EDGES_LEAST: usize = 12;

/// Edges of a recording and where it stands.
pub struct Slips {
    /// When each edge came, s.
    pub times_s: Vec<f64>,
    /// Where it is on the grid.
    pub places: Vec<i64>,
    /// Direction of motion, 1 or -1.
    pub way: i64,
    /// First and last edge of each slip.
    pub ends: Vec<(usize, usize)>,
    /// Mean speed over whole cycles, rad/s.
    pub pull_rad_s: f64,
}

/// Marks along the motion of a recording and its standstills: the edges before and after each.
struct Standing<'a> {
    marks: Vec<&'a Mark>,
    way: i64,
    rests: Vec<(usize, usize)>,
}

fn standing(one: &Recorded) -> Option<Standing<'_>> {
    let longest = one.track.longest()?;
    let way = longest.direction;
    let along = one
        .track
        .stretches
        .iter()
        .filter(|stretch| stretch.direction == way);
    let marks: Vec<&Mark> = along.flat_map(|stretch| stretch.marks.iter()).collect();
    let (first, last) = (marks.first()?, marks.last()?);
    let edges = (last.place - first.place) * way;
    let mean_s = (last.time_s - first.time_s) / edges as f64;
    // A shaft may creep over an edge before it breaks away.
    let mut rests: Vec<(usize, usize)> = Vec::new();
    for after in
        (1..marks.len()).filter(|i| marks[*i].time_s - marks[i - 1].time_s > STANDS * mean_s)
    {
        match rests.last_mut() {
            Some(rest) if after - rest.1 < EDGES_LEAST => rest.1 = after,
            _ => rests.push((after - 1, after)),
        }
    }
    Some(Standing { marks, way, rests })
}

/// Whole slips of a recording, whatever they are like: from standstill to standstill.
#[must_use]
pub fn whole_slips(one: &Recorded) -> usize {
    standing(one).map_or(0, |standing| standing.rests.len().saturating_sub(1))
}

/// The slips of a recording; none where it does not stand and slip again and again.
#[must_use]
pub fn slips(one: &Recorded) -> Option<Slips> {
    let Standing { marks, way, rests } = standing(one)?;
    let (first, last) = (marks.first()?, marks.last()?);
    if rests.len() <= SLIPS_LEAST {
        return None;
    }
    let ends: Vec<(usize, usize)> = rests
        .windows(2)
        .map(|pair| (pair[0].1, pair[1].0))
        .collect();
    let mut lengths: Vec<usize> = ends.iter().map(|(from, to)| to - from + 1).collect();
    lengths.sort_unstable();
    let (low, usual, high) = (
        lengths[lengths.len() / 8],
        lengths[lengths.len() / 2],
        lengths[lengths.len() * 7 / 8],
    );
    let stood: f64 = rests
        .iter()
        .map(|rest| marks[rest.1].time_s - marks[rest.0].time_s)
        .sum();
    if usual < EDGES_LEAST || 2 * (high - low) > usual || stood < 0.1 * (last.time_s - first.time_s)
    {
        return None;
    }
    // Over whole cycles, from rest to rest.
    let (from, to) = (marks[rests[0].0], marks[rests[rests.len() - 1].0]);
    let turned = ((to.place - from.place) * way) as f64 / one.track.edges as f64 * TAU;
    Some(Slips {
        times_s: marks.iter().map(|mark| mark.time_s).collect(),
        places: marks.iter().map(|mark| mark.place).collect(),
        way,
        ends,
        pull_rad_s: turned / (to.time_s - from.time_s),
    })
}

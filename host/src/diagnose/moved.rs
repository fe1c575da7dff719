//! Which edges a finding moves: the channels that it is on, and of each its rises, its falls, or both.

use std::mem;

use super::basis::Basis;
use super::classes::Change;
use super::estimate::Estimate;

/// Standard errors that a channel's own size stands out by, where the finding is named on it.
const SURE: f64 = 3.0;
/// Part of the largest channel's size that another's has at the least, to be named beside it.
const PART: f64 = 0.02;

/// Edges that are moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moved {
    /// Their channel, or all.
    pub channel: Option<usize>,
    /// Rises only, falls only, or both.
    pub rises: Option<bool>,
}

impl Moved {
    /// Whether an edge is among them.
    #[must_use]
    pub fn has(self, change: Change) -> bool {
        change.on(self.channel) && self.rises.is_none_or(|rises| rises == change.rises)
    }
}

/// A channel's own size.
#[derive(Clone, Copy, Debug)]
struct Own {
    channel: Option<usize>,
    rises: Option<bool>,
    size: f64,
    variance: f64,
}

/// The edges that an estimate moves; none of what moves all alike.
#[must_use]
pub fn moved(estimate: &Estimate) -> Vec<Moved> {
    let bases = &estimate.hypothesis.bases;
    match bases[0] {
        Basis::Bump {
            channel: None,
            rises: None,
            ..
        } => Vec::new(),
        Basis::Bump { channel, rises, .. } => vec![Moved { channel, rises }],
        Basis::LevelTone { channel, .. } | Basis::LevelDrift { channel, .. } => {
            let rises = None;
            channel.map_or_else(Vec::new, |_| vec![Moved { channel, rises }])
        }
        Basis::Late { .. } => clear(&waiting(estimate)),
        Basis::RiseLate { .. }
        | Basis::FallEarly { .. }
        | Basis::Width { .. }
        | Basis::Shift { .. } => clear(&own(estimate)),
        _ => Vec::new(),
    }
}

/// The sizes of a finding that has one for each channel, or one for all. What is fitted beside it where the disc is not known is of
/// another kind.
fn own(estimate: &Estimate) -> Vec<Own> {
    let bases = &estimate.hypothesis.bases;
    let sized = bases.iter().zip(&estimate.sizes);
    let of_its_kind = |basis: &Basis| mem::discriminant(basis) == mem::discriminant(&bases[0]);
    let sized = sized
        .enumerate()
        .filter(|(_, (basis, _))| of_its_kind(basis));
    let each = sized.filter_map(|(at, (basis, &size))| {
        let (channel, rises) = match *basis {
            // What comes late is said, and a negative difference of rise and fall is a fall that does.
            Basis::RiseLate { channel } => (channel, Some(size > 0.0)),
            Basis::FallEarly { channel } => (Some(channel), Some(false)),
            Basis::Width { channel } => (channel, Some(false)),
            Basis::Shift { channel } | Basis::Late { channel } => (Some(channel), None),
            _ => return None,
        };
        let variance = estimate.covariance[(at, at)];
        Some(Own {
            channel,
            rises,
            size,
            variance,
        })
    });
    each.collect()
}

/// How long each channel waits for the soonest, as none comes before its edge.
fn waiting(estimate: &Estimate) -> Vec<Own> {
    let first = Own {
        channel: Some(0),
        rises: None,
        size: 0.0,
        variance: 0.0,
    };
    let mut all = vec![first];
    all.extend(own(estimate));
    let soonest = all.iter().copied().reduce(|a, b| match b.size < a.size {
        true => b,
        false => a,
    });
    let soonest = soonest.unwrap_or(first);
    for one in &mut all {
        one.size -= soonest.size;
        one.variance += soonest.variance;
    }
    all
}

/// Those that stand out; the largest always does.
fn clear(all: &[Own]) -> Vec<Moved> {
    let most = all.iter().map(|one| one.size.abs()).fold(0.0, f64::max);
    let clear = |one: &&Own| {
        let size = one.size.abs();
        size == most || (size > PART * most && size > SURE * one.variance.sqrt())
    };
    let moved = |one: &Own| Moved {
        channel: one.channel,
        rises: one.rises,
    };
    all.iter().filter(clear).map(moved).collect()
}

//! What comes again every turn, before anything is known of the noise.
//!
//! A disc that the twin does not know may err by far more than the shaft wanders. Noise that is fitted to all of it drowns the disc, and
//! what of the disc is drowned looks like torque at other speeds. The mean of each edge over the turns, each turn taken from its own
//! first mark to the next turn's, is the disc's whatever the noise is; more than the disc's, so it serves to guess the noise alone.

use super::seen::Seen;

/// Turns that a mean needs.
const TURNS_LEAST: f64 = 3.0;

/// A residual without what comes again every turn.
#[derive(Clone, Debug)]
pub struct Bare {
    /// Angles, rad, one an edge.
    pub angles: Vec<f64>,
    /// Mean number of turns that an edge's mean is of.
    pub turns: f64,
}

/// A residual without what comes again every turn; none where there are too few turns in one go.
#[must_use]
pub fn bare(seen: &Seen) -> Option<Bare> {
    let edges = usize::try_from(seen.edges).ok()?;
    let (mut sums, mut counts) = (vec![0.0; edges], vec![0.0; edges]);
    let mut first = 0_usize;
    while let Some(last) = first.checked_add(edges).filter(|last| *last < seen.len()) {
        let whole = seen.places[last].abs_diff(seen.places[first]) == edges as u64;
        let counted = !seen.readings[first + 1..=last]
            .iter()
            .any(|one| one.fresh || one.anew);
        if !(whole && counted) {
            first += 1;
            continue;
        }
        let (begins, ends) = (seen.angles[first], seen.angles[last]);
        let way = seen.theta(last) - seen.theta(first);
        let off = |at: usize| {
            let share = (seen.theta(at) - seen.theta(first)) / way;
            seen.angles[at] - begins - share * (ends - begins)
        };
        let mean = (first..last).map(off).sum::<f64>() / edges as f64;
        for at in first..last {
            sums[seen.edge(at)] += off(at) - mean;
            counts[seen.edge(at)] += 1.0;
        }
        first = last;
    }
    let turns = counts.iter().sum::<f64>() / edges as f64;
    if turns < TURNS_LEAST || counts.contains(&0.0) {
        return None;
    }
    let means: Vec<f64> = sums
        .iter()
        .zip(&counts)
        .map(|(sum, count)| sum / count)
        .collect();
    let each = seen.angles.iter().enumerate();
    Some(Bare {
        angles: each
            .map(|(at, angle)| angle - means[seen.edge(at)])
            .collect(),
        turns,
    })
}

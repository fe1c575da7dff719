//! What a report draws of a finding's mark: how far it moves edges, in the coordinate where it shows.
//!
//! In each bin the mark, as it passes the noise's filter, is fitted to what is left without it: a size of 1 is the finding as it was
//! found. So shaft wander, which is larger than most marks, is not in the way.

use super::basis::{Basis, Change, change_of};
use super::board::Bench;
use super::marks::Mark;
use super::seen::Seen;
use super::shown::FindingPlot;
use crate::mechanism::Mechanism;

/// Bins of a plot, at the most.
const BINS: usize = 60;
/// Part of what the most moved kind of edge is moved by from which on another kind is drawn with it.
const MOVED: f64 = 0.1;
/// Standard errors of the usual point from which on one says nothing.
const VAGUE: f64 = 20.0;

/// Sums over the edges of a bin.
#[derive(Clone, Copy, Default)]
struct Bin {
    /// White mark times the white residual with the mark in it.
    product: f64,
    /// White mark, squared.
    square: f64,
    /// The mark, urad.
    mark: f64,
    /// Coordinate.
    x: f64,
    count: f64,
}

impl Bin {
    /// Standard error of a point, urad.
    fn error(&self) -> f64 {
        (self.mark / self.count).abs() / self.square.sqrt()
    }
}

/// What x is, and of each edge: where it stands and in which bin; none outside of what is drawn.
struct Coordinate {
    label: String,
    places: Vec<Option<(f64, usize)>>,
}

/// A finding's mark on the recording that shows it best.
pub fn plot(bench: &Bench, mark: &Mark, mechanism: Mechanism) -> FindingPlot {
    let seen = &bench.seen;
    let Coordinate { label, places } = coordinate(seen, mark.basis);
    let drawn = drawn(seen, mark);
    let of = |at: usize| change_of(seen.class(at), seen.classes);
    let moved = |at: usize| 1e6 * sign_of(mark.basis, of(at)) * mark.angles[at];
    let edges = || (0..seen.len()).filter(|at| drawn[seen.class(*at)]);
    // Where a rhythm begins it moves the shaft as a whole; that is no part of the rhythm, and no recording shows it.
    let offset = match rhythmic(mark.basis) {
        true => edges().map(moved).sum::<f64>() / edges().count().max(1) as f64,
        false => 0.0,
    };
    let mut bins = vec![Bin::default(); BINS];
    for at in edges() {
        let Some((x, number)) = places[at] else {
            continue;
        };
        let Some(bin) = bins.get_mut(number) else {
            continue;
        };
        let white = mark.white[at];
        bin.product += white * (mark.left[at] + white);
        bin.square += white * white;
        bin.mark += moved(at) - offset;
        bin.x += x;
        bin.count += 1.0;
    }
    let mut plot = FindingPlot {
        mechanism,
        x_label: label,
        y_label: "what it moves edges by, urad".to_owned(),
        before: Vec::new(),
        after: Vec::new(),
        model: Vec::new(),
    };
    bins.retain(|bin| bin.square > 0.0);
    let mut errors: Vec<f64> = bins.iter().map(|bin| bin.error()).collect();
    errors.sort_by(f64::total_cmp);
    let usual = errors.get(errors.len() / 2).copied().unwrap_or(0.0);
    // Where a mark is large but hardly grows, edges say next to nothing of its size.
    bins.retain(|bin| bin.error() <= VAGUE * usual);
    for bin in &bins {
        let (x, model) = (bin.x / bin.count, bin.mark / bin.count);
        let share = bin.product / bin.square;
        plot.model.push((x, model));
        plot.before.push((x, share * model));
        plot.after.push((x, (share - 1.0) * model));
    }
    plot
}

/// The kinds of edges that a mark is on: of a delay of one channel, not those of the others, which would halve it.
fn drawn(seen: &Seen, mark: &Mark) -> Vec<bool> {
    let mut squares = vec![(0.0, 0.0); seen.classes.max(1) as usize];
    for (at, angle) in mark.angles.iter().enumerate() {
        let class = &mut squares[seen.class(at)];
        *class = (class.0 + angle * angle, class.1 + 1.0);
    }
    let rms: Vec<f64> = squares
        .iter()
        .map(|(sum, count)| (sum / f64::max(*count, 1.0)).sqrt())
        .collect();
    let most = rms.iter().copied().fold(0.0, f64::max);
    rms.iter()
        .map(|rms| *rms > 0.0 && *rms >= MOVED * most)
        .collect()
}

/// Which way a kind of edge is drawn: falls up and rises down where they are moved against each other.
fn sign_of(basis: Basis, change: Change) -> f64 {
    match basis {
        Basis::LevelTone { .. } | Basis::LevelDrift { .. } if change.rises => -1.0,
        _ => 1.0,
    }
}

/// Whether it goes up and down around a mean.
const fn rhythmic(basis: Basis) -> bool {
    matches!(
        basis,
        Basis::TorqueTone { .. }
            | Basis::LevelTone { .. }
            | Basis::Round { .. }
            | Basis::Lagged { .. }
            | Basis::TorqueOrder { .. }
    )
}

/// What a mark is drawn along.
fn coordinate(seen: &Seen, basis: Basis) -> Coordinate {
    let each = |label: String, x: &dyn Fn(usize) -> f64| {
        let all: Vec<f64> = (0..seen.len()).map(x).collect();
        let (low, high) = all
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(*x), high.max(*x))
            });
        even(label, &all, [low, high])
    };
    let degrees = |at: usize| 360.0 * seen.edge(at) as f64 / seen.edges.max(1) as f64;
    let disc = || "angle of the disc, degrees".to_owned();
    match basis {
        Basis::TorqueTone { f_hz } | Basis::LevelTone { f_hz, .. } => {
            each(format!("phase at {f_hz:.4} Hz, degrees"), &|at| {
                360.0 * (seen.times_s[at] * f_hz).rem_euclid(1.0)
            })
        }
        Basis::Round { order } | Basis::Lagged { order } | Basis::TorqueOrder { order }
            if order > 2.5 =>
        {
            each(format!("phase at order {order:.4}, degrees"), &|at| {
                (order * seen.theta(at)).to_degrees().rem_euclid(360.0)
            })
        }
        Basis::LevelDrift { .. }
        | Basis::Load { .. }
        | Basis::Drift
        | Basis::Warming { .. }
        | Basis::Direction
        | Basis::Coulomb
        | Basis::Viscous
        | Basis::Drag
        | Basis::Stribeck { .. } => each("time, s".to_owned(), &|at| seen.times_s[at]),
        Basis::Bump {
            angle_rad,
            width_rad,
            ..
        } => {
            let (middle, half) = (angle_rad.to_degrees(), 6.0 * width_rad.to_degrees());
            let all: Vec<f64> = (0..seen.len()).map(degrees).collect();
            even(disc(), &all, [middle - half, middle + half])
        }
        // What kinds of edges have in common shows from beginning to end. Bins of whole lines have as many of one kind as of another.
        Basis::Width { .. }
        | Basis::Shift { .. }
        | Basis::RiseLate { .. }
        | Basis::FallEarly { .. }
        | Basis::Late { .. } => {
            let each = lines_each(seen.len(), seen.classes, BINS);
            let place = |at: usize| Some((seen.times_s[at], at / each));
            Coordinate {
                label: "time, s".to_owned(),
                places: (0..seen.len()).map(place).collect(),
            }
        }
        _ => each(disc(), &degrees),
    }
}

/// Edges in each of so many cells, a whole number of lines: a kind of edge that is moved by itself must not come in and out of step
/// with them.
pub fn lines_each(edges: usize, classes: i64, cells: usize) -> usize {
    let line = classes.max(1) as usize;
    edges.div_ceil(cells * line).max(1) * line
}

/// Bins of one width.
fn even(label: String, all: &[f64], [low, high]: [f64; 2]) -> Coordinate {
    let width = ((high - low) / BINS as f64).max(f64::MIN_POSITIVE);
    let place = |x: &f64| {
        let inside = (low..=high).contains(x);
        inside.then(|| (*x, (((x - low) / width) as usize).min(BINS - 1)))
    };
    Coordinate {
        label,
        places: all.iter().map(place).collect(),
    }
}

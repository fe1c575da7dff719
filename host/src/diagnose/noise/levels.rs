//! Levels of torque noise and stamp noise that make what is left most likely.
//!
//! Two numbers for all recordings together: a factor on the density of torque noise, q = g q0, and a variance that every stamp has
//! on top of the declared, s^2 = s0^2 + J. Torque noise spreads an interval h as h^(3/2), stamps do whatever the interval, so edges
//! at one speed tell them apart by their correlation and two speeds by their size. The likelihood is that of the innovations,
//! -1/2 sum(ln S + v^2 / S) (Schweppe, IEEE Trans. Information Theory 11, 1965), climbed by Fisher's scoring.

use rayon::prelude::*;

use super::super::board::Board;
use super::super::kalman::{Reading, ShaftNoise, Whitener};

/// Edges that the first steps of the climb look at.
const EDGES_FIRST: usize = 20_000;

/// What fits best.
#[derive(Clone, Debug)]
pub struct Levels {
    /// Variance of the stamps on top of the declared, s^2; may be negative.
    pub added_s2: f64,
    /// Its standard error, whatever the distribution of the stamps, s^2.
    pub added_error_s2: f64,
    /// Twice the logarithm of the likelihood, less that with the declared stamps.
    pub likelihood: f64,
    /// The filter of each recording with these levels.
    pub whiteners: Vec<Whitener>,
    /// What is left, white with these levels.
    pub white: Vec<Vec<f64>>,
    /// Whether the twins of all recordings declare their noise.
    pub declared: bool,
}

impl Levels {
    /// By how much noisier stamps beat the declared ones; 0 where stamps are better than declared or nothing is.
    #[must_use]
    pub fn gain(&self) -> f64 {
        if self.declared && self.added_s2 > 0.0 {
            self.likelihood
        } else {
            0.0
        }
    }
}

/// A row of edges.
struct Row<'a> {
    readings: &'a [Reading],
    angles: &'a [f64],
    base: ShaftNoise,
    least_s2: f64,
}

/// Where the climb is: logarithm of the torque's factor, added variance in units of the first recording's declared.
type Place = [f64; 2];

/// Fits the levels to what is left, white with the recordings' noise.
#[must_use]
pub fn fit(board: &Board, left: &[Vec<f64>]) -> Levels {
    let declared = board.benches.iter().all(|bench| bench.declared.is_some());
    let angles: Vec<Vec<f64>> = board
        .benches
        .iter()
        .zip(left)
        .map(|(bench, left)| {
            let mut angles = left.clone();
            bench.whitener().restore(&mut angles);
            angles
        })
        .collect();
    let bases: Vec<ShaftNoise> = board
        .benches
        .iter()
        .map(|b| b.declared.unwrap_or(b.noise))
        .collect();
    let unit = bases
        .first()
        .map_or(1.0, |base| base.stamp_s * base.stamp_s);
    let rows = |most: usize| -> Vec<Row<'_>> {
        let whole: usize = angles.iter().map(Vec::len).sum();
        let mut rows = Vec::new();
        for ((bench, angles), base) in board.benches.iter().zip(&angles).zip(&bases) {
            for part in parts(angles.len(), most * angles.len() / whole.max(1)) {
                rows.push(Row {
                    readings: &bench.seen.readings[part.clone()],
                    angles: &angles[part],
                    base: *base,
                    least_s2: bench.least_stamp_s * bench.least_stamp_s,
                });
            }
        }
        rows
    };
    let (few, all) = (rows(EDGES_FIRST), rows(usize::MAX / 1_000_000));
    let near = climb(&few, unit, [0.0; 2], true, 12);
    let (top, none) = rayon::join(
        || climb(&all, unit, near.place, true, 3),
        || {
            let none = climb(&few, unit, [near.place[0], 0.0], false, 12);
            climb(&all, unit, none.place, false, 2)
        },
    );
    let noises: Vec<ShaftNoise> = all.iter().map(|row| row.noise(unit, top.place)).collect();
    let each = board.benches.iter().zip(&noises);
    let whiteners: Vec<Whitener> = each
        .map(|(b, noise)| Whitener::new(&b.seen.readings, *noise))
        .collect();
    let white = whiteners.iter().zip(&angles).map(|(whitener, angles)| {
        let mut white = angles.clone();
        whitener.whiten(&mut white);
        white
    });
    let white = white.collect();
    Levels {
        added_s2: top.place[1] * unit,
        added_error_s2: top.error * unit,
        likelihood: 2.0 * (top.log - none.log),
        whiteners,
        white,
        declared,
    }
}

/// Parts of a recording: three where it has more edges than asked for.
fn parts(edges: usize, most: usize) -> Vec<std::ops::Range<usize>> {
    if edges <= most.max(3_000) {
        return std::iter::once(0..edges).collect();
    }
    const PARTS: usize = 3;
    let length = most.max(3_000) / PARTS;
    let gap = (edges - length) / (PARTS - 1);
    (0..PARTS).map(|i| i * gap..i * gap + length).collect()
}

impl Row<'_> {
    fn noise(&self, unit: f64, place: Place) -> ShaftNoise {
        let stamp2 = self.base.stamp_s * self.base.stamp_s + place[1] * unit;
        ShaftNoise {
            acceleration: self.base.acceleration * place[0].exp(),
            load: self.base.load * place[0].exp(),
            stamp_s: stamp2.max(0.5 * self.least_s2).max(1e-24).sqrt(),
            ..self.base
        }
    }

    /// Logarithm of the innovation's deviation and the innovation over it, edge by edge; nothing where an edge sets the filter.
    fn look(&self, unit: f64, place: Place) -> Vec<Option<[f64; 2]>> {
        let whitener = Whitener::new(self.readings, self.noise(unit, place));
        let mut white = self.angles.to_vec();
        whitener.whiten(&mut white);
        let each = whitener.deviations().zip(white);
        each.map(|(deviation, white)| deviation.map(|d| [d.ln(), white]))
            .collect()
    }
}

struct Top {
    place: Place,
    log: f64,
    error: f64,
}

fn log_likelihood(looks: &[Vec<Option<[f64; 2]>>]) -> f64 {
    let each = looks.iter().flatten().flatten();
    each.map(|[log, white]| -log - 0.5 * white * white).sum()
}

/// Climbs from a place; with `stamps` held at the declared there is the torque alone.
fn climb(rows: &[Row<'_>], unit: f64, from: Place, stamps: bool, most: usize) -> Top {
    const STEP: f64 = 1e-4;
    let look =
        |place: Place| -> Vec<_> { rows.par_iter().map(|row| row.look(unit, place)).collect() };
    let mut place = from;
    let mut here = look(place);
    let mut log = log_likelihood(&here);
    let mut error = f64::INFINITY;
    for _ in 0..most {
        let wide = STEP * (1.0 + place[1]).max(0.1);
        let (torque, stamp) = rayon::join(
            || look([place[0] + STEP, place[1]]),
            || {
                if stamps {
                    look([place[0], place[1] + wide])
                } else {
                    here.clone()
                }
            },
        );
        let sums = Slopes::of(&here, &torque, &stamp, [STEP, wide]);
        let (step, over) = sums.step(stamps);
        error = over;
        let mut share = 1.0;
        let mut moved = false;
        for _ in 0..6 {
            let there = [
                place[0] + (share * step[0]).clamp(-1.5, 1.5),
                (place[1] + share * step[1]).max(0.2 * (place[1] + 1.0) - 1.0),
            ];
            let looks = look(there);
            let better = log_likelihood(&looks);
            if better > log {
                moved = better - log > 1e-3;
                (place, here, log) = (there, looks, better);
                break;
            }
            share *= 0.3;
        }
        if !moved {
            break;
        }
    }
    Top { place, log, error }
}

/// Slope of the likelihood, Fisher's information and the scatter of the slope.
#[derive(Default)]
struct Slopes {
    slope: [f64; 2],
    information: [f64; 3],
    scatter: [f64; 3],
}

impl Slopes {
    fn of(
        here: &[Vec<Option<[f64; 2]>>],
        torque: &[Vec<Option<[f64; 2]>>],
        stamp: &[Vec<Option<[f64; 2]>>],
        steps: [f64; 2],
    ) -> Self {
        let mut sums = Self::default();
        let each = here
            .iter()
            .flatten()
            .zip(torque.iter().flatten())
            .zip(stamp.iter().flatten());
        for ((here, torque), stamp) in each {
            let (Some(here), Some(torque), Some(stamp)) = (here, torque, stamp) else {
                continue;
            };
            let along = |there: &[f64; 2], step: f64| {
                let (log, white) = ((there[0] - here[0]) / step, (there[1] - here[1]) / step);
                (-log - here[1] * white, log, white + here[1] * log)
            };
            let (t, s) = (along(torque, steps[0]), along(stamp, steps[1]));
            sums.slope[0] += t.0;
            sums.slope[1] += s.0;
            let pairs = [(t, t), (t, s), (s, s)];
            for (at, (a, b)) in pairs.into_iter().enumerate() {
                sums.information[at] += 2.0 * a.1 * b.1 + a.2 * b.2;
                sums.scatter[at] += a.0 * b.0;
            }
        }
        sums
    }

    /// Step of the climb, and the standard error of the stamps' variance.
    fn step(&self, stamps: bool) -> ([f64; 2], f64) {
        let [a, b, c] = self.information;
        if !stamps {
            return ([self.slope[0] / a, 0.0], f64::INFINITY);
        }
        let whole = a * c - b * b;
        if whole.is_nan() || whole <= 1e-9 * a * c {
            return ([0.0; 2], f64::INFINITY);
        }
        let inverse = [c / whole, -b / whole, a / whole];
        let [u, v] = self.slope;
        let step = [
            inverse[0] * u + inverse[1] * v,
            inverse[1] * u + inverse[2] * v,
        ];
        // The slope's own scatter between inverses of the information: right for stamps of any distribution.
        let [p, q, r] = self.scatter;
        let variance = inverse[1] * inverse[1] * p
            + 2.0 * inverse[1] * inverse[2] * q
            + inverse[2] * inverse[2] * r;
        (step, variance.sqrt())
    }
}

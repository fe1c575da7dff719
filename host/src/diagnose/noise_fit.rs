//! The noise that makes a residual most likely.

use rayon::prelude::*;

use super::kalman::{Reading, ShaftNoise, Whitener};

/// Edges that the noise is fitted on at the most: parts from all over say as much.
const EDGES_MOST: usize = 15_000;

/// Which of the noise's numbers are free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Free {
    /// Torque noise and stamps: the twin says what holds the speed.
    Sizes,
    /// All of them.
    All,
}

/// Fits the noise to a residual, one angle a reading. A stamp is never better than `least_stamp_s`.
#[must_use]
pub fn fit(
    readings: &[Reading],
    angles: &[f64],
    least_stamp_s: f64,
    start: ShaftNoise,
    free: Free,
) -> ShaftNoise {
    let least2 = least_stamp_s * least_stamp_s;
    let over = |stamp_s: f64| (stamp_s * stamp_s - least2).max(1e-4 * least2).sqrt();
    let of = |logs: &[f64]| ShaftNoise {
        acceleration: logs[0].exp(),
        stamp_s: (logs[1].exp().powi(2) + least2).sqrt(),
        drift: logs.get(2).map_or(0.0, |log| log.exp()),
        forgets_per_s: logs.get(3).map_or(start.forgets_per_s, |log| log.exp()),
        hold_s: start.hold_s,
        load: start.load,
    };
    let cost = |logs: &[f64]| cost(readings, angles, of(logs));
    let mut first = vec![start.acceleration.ln(), over(start.stamp_s).ln()];
    if free == Free::All {
        first.extend([
            start.drift.max(1e-30).ln(),
            start.forgets_per_s.max(1e-9).ln(),
        ]);
    }
    of(&simplex(&cost, &first, 1.0))
}

/// How unlikely a residual is with a noise: twice the logarithm, less what hangs on nothing.
#[must_use]
pub fn cost(readings: &[Reading], angles: &[f64], noise: ShaftNoise) -> f64 {
    let parts = parts(readings.len()).into_par_iter();
    let each = parts.map(|part| {
        let whitener = Whitener::new(&readings[part.clone()], noise);
        let mut white = angles[part].to_vec();
        whitener.whiten(&mut white);
        // Innovations far out are events, not noise: they count less.
        white.iter().map(|w| robust(*w)).sum::<f64>() + whitener.log_variance()
    });
    // Added in their order, so that the sum is the same whoever is first.
    each.collect::<Vec<f64>>().into_iter().sum()
}

/// Parts of a recording that the noise is fitted on.
fn parts(edges: usize) -> Vec<std::ops::Range<usize>> {
    if edges <= EDGES_MOST {
        return vec![0..edges; 1];
    }
    const PARTS: usize = 3;
    let length = EDGES_MOST / PARTS;
    let gap = (edges - length) / (PARTS - 1);
    (0..PARTS).map(|i| i * gap..i * gap + length).collect()
}

fn robust(white: f64) -> f64 {
    const FAR: f64 = 4.0;
    let size = white.abs();
    if size < FAR {
        size * size
    } else {
        FAR * (2.0 * size - FAR)
    }
}

/// Lowest place of a smooth cost: Nelder and Mead's simplex (Computer Journal 7, 1965).
pub fn simplex(cost: &dyn Fn(&[f64]) -> f64, start: &[f64], step: f64) -> Vec<f64> {
    let dimensions = start.len();
    let mut corners: Vec<(Vec<f64>, f64)> = (0..=dimensions)
        .map(|corner| {
            let mut at = start.to_vec();
            if corner > 0 {
                at[corner - 1] += step;
            }
            let there = cost(&at);
            (at, there)
        })
        .collect();
    for _ in 0..60 * dimensions {
        corners.sort_by(|a, b| a.1.total_cmp(&b.1));
        if corners[dimensions].1 - corners[0].1 < 0.02 {
            break;
        }
        let worst = corners[dimensions].clone();
        let middle: Vec<f64> = (0..dimensions)
            .map(|i| {
                corners[..dimensions]
                    .iter()
                    .map(|corner| corner.0[i])
                    .sum::<f64>()
                    / dimensions as f64
            })
            .collect();
        let along = |share: f64| {
            let at: Vec<f64> = (0..dimensions)
                .map(|i| middle[i] + share * (worst.0[i] - middle[i]))
                .collect();
            let there = cost(&at);
            (at, there)
        };
        let reflected = along(-1.0);
        let better = if reflected.1 < corners[0].1 {
            let further = along(-2.0);
            if further.1 < reflected.1 {
                further
            } else {
                reflected
            }
        } else if reflected.1 < corners[dimensions - 1].1 {
            reflected
        } else {
            let nearer = along(if reflected.1 < worst.1 { -0.5 } else { 0.5 });
            if nearer.1 < worst.1.min(reflected.1) {
                nearer
            } else {
                let best = corners[0].0.clone();
                for corner in &mut corners[1..] {
                    for (value, best) in corner.0.iter_mut().zip(&best) {
                        *value = 0.5 * (best + *value);
                    }
                    corner.1 = cost(&corner.0);
                }
                continue;
            }
        };
        corners[dimensions] = better;
    }
    corners.sort_by(|a, b| a.1.total_cmp(&b.1));
    corners.swap_remove(0).0
}

//! The fit of single slips: each for itself, its instant of breaking away and its place of rest free.

use nalgebra::{DMatrix, DVector};

use super::slip::{SlipLaw, Wave};

/// Steps of the fit of one slip.
const ROUNDS: usize = 20;
/// Free in the fit of one slip: logarithms of spring, drop and speed, instant of breaking away, place of rest.
pub const FREE: usize = 5;
/// All of them, and those that are each slip's own whatever the law.
const ALL: [usize; FREE] = [0, 1, 2, 3, 4];
const OWN: [usize; 2] = [3, 4];

/// Frequencies and drops of friction to begin with, against those of a free slip: much damping needs more of both.
const FIRST: [(f64, f64); 6] = [
    (1.0, 1.0),
    (1.4, 1.0),
    (0.7, 1.0),
    (1.4, 2.0),
    (1.0, 2.0),
    (1.4, 4.0),
];

/// One slip, edge by edge.
#[derive(Clone, Debug)]
pub struct Cycle {
    /// When its first edge came, s.
    pub start_s: f64,
    /// Where that is, rad, growing along the motion.
    pub start_rad: f64,
    /// Times from the first edge on, s.
    pub times_s: Vec<f64>,
    /// True angles of the edges from the first on, rad.
    pub ways: Vec<f64>,
    /// The shaft's torques, with the phase at the first edge.
    pub waves: Vec<Wave>,
}

/// The fit of one slip.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The free numbers; instant and place count from the first edge.
    pub at: [f64; FREE],
    /// Sum of squared angles left.
    pub squares: f64,
}

/// Every slip fitted for itself, from where the middle one comes to lie.
/// The damping is the one of two that suits it better; says also which.
#[must_use]
#[allow(clippy::type_complexity)]
pub fn fitted(
    cycles: &[Cycle],
    pull_rad_s: f64,
    dampings: [(bool, f64); 2],
) -> Option<(bool, f64, Vec<(&Cycle, Fitted)>)> {
    let fit = |cycle, start, damping| descended(cycle, start, &ALL, pull_rad_s, damping);
    let mut by_length: Vec<&Cycle> = cycles.iter().collect();
    by_length.sort_by_key(|cycle| cycle.ways.len());
    let usual = by_length[by_length.len() / 2];
    let (way, time) = (*usual.ways.last()?, *usual.times_s.last()?);
    let lost = way / usual.ways.len() as f64;
    let mut tries = Vec::new();
    for (faster, more) in FIRST {
        for over in [0.15, 0.4, 1.0, 2.5] {
            let spring = (std::f64::consts::PI / time * faster).powi(2);
            let drop = 0.5 * more * spring * (way - pull_rad_s * time).max(0.1 * way);
            let start = [
                spring.ln(),
                drop.ln(),
                (over * pull_rad_s).ln(),
                -0.1 * time,
                -0.5 * lost,
            ];
            for (beside, damping) in dampings {
                tries.extend(fit(usual, start, damping).map(|fit| (beside, damping, fit)));
            }
        }
    }
    let (beside, damping, best) = tries
        .into_iter()
        .min_by(|a, b| a.2.squares.total_cmp(&b.2.squares))?;
    let all = cycles
        .iter()
        .filter_map(|cycle| Some((cycle, fit(cycle, best.at, damping)?)));
    Some((beside, damping, all.collect()))
}

/// The same again with another speed of the far end.
#[must_use]
pub fn refitted<'a>(
    all: &[(&'a Cycle, Fitted)],
    pull_rad_s: f64,
    damping: f64,
) -> Vec<(&'a Cycle, Fitted)> {
    let again = |(cycle, fit): &(&'a Cycle, Fitted)| {
        Some((*cycle, descended(cycle, fit.at, &ALL, pull_rad_s, damping)?))
    };
    all.iter().filter_map(again).collect()
}

/// A slip with a law that is given, as logarithms of spring, drop and speed: only its instant and place are its own.
#[must_use]
pub fn placed(cycle: &Cycle, law: [f64; 3], pull_rad_s: f64, damping: f64) -> Option<Fitted> {
    let (way, time) = (*cycle.ways.last()?, *cycle.times_s.last()?);
    let lost = way / cycle.ways.len() as f64;
    let fits = [-0.1, -0.03].into_iter().filter_map(|ahead| {
        let start = [law[0], law[1], law[2], ahead * time, -0.5 * lost];
        descended(cycle, start, &OWN, pull_rad_s, damping)
    });
    fits.min_by(|a, b| a.squares.total_cmp(&b.squares))
}

/// How far a law with these numbers is from each edge of a slip, rad; none where it never comes to a stop.
#[must_use]
pub fn off(cycle: &Cycle, at: &[f64; FREE], pull_rad_s: f64, damping: f64) -> Option<DVector<f64>> {
    let law = SlipLaw {
        spring: at[0].exp(),
        drop: at[1].exp(),
        over_rad_s: at[2].exp(),
        damping,
        pull_rad_s,
        waves: cycle.waves.iter().map(|wave| wave.on(at[4])).collect(),
    };
    let slip = law.slip()?;
    let each = cycle.times_s.iter().zip(&cycle.ways);
    let left = each.map(|(time, way)| slip.way(time - at[3]) + at[4] - way);
    Some(DVector::from_iterator(cycle.ways.len(), left))
}

/// Least squares by Levenberg and Marquardt's way (SIAM J. Appl. Math. 11, 1963).
fn descended(
    cycle: &Cycle,
    start: [f64; FREE],
    free: &[usize],
    pull_rad_s: f64,
    damping: f64,
) -> Option<Fitted> {
    let left = |at: &[f64; FREE]| off(cycle, at, pull_rad_s, damping);
    let nudges = [
        1e-4,
        1e-4,
        1e-3,
        1e-5 * cycle.times_s.last()?,
        1e-5 * cycle.ways.last()?,
    ];
    let mut at = start;
    let mut now = left(&at)?;
    let mut squares = now.norm_squared();
    let mut held = 1e-2;
    for _ in 0..ROUNDS {
        let mut slopes = DMatrix::zeros(cycle.ways.len(), free.len());
        for (column, &i) in free.iter().enumerate() {
            let mut aside = at;
            aside[i] += nudges[i];
            slopes.set_column(column, &((left(&aside)? - &now) / nudges[i]));
        }
        let (gram, right) = (slopes.transpose() * &slopes, slopes.transpose() * &now);
        let before = squares;
        for _ in 0..6 {
            let mut firm = gram.clone();
            for i in 0..free.len() {
                firm[(i, i)] *= 1.0 + held;
            }
            let step = firm.cholesky()?.solve(&right);
            let mut next = at;
            free.iter()
                .zip(step.iter())
                .for_each(|(i, step)| next[*i] -= step);
            for (value, old) in next.iter_mut().zip(at).take(3) {
                *value = value.clamp(old - 1.0, old + 1.0);
            }
            match left(&next).map(|left| (left.norm_squared(), left)) {
                Some((less, left)) if less < squares => {
                    (at, now, squares) = (next, left, less);
                    held *= 0.2;
                    break;
                }
                _ => held *= 6.0,
            }
        }
        if squares > before * (1.0 - 1e-5) {
            break;
        }
    }
    Some(Fitted { at, squares })
}

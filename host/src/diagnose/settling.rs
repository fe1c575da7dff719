//! When a drift of the level begins, how fast it settles and where.
//!
//! A drift that begins later and settles faster explains nearly as much, and one that is slow against what is left of the recording is a
//! ramp of any time constant: the likelihood is a bent ridge, and slopes at its top say little of how far it goes. So it is taken over
//! both, each size with its own where they are, and what holds 95 % of it is the interval, every time and every ratio of time constants
//! as likely before.

use rayon::prelude::*;

use super::basis::Basis;
use super::board::{Board, Model};
use super::estimate::spread;
use super::hypothesis::Hypothesis;
use super::instants::{Between, NOTHING, TAIL, held, others, take};
use super::search::Searched;

/// Points along each.
const POINTS: usize = 13;
/// Times that a grid is laid round what is worth it.
const TIMES: usize = 5;
/// Time constants from and up to which a recording tells them apart, in its lengths.
const TAU: [f64; 2] = [1e-4, 10.0];
/// Places of a size within its own spread, in standard deviations, with their logarithms of density.
const SPREAD: [f64; 7] = [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0];

/// One beginning and time constant.
#[derive(Clone, Copy, Debug)]
struct Tried {
    from_s: f64,
    log_tau: f64,
    /// Logarithm of the likelihood.
    likely: f64,
    /// Where it settles then, rad, and the standard error of that.
    size: Option<[f64; 2]>,
}

/// Moves a drift of the level to where it explains most, and says what its numbers lie between.
pub fn settles(
    board: &Board,
    searched: &mut Searched,
    number: usize,
    [from_s, tau_s]: [f64; 2],
    channel: Option<usize>,
) -> Option<Between> {
    let model = board.fit(others(searched, number))?;
    let variance = spread(&searched.model).max(1.0);
    let first_s = board.benches.iter().filter_map(|b| b.seen.times_s.first());
    let last_s = board.benches.iter().filter_map(|b| b.seen.times_s.last());
    let ends = [
        first_s.copied().fold(f64::INFINITY, f64::min),
        last_s.copied().fold(f64::NEG_INFINITY, f64::max),
    ];
    let long = ends[1] - ends[0];
    let of =
        |[from_s, log_tau]: [f64; 2]| tried(board, &model, variance, [from_s, log_tau], channel);
    let within = [ends, [(TAU[0] * long).ln(), (TAU[1] * long).ln()]];
    let start = [[from_s, 0.1 * long], [tau_s.ln(), 1.0]];
    let grid = Grid::over(start, within, &of)?;
    let best = grid.best();
    let basis = Basis::LevelDrift {
        from_s: best.from_s,
        tau_s: best.log_tau.exp(),
        channel,
    };
    take(board, searched, number, Hypothesis::by(basis))?;
    Some(grid.between())
}

fn tried(
    board: &Board,
    model: &Model,
    variance: f64,
    [from_s, log_tau]: [f64; 2],
    channel: Option<usize>,
) -> Tried {
    let basis = Basis::LevelDrift {
        from_s,
        tau_s: log_tau.exp(),
        channel,
    };
    let columns = Hypothesis::by(basis).columns(board);
    let gain = board.gain(model, &columns);
    let size = gain.as_ref().filter(|_| columns.len() == 1).map(|gain| {
        let size = gain.sizes[0];
        [size, size.abs() * (variance / gain.squares).sqrt()]
    });
    Tried {
        from_s,
        log_tau,
        likely: gain.map_or(f64::NEG_INFINITY, |gain| 0.5 * gain.squares / variance),
        size,
    }
}

/// A likelihood over both, row by row of one time constant.
struct Grid {
    tried: Vec<Tried>,
}

impl Grid {
    /// Lays grids until one is round what is worth it; none where there is no likelihood.
    fn over(
        start: [[f64; 2]; 2],
        within: [[f64; 2]; 2],
        of: &(dyn Fn([f64; 2]) -> Tried + Sync),
    ) -> Option<Self> {
        let mut sides = start.map(|[at, far]| [at - far, at + far]);
        let mut grid = Self { tried: Vec::new() };
        for _ in 0..TIMES {
            for (side, within) in sides.iter_mut().zip(within) {
                *side = side.map(|end| end.clamp(within[0], within[1]));
            }
            let at = |axis: usize, i: usize| {
                let [low, high] = sides[axis];
                low + (high - low) * i as f64 / (POINTS - 1) as f64
            };
            grid.tried = (0..POINTS * POINTS)
                .into_par_iter()
                .map(|i| of([at(0, i % POINTS), at(1, i / POINTS)]))
                .collect();
            let most = grid.best().likely;
            if !most.is_finite() {
                return None;
            }
            let mut done = true;
            for (axis, within) in within.into_iter().enumerate() {
                let worth: Vec<usize> = (0..POINTS * POINTS)
                    .filter(|i| grid.tried[*i].likely > most - NOTHING)
                    .map(|i| if axis == 0 { i % POINTS } else { i / POINTS })
                    .collect();
                let first = worth.iter().copied().min()?;
                let last = worth.iter().copied().max()?;
                let [low, high] = sides[axis];
                let step = (high - low) / (POINTS - 1) as f64;
                // Out where it does not end, in to where it does.
                let beyond = |at: usize, edge: usize, way: f64| {
                    let out = if at == edge { 6.0 } else { 1.0 };
                    way.mul_add(out * step, low + step * at as f64)
                };
                let cut = [
                    first == 0 && low > within[0],
                    last == POINTS - 1 && high < within[1],
                ];
                done &= !cut.contains(&true) && 2 * (last - first) >= POINTS - 3;
                sides[axis] = [beyond(first, 0, -1.0), beyond(last, POINTS - 1, 1.0)];
            }
            if done {
                break;
            }
        }
        Some(grid)
    }

    fn best(&self) -> Tried {
        let most = |a: &Tried, b: &Tried| if b.likely > a.likely { *b } else { *a };
        self.tried[1..]
            .iter()
            .fold(self.tried[0], |a, b| most(&a, b))
    }

    /// What holds 95 % of it, number by number.
    fn between(&self) -> Between {
        let most = self.best().likely;
        let weight = |one: &Tried| (one.likely - most).exp();
        let along = |number: &dyn Fn(&Tried) -> f64, line: &dyn Fn(usize) -> usize| {
            let mut points = vec![(0.0, 0.0); POINTS];
            for (i, one) in self.tried.iter().enumerate() {
                let point = &mut points[line(i)];
                *point = (number(one), point.1 + weight(one));
            }
            let logs: Vec<(f64, f64)> = points.iter().map(|(at, sum)| (*at, sum.ln())).collect();
            held(&logs, 0.0)
        };
        let from_s = along(&|one| one.from_s, &|i| i % POINTS);
        let tau_s = along(&|one| one.log_tau, &|i| i / POINTS).map(f64::exp);
        let mut all = vec![("from_s", from_s), ("tau_s", tau_s)];
        all.extend(self.size().map(|size| ("angle_rad", size)));
        all
    }

    fn size(&self) -> Option<[f64; 2]> {
        let most = self.best().likely;
        let mut sizes: Vec<(f64, f64)> = Vec::new();
        for one in self.tried.iter().filter(|one| one.likely > most - NOTHING) {
            let [size, error] = one.size?;
            let each = SPREAD.iter().map(|by| {
                (
                    by.mul_add(error, size),
                    (one.likely - most - 0.5 * by * by).exp(),
                )
            });
            sizes.extend(each);
        }
        sizes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let whole: f64 = sizes.iter().map(|(_, weight)| weight).sum();
        let mut sum = 0.0;
        let below: Vec<(f64, f64)> = sizes
            .iter()
            .map(|(size, weight)| {
                sum += weight;
                (*size, sum - 0.5 * weight)
            })
            .collect();
        let at = |part: f64| {
            let found = below.iter().find(|(_, sum)| *sum >= part * whole);
            found.map(|(size, _)| *size)
        };
        Some([at(TAIL)?, at(1.0 - TAIL)?])
    }
}

#[cfg(test)]
mod tests {
    use super::{Grid, Tried};

    /// A parabola whose numbers hang together by `lean`, with standard deviations of 0.2 and 0.4.
    fn ridge(lean: f64) -> impl Fn([f64; 2]) -> Tried + Sync {
        move |[from_s, log_tau]| {
            let (x, y) = ((from_s - 3.0) / 0.2, (log_tau + 1.0) / 0.4);
            let off = (x * x - 2.0 * lean * x * y + y * y) / (1.0 - lean * lean);
            Tried {
                from_s,
                log_tau,
                likely: 40.0 - 0.5 * off,
                size: Some([5.0 + x, 0.5]),
            }
        }
    }

    fn near(between: [f64; 2], want: [f64; 2], by: f64) {
        let off = |i: usize| (between[i] - want[i]).abs();
        assert!(off(0) < by && off(1) < by, "{between:?} and not {want:?}");
    }

    #[test]
    fn a_ridge_has_the_intervals_of_its_shadows() {
        for start in [[[3.0, 0.1], [-1.0, 0.1]], [[2.0, 3.0], [-3.0, 0.5]]] {
            let within = [[0.0, 10.0], [-9.0, 3.0]];
            let grid = Grid::over(start, within, &ridge(0.8)).unwrap();
            let between = grid.between();
            near(between[0].1, [3.0 - 0.392, 3.0 + 0.392], 0.03);
            let tau = [(-1.0 - 0.784_f64).exp(), (-1.0 + 0.784_f64).exp()];
            near(between[1].1, tau, 0.06);
            // Its own spread, and that of where it begins.
            let size = 1.96 * 1.25_f64.sqrt();
            near(between[2].1, [5.0 - size, 5.0 + size], 0.2);
        }
    }

    #[test]
    fn what_the_recording_does_not_end_reaches_to_its_end() {
        let ramp = |[from_s, log_tau]: [f64; 2]| Tried {
            from_s,
            log_tau,
            likely: -0.5 * ((from_s - 3.0) / 0.2).powi(2),
            size: None,
        };
        let grid = Grid::over([[3.0, 0.5], [0.0, 1.0]], [[0.0, 10.0], [-9.0, 3.0]], &ramp).unwrap();
        let between = grid.between();
        assert_eq!(between.len(), 2, "no size, no interval");
        near(between[1].1.map(f64::ln), [-8.7, 2.7], 0.1);
    }
}

//! When a push begins and ends, and between which times that lies.
//!
//! Through white torque noise of density q the likelihood of a torque's beginning falls as a line, by T^2 |t| / 2q on average with a
//! walk of that variance on it, until the stamps' errors round its top: it is no parabola with a curvature to take an interval from,
//! and it has many tops (D. V. Hinkley, Biometrika 57, 1970). So the times are taken where it is largest of all, and the interval is
//! what holds 95 % of it, every time as likely before.

use super::basis::Basis;
use super::board::{Board, Column, Model};
use super::estimate::spread;
use super::hypothesis::Hypothesis;
use super::search::{Found, Searched};
use super::settling;

/// Numbers by their names, each with what it lies between with 95 %, where slopes do not say that.
pub type Between = Vec<(&'static str, [f64; 2])>;

/// Points that the likelihood is taken at.
const POINTS: usize = 32;
/// Logarithm of a likelihood, from its top, that nothing comes of.
pub(super) const NOTHING: f64 = 6.5;
/// Part of the likelihood to either side of an interval.
pub(super) const TAIL: f64 = 0.025;

/// What was found with the times of its pushes where they explain most, and between which times these lie.
#[must_use]
pub fn sharpened(board: &Board, mut searched: Searched) -> (Searched, Vec<Between>) {
    let mut all = Vec::new();
    for number in 0..searched.found.len() {
        let between = match searched.found[number].hypothesis.bases[..] {
            [Basis::Load { from_s, until_s }] => {
                push(board, &mut searched, number, [from_s, until_s])
            }
            [
                Basis::LevelDrift {
                    from_s,
                    tau_s,
                    channel,
                },
            ] => settling::settles(board, &mut searched, number, [from_s, tau_s], channel),
            _ => None,
        };
        all.push(between.unwrap_or_default());
    }
    (searched, all)
}

fn push(
    board: &Board,
    searched: &mut Searched,
    number: usize,
    mut times: [f64; 2],
) -> Option<Between> {
    let others = others(searched, number);
    let model = board.fit(others)?;
    let variance = spread(&searched.model).max(1.0);
    let seconds = board.benches.iter().map(|bench| bench.seen.seconds());
    let edges = board.edges() as f64 / board.benches.len() as f64;
    let first_s = 4.0 * seconds.fold(0.0, f64::max) / edges;
    let mut between = [None; 2];
    // Each where the other is: they hang together by the torque alone.
    for _ in 0..2 {
        for which in 0..2 {
            if !times[which].is_finite() {
                continue;
            }
            let likelihood = |time: f64| {
                let mut moved = times;
                moved[which] = time;
                (moved[0] < moved[1])
                    .then(|| weight(board, &model, moved).map(|w| 0.5 * w / variance))
                    .flatten()
                    .unwrap_or(f64::NEG_INFINITY)
            };
            let top = Top::around(times[which], first_s, &likelihood)?;
            times[which] = top.at;
            between[which] = Some(top.between);
        }
    }
    take(board, searched, number, with(times))?;
    let names = ["from_s", "until_s"].into_iter().zip(between);
    Some(
        names
            .filter_map(|(name, between)| Some((name, between?)))
            .collect(),
    )
}

/// Takes a hypothesis in place of a finding's, and fits all sizes; none, and nothing taken, where it does not show as that does.
pub(super) fn take(
    board: &Board,
    searched: &mut Searched,
    number: usize,
    hypothesis: Hypothesis,
) -> Option<()> {
    let columns = hypothesis.columns(board);
    if columns.len() != searched.found[number].columns.len() {
        return None;
    }
    let sharp = Found {
        hypothesis,
        columns,
        ..searched.found[number].clone()
    };
    let old = std::mem::replace(&mut searched.found[number], sharp);
    let Some(model) = board.fit(all(searched)) else {
        searched.found[number] = old;
        return None;
    };
    searched.model = model;
    Some(())
}

fn with([from_s, until_s]: [f64; 2]) -> Hypothesis {
    Hypothesis::by(Basis::Load { from_s, until_s })
}

/// Fall of the sum of squares by a push between two times.
fn weight(board: &Board, model: &Model, times: [f64; 2]) -> Option<f64> {
    let columns = with(times).columns(board);
    Some(board.gain(model, &columns)?.squares)
}

/// Every column of a search.
fn all(searched: &Searched) -> Vec<Column> {
    let nuisances = searched.model.columns[..searched.nuisances].iter();
    let own = searched.found.iter().flat_map(|found| &found.columns);
    nuisances.chain(own).cloned().collect()
}

/// Every column but those of one finding.
pub(super) fn others(searched: &Searched, number: usize) -> Vec<Column> {
    let nuisances = searched.model.columns[..searched.nuisances].iter();
    let others = searched.found.iter().enumerate();
    let own = others
        .filter(|(at, _)| *at != number)
        .flat_map(|(_, found)| &found.columns);
    nuisances.chain(own).cloned().collect()
}

/// The top of a likelihood along one number.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Top {
    /// Where it is largest.
    at: f64,
    /// What holds 95 % of it.
    between: [f64; 2],
}

impl Top {
    /// Looks around a number, first as near as `first`; none where the likelihood has no sides.
    fn around(at: f64, first: f64, likelihood: &dyn Fn(f64) -> f64) -> Option<Self> {
        let (mut at, mut most) = (at, likelihood(at));
        if !most.is_finite() {
            return None;
        }
        // Out to where nothing comes of it, twice as far each time.
        let mut sides = [at; 2];
        for (side, way) in sides.iter_mut().zip([-1.0, 1.0]) {
            let (from, mut far) = (at, first);
            for _ in 0..16 {
                *side = from + way * far;
                let there = likelihood(*side);
                if there > most {
                    (at, most) = (*side, there);
                }
                if there < most - NOTHING {
                    break;
                }
                far *= 2.0;
            }
        }
        let mut points: Vec<(f64, f64)> = Vec::new();
        // The first grid finds where it is, the others how it falls.
        for _ in 0..4 {
            let step = (sides[1] - sides[0]) / POINTS as f64;
            points = (0..=POINTS)
                .map(|i| step.mul_add(i as f64, sides[0]))
                .chain([at])
                .map(|at| (at, likelihood(at)))
                .collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            for point in &points {
                if point.1 > most {
                    (at, most) = *point;
                }
            }
            let worth = |point: &&(f64, f64)| point.1 > most - NOTHING;
            let first = points.iter().position(|p| worth(&p))?;
            let last = points.iter().rposition(|p| worth(&p))?;
            sides = [
                points[first.saturating_sub(1)].0,
                points[(last + 1).min(points.len() - 1)].0,
            ];
            if last - first > POINTS / 2 {
                break;
            }
        }
        Some(Self {
            at,
            between: held(&points, most),
        })
    }
}

/// Numbers between which 95 % of a likelihood is, of points in order with its logarithm.
pub(super) fn held(points: &[(f64, f64)], most: f64) -> [f64; 2] {
    let mut sums = vec![0.0];
    for pair in points.windows(2) {
        let dense = 0.5 * ((pair[0].1 - most).exp() + (pair[1].1 - most).exp());
        sums.push(dense.mul_add(pair[1].0 - pair[0].0, sums[sums.len() - 1]));
    }
    let whole = sums[sums.len() - 1];
    [TAIL, 1.0 - TAIL].map(|part| {
        let after = sums.iter().position(|sum| *sum >= part * whole);
        let after = after.unwrap_or(sums.len() - 1).max(1);
        let share = (part * whole - sums[after - 1]) / (sums[after] - sums[after - 1]);
        points[after - 1].0 + share * (points[after].0 - points[after - 1].0)
    })
}

#[cfg(test)]
mod tests {
    use super::Top;

    #[test]
    fn a_likelihood_that_falls_as_lines_has_the_interval_of_its_mass() {
        // exp(-|t - 3| / 0.02): 95 % within ln 20 scales.
        let top = Top::around(3.05, 0.001, &|t| -(t - 3.0_f64).abs() / 0.02).unwrap();
        assert!((top.at - 3.0).abs() < 0.004, "{top:?}");
        let reach = 0.02 * 20f64.ln();
        assert!((top.between[0] - (3.0 - reach)).abs() < 0.004, "{top:?}");
        assert!((top.between[1] - (3.0 + reach)).abs() < 0.004, "{top:?}");
    }

    #[test]
    fn the_higher_of_two_tops_is_found_from_the_lower() {
        let two = |t: f64| {
            let of = |at: f64, high: f64| high - 0.5 * ((t - at) / 0.01).powi(2);
            of(1.0, 0.0).max(of(1.04, 4.0))
        };
        let top = Top::around(1.0, 0.002, &two).unwrap();
        assert!((top.at - 1.04).abs() < 0.005, "{top:?}");
        assert!(top.between[0] > 1.01 && top.between[1] < 1.07, "{top:?}");
    }

    #[test]
    fn nothing_is_said_where_there_is_no_likelihood() {
        assert_eq!(Top::around(0.0, 1.0, &|_| f64::NEG_INFINITY), None);
    }
}

//! The law that all slips of a recording have in common, fitted to all of them at once.
//!
//! Spring, drop of friction and the speed over which it drops are one for all slips, instant and place are each slip's own and are
//! eliminated slip by slip (Schur's complement). What scatters from slip to slip, torque noise above all, moves the edges of a slip
//! together, so the standard errors come from how much the slips disagree: K.-Y. Liang, S. L. Zeger, Biometrika 73 (1986), section 2.

use nalgebra::{DMatrix, DVector, Matrix2, Matrix3, Matrix3x2, Vector2, Vector3};

use super::slip_fit::{Cycle, FREE, Fitted, off, placed};

/// Steps of the fit, and tries of each.
const ROUNDS: usize = 30;
const TRIES: usize = 10;
/// Speeds over which friction drops to begin with, against the mean of the slips' own, and against that of the spring's far end.
const STARTS: [f64; 3] = [1.0, 1.8, 0.5];
const PULLED: [f64; 3] = [0.4, 1.0, 2.5];

/// What slips have in common; torques over the inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// Logarithms of spring, drop and speed.
    pub logs: [f64; 3],
    /// Standard errors of these.
    pub errors: [f64; 3],
    /// Speed of the spring's far end, rad/s.
    pub pull_rad_s: f64,
    /// Damping, 1/s.
    pub damping: f64,
}

/// One slip about a law: least squares with its own numbers eliminated.
struct About {
    own: Matrix2<f64>,
    own_right: Vector2<f64>,
    both: Matrix3x2<f64>,
    shared: Matrix3<f64>,
    right: Vector3<f64>,
}

impl Law {
    /// From slips that were fitted one by one.
    #[must_use]
    pub fn of(slips: &[(&Cycle, &Fitted)], pull_rad_s: f64, damping: f64) -> Self {
        Self::joint(slips, pull_rad_s, damping)
            .unwrap_or_else(|| Self::mean(slips, pull_rad_s, damping))
    }

    /// The mean of the slips' own laws, with their scatter.
    fn mean(slips: &[(&Cycle, &Fitted)], pull_rad_s: f64, damping: f64) -> Self {
        let count = slips.len() as f64;
        let logs =
            std::array::from_fn(|i| slips.iter().map(|(_, fit)| fit.at[i]).sum::<f64>() / count);
        let errors = std::array::from_fn(|i| {
            let off = slips.iter().map(|(_, fit)| (fit.at[i] - logs[i]).powi(2));
            (off.sum::<f64>() / (count - 1.0) / count).sqrt() * widened(count)
        });
        Self {
            logs,
            errors,
            pull_rad_s,
            damping,
        }
    }

    /// All slips at once; none where some slip can't be followed.
    fn joint(slips: &[(&Cycle, &Fitted)], pull_rad_s: f64, damping: f64) -> Option<Self> {
        let begin = Self::mean(slips, pull_rad_s, damping);
        // The speed over which friction drops is hardly known from one slip, and there are valleys beside the deepest.
        let own = STARTS.map(|factor: f64| begin.logs[2] + factor.ln());
        let pulled = PULLED.map(|factor: f64| (factor * pull_rad_s).ln());
        let tries = own.into_iter().chain(pulled).map(|over| {
            let mut begin = begin;
            begin.logs[2] = over;
            Self::descended(slips, begin)
        });
        let best = tries.flatten();
        let best = best.min_by(|a, b| a.0.total_cmp(&b.0))?;
        Some(best.1)
    }

    /// The same from a law to begin with; and the sum of squares that it leaves.
    fn descended(slips: &[(&Cycle, &Fitted)], begin: Self) -> Option<(f64, Self)> {
        let count = slips.len() as f64;
        let (pull_rad_s, damping) = (begin.pull_rad_s, begin.damping);
        let left = |cycle: &Cycle, at: &[f64; FREE]| off(cycle, at, pull_rad_s, damping);
        let cycles: Vec<&Cycle> = slips.iter().map(|(cycle, _)| *cycle).collect();
        let square = |all: &[[f64; FREE]]| -> Option<f64> {
            let each = cycles.iter().zip(all);
            each.map(|(cycle, at)| Some(left(cycle, at)?.norm_squared()))
                .sum()
        };
        // Where a slip breaks away hangs on the law: it is found anew.
        let placed = cycles
            .iter()
            .map(|cycle| Some(placed(cycle, begin.logs, pull_rad_s, damping)?.at));
        let mut all: Vec<[f64; FREE]> = placed.collect::<Option<_>>()?;
        let mut squares = square(&all)?;
        let mut held = 1e-3;
        let mut abouts = Vec::new();
        for round in 0..ROUNDS {
            let each = cycles.iter().zip(&all);
            let found: Option<Vec<About>> =
                each.map(|(cycle, at)| about(cycle, at, left)).collect();
            abouts = found?;
            if round + 1 == ROUNDS {
                break;
            }
            let before = squares;
            for _ in 0..TRIES {
                let Some(next) = stepped(&all, &abouts, held) else {
                    held *= 6.0;
                    continue;
                };
                match square(&next) {
                    Some(less) if less < squares => {
                        (all, squares) = (next, less);
                        held *= 0.2;
                        break;
                    }
                    _ => held *= 6.0,
                }
            }
            if squares > before * (1.0 - 1e-6) {
                break;
            }
        }
        let inverse = sum(&abouts, |one| one.shared).try_inverse()?;
        let scatter = sum(&abouts, |one| one.right * one.right.transpose());
        let covariance = inverse * scatter * inverse;
        let few = (count / (count - 1.0)).sqrt() * widened(count);
        let errors = std::array::from_fn(|i| few * covariance[(i, i)].max(0.0).sqrt());
        let first = all.first()?;
        let law = Self {
            logs: [first[0], first[1], first[2]],
            errors,
            pull_rad_s,
            damping,
        };
        Some((squares, law))
    }
}

/// Few slips know their own scatter badly.
fn widened(count: f64) -> f64 {
    1.0 + 1.5 / (count - 1.0)
}

fn sum<const C: usize>(
    abouts: &[About],
    part: impl Fn(&About) -> nalgebra::SMatrix<f64, 3, C>,
) -> nalgebra::SMatrix<f64, 3, C> {
    abouts
        .iter()
        .map(part)
        .fold(nalgebra::SMatrix::zeros(), |sum, one| sum + one)
}

fn about(
    cycle: &Cycle,
    at: &[f64; FREE],
    left: impl Fn(&Cycle, &[f64; FREE]) -> Option<DVector<f64>>,
) -> Option<About> {
    let now = left(cycle, at)?;
    let nudges = [
        1e-4,
        1e-4,
        1e-3,
        1e-5 * cycle.times_s.last()?,
        1e-5 * cycle.ways.last()?,
    ];
    let mut slopes = DMatrix::zeros(now.len(), FREE);
    for (i, nudge) in nudges.iter().enumerate() {
        let (mut up, mut down) = (*at, *at);
        up[i] += nudge;
        down[i] -= nudge;
        let slope = (left(cycle, &up)? - left(cycle, &down)?) / (2.0 * nudge);
        slopes.set_column(i, &slope);
    }
    let (gram, right) = (slopes.transpose() * &slopes, slopes.transpose() * &now);
    let own = gram.fixed_view::<2, 2>(3, 3).into_owned().try_inverse()?;
    let own_right = right.fixed_rows::<2>(3).into_owned();
    let both = gram.fixed_view::<3, 2>(0, 3).into_owned();
    Some(About {
        shared: gram.fixed_view::<3, 3>(0, 0) - both * own * both.transpose(),
        right: right.fixed_rows::<3>(0) - both * own * own_right,
        own,
        own_right,
        both,
    })
}

/// All numbers a step further.
fn stepped(all: &[[f64; FREE]], abouts: &[About], held: f64) -> Option<Vec<[f64; FREE]>> {
    let mut firm = sum(abouts, |one| one.shared);
    for i in 0..3 {
        firm[(i, i)] *= 1.0 + held;
    }
    let right = sum(abouts, |one| one.right);
    let step = firm
        .cholesky()?
        .solve(&right)
        .map(|step| step.clamp(-0.5, 0.5));
    let each = all.iter().zip(abouts).map(|(at, about)| {
        let own = about.own * (about.own_right - about.both.transpose() * step);
        [
            at[0] - step[0],
            at[1] - step[1],
            at[2] - step[2],
            at[3] - own[0],
            at[4] - own[1],
        ]
    });
    Some(each.collect())
}

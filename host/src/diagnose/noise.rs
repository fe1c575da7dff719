//! The noise that makes a residual most likely: torque noise, stamps and a slow drift, by the likelihood of the innovations.

use argmin::core::{CostFunction, Executor, State};
use argmin::solver::neldermead::NelderMead;

use super::filter::Noise;
use super::plant::Leaps;
use super::scan::SURE;

/// Edges that the noise is fitted on at the most: parts from all over say as much.
const EDGES_MOST: usize = 12_000;
/// Innovations beyond so many deviations count as if they were linear: they are events, not noise.
pub const FAR: f64 = 4.0;

/// Part of its rate by which a mode that rings is damped at the least: with less it would be a line, which is looked for as such.
const LINE: f64 = 0.02;
/// The same at the most: with more it hardly swings.
const DAMPED: f64 = 0.5;
/// Correlation of what keeps a mode ringing with the torque noise at the most.
const ALIKE: f64 = 0.999;
/// Steps of a fit at the most; a mode that rings has as many numbers again.
const STEPS: u64 = 120;
/// By how much sizes of the noise may be off where a fit begins, as a logarithm.
const FIRST: f64 = 1.5;

/// Edges of a stretch that has a level of its own at the least, stretches of a recording at the most, and the least square of a level
/// over that of all.
const STRETCH: usize = 64;
const STRETCHES: usize = 32;
const LEAST: f64 = 1e-6;

/// Part of the speed that torques which nobody has found yet leave open near a standstill, before the noise is fitted, and at the most.
pub const UNSEEN: f64 = 0.1;

/// Which sizes of the noise are free, and how far out it comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Free {
    /// Torque noise.
    pub torque: bool,
    /// Drift of the acceleration.
    pub drift: bool,
    /// Whether what comes and goes within a turn may be drift.
    pub fast: bool,
    /// How fast a drift fades.
    pub fade: bool,
    /// Stamps.
    pub stamp: bool,
    /// What torques that nobody has found yet leave open near a standstill.
    pub unseen: bool,
    /// A mode that rings.
    pub ring: bool,
    /// How far out innovations come.
    pub tails: Tails,
}

/// How often innovations are far out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tails {
    /// As normal noise is.
    #[default]
    Normal,
    /// As Student's distribution of a few degrees has it (Student, Biometrika 6, 1908).
    Student,
}

/// Degrees of freedom of Student's distribution: its tails, no longer, are those of impulses on a line or of a busy interrupt.
const DEGREES: f64 = 4.0;

impl Tails {
    /// Twice the negative logarithm of the density of an innovation over its deviation, beside that of normal noise at 0.
    #[must_use]
    pub fn cost(self, white: f64) -> f64 {
        /// Twice the logarithm by which the density of Student's distribution at 0 is below the normal one: 3/8 over 1/sqrt(2 pi).
        const LOWER: f64 = 0.123_781_4;
        match self {
            Self::Normal => white * white,
            Self::Student => (DEGREES + 1.0) * (white * white / DEGREES).ln_1p() + LOWER,
        }
    }

    /// Weight of an innovation in least squares, whose square makes them stationary where the density is.
    #[must_use]
    fn weight(self, white: f64) -> f64 {
        match self {
            Self::Normal => 1.0,
            Self::Student => ((DEGREES + 1.0) / (DEGREES + white * white)).sqrt(),
        }
    }

    /// Weights of innovations. Those of late captures are skewed: about zero their weights would pull a fit off their mean, which torques
    /// or a drive's numbers would then make up for. So they go about the value at which the mean stays.
    #[must_use]
    pub fn weights(self, white: &[f64]) -> Vec<f64> {
        let about = |center: f64| white.iter().map(move |white| self.weight(white - center));
        if self == Self::Normal {
            return about(0.0).collect();
        }
        let count = white.len().max(1) as f64;
        let mean = white.iter().sum::<f64>() / count;
        let off = |center: f64| {
            let each = about(center).zip(white);
            let (sum, weights) = each.fold((0.0, 0.0), |(sum, weights), (weight, white)| {
                (
                    sum + weight * weight * (white - mean),
                    weights + weight * weight,
                )
            });
            sum / weights
        };
        let error = (square(white) / count).sqrt();
        let skewed = off(0.0);
        if skewed.abs() <= FAR * error {
            return about(0.0).collect();
        }
        let (mut near, mut far) = (0.0, -FAR.copysign(skewed));
        while (far - near).abs() > error {
            let middle = 0.5 * (near + far);
            if off(middle) * skewed > 0.0 {
                near = middle;
            } else {
                far = middle;
            }
        }
        about(0.5 * (near + far)).collect()
    }

    /// What counts in a fit of the noise: what is far out of normal noise is an event.
    fn fitted(self, white: f64) -> f64 {
        match self {
            Self::Normal => huber(white),
            Self::Student => self.cost(white),
        }
    }
}

/// Residual angles of one recording, with the filter's steps and the weight of each edge.
#[derive(Clone, Copy, Debug)]
pub struct Rest<'a> {
    /// The steps.
    pub leaps: &'a Leaps,
    /// The angles, rad.
    pub angles: &'a [f64],
    /// The weights.
    pub weights: &'a [f64],
}

struct Problem<'a> {
    rests: &'a [Rest<'a>],
    parts: Vec<(usize, std::ops::Range<usize>)>,
    start: Noise,
    least_stamp_s: f64,
    /// Mean speed, rad/s: the circular frequency of once a turn.
    turning: f64,
    free: Free,
}

impl Problem<'_> {
    fn noise(&self, logs: &[f64]) -> Noise {
        let mut logs = logs.iter();
        let mut noise = self.start;
        let mut next = |free: bool, was: f64| {
            let log = if free { logs.next() } else { None };
            log.map_or(was, |log| log.exp())
        };
        noise.torque = next(self.free.torque, noise.torque);
        let over = next(self.free.stamp, 0.0);
        if self.free.stamp {
            noise.stamp_s = self.least_stamp_s.hypot(over);
        }
        // Of one that fades, its density far below where it does.
        noise.drift = next(self.free.drift, noise.drift);
        if self.free.drift && !self.free.fast {
            // What comes and goes within a turn is no drift of the drive.
            noise.drift = noise.drift.min(noise.torque * self.turning * self.turning);
        }
        if self.free.fade {
            noise.fade = next(true, noise.fade);
            noise.drift *= noise.fade * noise.fade;
        }
        noise.unseen = next(self.free.unseen, noise.unseen).min(UNSEEN);
        if self.free.ring {
            let ring = &mut noise.ring;
            ring.density = next(true, ring.density);
            ring.rate = next(true, ring.rate);
            let damping = next(true, ring.damping);
            ring.damping = damping.clamp(LINE * ring.rate, DAMPED * ring.rate);
            // A logarithm of any size makes a correlation.
            let odds = next(true, 1.0).powi(2);
            ring.shared = ALIKE * (1.0 - 2.0 / (odds + 1.0));
        }
        noise
    }

    fn cost_of(&self, noise: &Noise) -> f64 {
        use rayon::prelude::*;
        let each: Vec<f64> = self
            .parts
            .par_iter()
            .map(|(bench, range)| {
                let rest = self.rests[*bench];
                let filter = rest.leaps.filter(range.clone(), noise);
                let mut white = rest.angles[range.clone()].to_vec();
                filter.whiten(&mut white);
                let scales = filter.scales();
                let weights = &rest.weights[range.clone()];
                let each = white.iter().zip(weights).zip(scales);
                // A noise that can't be has no deviations.
                each.filter(|(_, scale)| *scale != 0.0)
                    .map(|((white, weight), scale)| {
                        self.free.tails.fitted(white * weight) - 2.0 * scale.ln()
                    })
                    .sum::<f64>()
            })
            .collect();
        let sum: f64 = each.iter().sum();
        if sum.is_finite() { sum } else { f64::MAX / 1e6 }
    }
}

impl CostFunction for Problem<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, logs: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        Ok(self.cost_of(&self.noise(logs)))
    }
}

/// Square of an innovation, straight where it is far out.
#[must_use]
pub fn huber(white: f64) -> f64 {
    let size = white.abs();
    if size < FAR {
        size * size
    } else {
        FAR * (2.0 * size - FAR)
    }
}

/// Parts of a recording that the noise is fitted on.
fn parts(edges: usize, most: usize) -> Vec<std::ops::Range<usize>> {
    const PARTS: usize = 3;
    if edges <= most {
        return std::iter::once(0..edges).collect();
    }
    let length = most / PARTS;
    let gap = (edges - length) / (PARTS - 1);
    (0..PARTS).map(|at| at * gap..at * gap + length).collect()
}

/// Fits the noise to residual angles of recordings of one rig. Returns it with twice the negative logarithm of the likelihood.
#[must_use]
pub fn fit(rests: &[Rest<'_>], least_stamp_s: f64, start: Noise, free: Free) -> (Noise, f64) {
    let edges: usize = rests.iter().map(|rest| rest.angles.len()).sum();
    let parts = rests.iter().enumerate().flat_map(|(bench, rest)| {
        let most = (EDGES_MOST * rest.angles.len() / edges.max(1)).max(600);
        parts(rest.angles.len(), most)
            .into_iter()
            .map(move |range| (bench, range))
    });
    let free = Free {
        unseen: free.unseen && rests.iter().any(|rest| rest.leaps.has_unseen()),
        ..free
    };
    let problem = Problem {
        rests,
        parts: parts.collect(),
        start,
        least_stamp_s,
        turning: rests.iter().map(|rest| rest.leaps.speed()).sum::<f64>()
            / rests.len().max(1) as f64,
        free,
    };
    let over = (start.stamp_s.powi(2) - least_stamp_s.powi(2))
        .max(1e-2 * least_stamp_s.powi(2))
        .sqrt();
    let slow = if free.fade { start.fade.powi(2) } else { 1.0 };
    let ring = start.ring;
    // Each with how far off it may be at first, as a logarithm.
    let first = [
        (free.torque, start.torque.max(1e-30), FIRST),
        (free.stamp, over, FIRST),
        (free.drift, (start.drift / slow).max(1e-30), FIRST),
        (free.fade, start.fade, FIRST),
        (free.unseen, start.unseen.max(1e-30), FIRST),
        (free.ring, ring.density.max(1e-30), FIRST),
        (free.ring, ring.rate, 0.5 * ring.damping / ring.rate),
        (free.ring, ring.damping, FIRST),
        (
            free.ring,
            ((ALIKE + ring.shared) / (ALIKE - ring.shared)).sqrt(),
            FIRST,
        ),
    ];
    let first = first.iter().filter(|(free, ..)| *free);
    let (first, aparts): (Vec<f64>, Vec<f64>) =
        first.map(|(_, size, step)| (size.ln(), *step)).unzip();
    if first.is_empty() {
        let cost = problem.cost_of(&start);
        return (start, cost);
    }
    let steps = if free.ring { 2 * STEPS } else { STEPS };
    let mut corners = vec![first.clone(); first.len() + 1];
    for (at, apart) in aparts.into_iter().enumerate() {
        corners[at + 1][at] += apart;
    }
    let run = NelderMead::new(corners)
        .with_sd_tolerance(0.05)
        .and_then(|solver| {
            let run = Executor::new(problem, solver);
            run.configure(|state| state.max_iters(steps)).run()
        });
    let Ok(ended) = run else {
        return (start, f64::INFINITY);
    };
    let best = ended.state().get_best_param().unwrap_or(&first);
    let problem = ended.problem().problem.as_ref();
    let noise = problem.map_or(start, |problem| problem.noise(best));
    (noise, ended.state().get_best_cost())
}

/// Level of the noise at each edge over that of all, by stretches of a recording; 1 throughout where that is not sure.
#[must_use]
pub fn levels(white: &[f64], edges_of_a_turn: usize) -> Vec<f64> {
    let length = STRETCH.max(edges_of_a_turn).max(white.len() / STRETCHES);
    let stretches = white.len() / length;
    let all = square(white);
    if stretches < 2 || all <= 0.0 {
        return vec![1.0; white.len()];
    }
    let unit = all.sqrt();
    let stretch_of = |at: usize| (at / length).min(stretches - 1);
    let squares: Vec<f64> = (0..stretches)
        .map(|stretch| {
            let last = stretch + 1 == stretches;
            let until = if last {
                white.len()
            } else {
                (stretch + 1) * length
            };
            let here = &white[stretch * length..until];
            let each = here.iter().map(|white| huber(white / unit));
            (each.sum::<f64>() / here.len() as f64).max(LEAST)
        })
        .collect();
    let logs = (0..white.len()).map(|at| squares[stretch_of(at)].ln());
    let mean = logs.sum::<f64>() / white.len() as f64;
    let whole = squares.iter().sum::<f64>() / stretches as f64;
    // Twice the logarithm of the likelihood that levels of their own gain, less what they would by chance.
    let gain = white.len() as f64 * (whole.ln() - mean);
    if gain < stretches as f64 * (white.len() as f64).ln() + SURE {
        return vec![1.0; white.len()];
    }
    (0..white.len())
        .map(|at| (0.5 * (squares[stretch_of(at)].ln() - mean)).exp())
        .collect()
}

/// Mean square.
fn square(white: &[f64]) -> f64 {
    white.iter().map(|white| white * white).sum::<f64>() / white.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_innovations_that_are_all_alike_are_alike() {
        for white in [0.0, 2.0] {
            let weights = Tails::Student.weights(&[white; 100]);
            assert!(weights.iter().all(|weight| *weight == weights[0]));
        }
    }

    #[test]
    fn weights_leave_the_mean_of_skewed_noise_where_it_is() {
        // Quantiles of an exponential and of a normal-like distribution about their means.
        let shares = (0..4000).map(|at| (f64::from(at) + 0.5) / 4000.0);
        let skewed: Vec<f64> = shares
            .clone()
            .map(|share| -(1.0 - share).ln() - 1.0)
            .collect();
        let even: Vec<f64> = shares
            .map(|share| (share / (1.0 - share)).ln() / 1.8)
            .collect();
        let mean = |white: &[f64], weights: &[f64]| {
            let each = white.iter().zip(weights);
            let squares: f64 = weights.iter().map(|weight| weight * weight).sum();
            each.map(|(white, weight)| white * weight * weight)
                .sum::<f64>()
                / squares
        };
        let plainly: Vec<f64> = skewed
            .iter()
            .map(|white| Tails::Student.weight(*white))
            .collect();
        assert!(mean(&skewed, &plainly) < -0.1);
        assert!(mean(&skewed, &Tails::Student.weights(&skewed)).abs() < 0.01);
        let plainly: Vec<f64> = even
            .iter()
            .map(|white| Tails::Student.weight(*white))
            .collect();
        assert_eq!(Tails::Student.weights(&even), plainly);
    }
}

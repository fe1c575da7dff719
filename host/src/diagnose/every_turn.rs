//! What comes again every turn, before anything is known of the noise.
//!
//! A disc that the twin does not know may err by far more than the shaft wanders. Noise that is fitted to all of it drowns the disc, and
//! what of the disc is drowned looks like torque at other speeds. The mean of each edge over the turns, each turn taken from its own
//! first mark to the next turn's, is the disc's whatever the noise is; more than the disc's, so it serves to guess the noise alone.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex;

use super::seen::Seen;

/// Turns that a mean needs.
const TURNS_LEAST: f64 = 3.0;
/// Low orders, of which a disc errs most: where edges are many and turns few, more are not worth their numbers.
const LOW: usize = 64;

/// The mean of each edge of the disc over the turns.
#[derive(Clone, Debug)]
pub struct EveryTurn {
    means: Vec<f64>,
    /// Mean number of turns that it is of.
    pub turns: f64,
}

impl EveryTurn {
    /// Of a residual; none where there are too few turns in one go.
    #[must_use]
    pub fn of(seen: &Seen) -> Option<Self> {
        let edges = usize::try_from(seen.edges).ok()?;
        let (mut sums, mut counts) = (vec![0.0; edges], vec![0.0; edges]);
        let mut first = 0_usize;
        while let Some(last) = first.checked_add(edges).filter(|last| *last < seen.len()) {
            let whole = seen.places[last].abs_diff(seen.places[first]) == edges as u64;
            let mut between = seen.readings[first + 1..=last].iter();
            if !whole || between.any(|one| one.fresh || one.anew) {
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
        let means = sums.iter().zip(&counts).map(|(sum, count)| sum / count);
        Some(Self {
            means: means.collect(),
            turns,
        })
    }

    /// A residual without it, and how many numbers that took: without all of it, and without its low orders alone.
    #[must_use]
    pub fn off(&self, seen: &Seen) -> Vec<(Vec<f64>, usize)> {
        let edges = self.means.len();
        let without = |means: &[f64]| -> Vec<f64> {
            let each = seen.angles.iter().enumerate();
            each.map(|(at, angle)| angle - means[seen.edge(at)])
                .collect()
        };
        let mut all = vec![(without(&self.means), edges)];
        if 2 * LOW < edges {
            all.push((without(&self.low()), 2 * LOW));
        }
        all
    }

    /// Its low orders.
    fn low(&self) -> Vec<f64> {
        let edges = self.means.len();
        let mut planner = RealFftPlanner::<f64>::new();
        let forward = planner.plan_fft_forward(edges);
        let inverse = planner.plan_fft_inverse(edges);
        let mut spectrum = forward.make_output_vec();
        let mut low = inverse.make_output_vec();
        let _ = forward.process(&mut self.means.clone(), &mut spectrum);
        for (order, value) in spectrum.iter_mut().enumerate() {
            *value = if order <= LOW {
                *value / edges as f64
            } else {
                Complex::ZERO
            };
        }
        let _ = inverse.process(&mut spectrum, &mut low);
        low
    }
}

#[cfg(test)]
mod tests {
    use super::EveryTurn;
    use crate::diagnose::kalman::Reading;
    use crate::diagnose::seen::Seen;
    use crate::diagnose::shaft::Leap;

    const EDGES: i64 = 400;

    fn seen(error: impl Fn(f64) -> f64) -> Seen {
        let leap = Leap {
            after_s: 1e-3,
            damping: 0.0,
            spring: None,
        };
        let reading = Reading {
            leap,
            speed: 1.0,
            at_s: 0.0,
            fresh: false,
            anew: false,
            jolt: 0.0,
            doubt_s: 0.0,
        };
        let places: Vec<i64> = (150..150 + 5 * EDGES + 30).collect();
        let angle = |place: &i64| {
            let turns = *place as f64 / EDGES as f64;
            error(turns * std::f64::consts::TAU) + 0.3 * turns
        };
        Seen {
            edges: EDGES,
            classes: 4,
            angles: places.iter().map(angle).collect(),
            readings: vec![reading; places.len()],
            places,
            ..Seen::default()
        }
    }

    /// Largest step from edge to edge.
    fn roughest(angles: &[f64]) -> f64 {
        angles
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn a_disc_goes_and_a_drift_stays() {
        let seen = seen(|angle| 0.05 * angle.sin() + 0.02 * (180.0 * angle).cos());
        let every = EveryTurn::of(&seen).unwrap();
        assert!((every.turns - 5.0).abs() < 1e-9);
        let off = every.off(&seen);
        let drift = 0.3 / EDGES as f64;
        assert_eq!((off[0].1, off[1].1), (400, 128));
        assert!(roughest(&off[0].0) < 1.001 * drift);
        // Of high orders the low ones know nothing.
        assert!(roughest(&off[1].0) > 0.02);
    }
}

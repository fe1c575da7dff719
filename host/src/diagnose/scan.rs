//! Regular rhythms in a white residual, along the angle or the time.

use realfft::RealFftPlanner;

/// A row of complex amplitudes of a white residual; entry j is at j / `points` cycles a sample, and its squared size has mean 1 and
/// an exponential distribution where there is noise alone.
#[derive(Clone, Debug)]
pub struct Spectrum {
    /// Samples that the row is of, padded.
    pub points: usize,
    /// Squared sizes.
    pub powers: Vec<f64>,
}

impl Spectrum {
    /// Of a white residual, one number an edge.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn of(white: &[f64]) -> Self {
        // Twice as long, so that a rhythm between two bins is not missed.
        let points = good_size(2 * white.len());
        let mut planner = RealFftPlanner::<f64>::new();
        let forward = planner.plan_fft_forward(points);
        let mut input = forward.make_input_vec();
        input[..white.len()].copy_from_slice(white);
        let mut output = forward.make_output_vec();
        // Sizes are the plan's own.
        let _ = forward.process(&mut input, &mut output);
        let scale = 1.0 / white.len().max(1) as f64;
        Self {
            points,
            powers: output.iter().map(|x| x.norm_sqr() * scale).collect(),
        }
    }

    /// Cycles a sample at an entry.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn frequency(&self, at: usize) -> f64 {
        at as f64 / self.points as f64
    }

    /// Power that noise alone exceeds anywhere with this probability.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn threshold(&self, probability: f64) -> f64 {
        // Twice as many bins as there are independent ones, half of what padding adds counts.
        (self.powers.len() as f64 / probability).ln()
    }

    /// Entries above a power that are the largest around.
    #[must_use]
    pub fn peaks(&self, above: f64) -> Vec<(usize, f64)> {
        let reach = 4;
        let at_peak = |&at: &usize| {
            let power = self.powers[at];
            let from = at.saturating_sub(reach);
            let around = &self.powers[from..(at + reach + 1).min(self.powers.len())];
            power > above && around.iter().all(|other| *other <= power)
        };
        (1..self.powers.len())
            .filter(at_peak)
            .map(|at| (at, self.powers[at]))
            .collect()
    }
}

/// The next number from `least` on that has factors 2, 3 and 5 only and is even.
fn good_size(least: usize) -> usize {
    let smooth = |n: usize| {
        let mut rest = n;
        for factor in [2, 3, 5] {
            while rest.is_multiple_of(factor) {
                rest /= factor;
            }
        }
        rest == 1
    };
    (least.max(2)..)
        .find(|n| n.is_multiple_of(2) && smooth(*n))
        .unwrap_or(least)
}

//! Rhythms in a white residual, along the turn or along time, of edges alike or against each other.

use realfft::RealFftPlanner;

/// Squared amplitudes of a row of numbers; where there is noise alone, each has mean 1 and an exponential distribution.
#[derive(Clone, Debug)]
pub struct Spectrum {
    /// Cycles a unit of the coordinate, from one entry to the next.
    pub step: f64,
    /// Squared amplitudes.
    pub powers: Vec<f64>,
}

impl Spectrum {
    /// Of numbers at places from 0 up to `length` of a coordinate, put into cells of a width; what is faster than `most` cycles a
    /// unit is left out.
    #[must_use]
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn of(
        numbers: impl Iterator<Item = (f64, f64)>,
        length: f64,
        cell: f64,
        most: f64,
    ) -> Self {
        // Twice as long, so that a rhythm between two entries is not missed.
        let cells = good_size(((2.0 * length / cell) as usize).max(64));
        let mut planner = RealFftPlanner::<f64>::new();
        let forward = planner.plan_fft_forward(cells);
        let mut input = forward.make_input_vec();
        let mut sum = 0.0;
        for (place, value) in numbers {
            // Shared by the two cells that it lies between.
            let at = (place / cell).max(0.0);
            let low = (at as usize).min(cells / 2);
            let share = at - low as f64;
            input[low] += value * (1.0 - share);
            input[low + 1] += value * share;
            sum += value * value;
        }
        let mut output = forward.make_output_vec();
        // Sizes are the plan's own.
        let _ = forward.process(&mut input, &mut output);
        let step = 1.0 / (cells as f64 * cell);
        let entries = ((most / step) as usize + 1).min(output.len());
        let scale = 1.0 / sum.max(f64::MIN_POSITIVE);
        let powers = output[..entries].iter();
        Self {
            step,
            powers: powers.map(|x| x.norm_sqr() * scale).collect(),
        }
    }

    /// Power that noise alone exceeds anywhere with this probability.
    #[must_use]
    pub fn threshold(&self, probability: f64) -> f64 {
        (self.powers.len() as f64 / probability).ln()
    }

    /// The strongest peaks above a power: cycles a unit and power, strongest first.
    #[must_use]
    pub fn peaks(&self, above: f64, most: usize) -> Vec<(f64, f64)> {
        let reach = 5;
        let mut peaks: Vec<(f64, f64)> = Vec::new();
        for at in 0..self.powers.len() {
            let power = self.powers[at];
            if power <= above {
                continue;
            }
            let around =
                &self.powers[at.saturating_sub(reach)..(at + reach + 1).min(self.powers.len())];
            if around.iter().any(|other| *other > power) {
                continue;
            }
            let side = |at: Option<usize>| {
                at.and_then(|at| self.powers.get(at))
                    .map_or(0.0, |p| p.sqrt())
            };
            let (before, here, after) = (side(at.checked_sub(1)), power.sqrt(), side(Some(at + 1)));
            let bend = before - 2.0 * here + after;
            let shift = if at == 0 || bend >= 0.0 {
                0.0
            } else {
                0.5 * (before - after) / bend
            };
            peaks.push(((at as f64 + shift) * self.step, power));
        }
        peaks.sort_by(|a, b| b.1.total_cmp(&a.1));
        peaks.truncate(most);
        peaks
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

//! The number of edges a turn of a sensor without an index, from the pattern that its intervals repeat.

/// Intervals looked at, at the most.
pub const INTERVALS_MAX: usize = 20_000;

/// How well intervals repeat every `edges` of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeat {
    /// Edges a turn.
    pub edges: usize,
    /// Variance left of the relative intervals once the pattern is taken out, degrees of freedom counted.
    pub left: f64,
    /// Variance before.
    pub total: f64,
}

impl Repeat {
    /// Of relative intervals (see [`relative`]) at a period of `edges`. None with fewer than four turns.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn of(relative: &[f64], edges: usize) -> Option<Self> {
        if edges < 2 || relative.len() < 4 * edges {
            return None;
        }
        // Starts and stops make a few wild intervals; neither they nor their squares may decide.
        let medians = slot_medians(relative, edges);
        let rest: Vec<f64> = relative
            .iter()
            .enumerate()
            .map(|(k, y)| (y - medians[k % edges]).powi(2))
            .collect();
        let freedom = (relative.len() - edges) as f64 / relative.len() as f64;
        let left = trimmed_mean(rest) / freedom;
        let total = trimmed_mean(relative.iter().map(|y| y * y).collect());
        Some(Self { edges, left, total })
    }

    /// The shortest period, among multiples of `unit` up to `most`, on which no longer one improves beyond chance; none if it
    /// does not explain half of the variance.
    #[must_use]
    pub fn shortest(relative: &[f64], unit: usize, most: usize) -> Option<Self> {
        let all = (1..=most / unit).filter_map(|multiple| Self::of(relative, multiple * unit));
        let best = all.reduce(|best, next| {
            if next.improves(&best, relative.len()) {
                next
            } else {
                best
            }
        })?;
        (best.left < 0.5 * best.total).then_some(best)
    }

    /// Whether a longer period explains more of `count` intervals than its extra edges would by chance: the likelihood ratio is
    /// then chi-squared with as many degrees of freedom as there are extra edges, and six of its deviations are asked for.
    #[allow(clippy::cast_precision_loss)]
    fn improves(&self, shorter: &Self, count: usize) -> bool {
        let extra = (self.edges - shorter.edges) as f64;
        let count = count as f64;
        let squares = |repeat: &Self| repeat.left * (count - repeat.edges as f64);
        count * (squares(shorter) / squares(self)).ln() - extra > 6.0 * (2.0 * extra).sqrt()
    }
}

fn slot_medians(values: &[f64], edges: usize) -> Vec<f64> {
    let slot = |slot: usize| {
        values
            .iter()
            .skip(slot)
            .step_by(edges)
            .copied()
            .collect::<Vec<_>>()
    };
    (0..edges).map(|k| median(slot(k))).collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    let half = values.len() / 2;
    *values.select_nth_unstable_by(half, f64::total_cmp).1
}

/// Mean of the smaller nine tenths.
#[allow(clippy::cast_precision_loss)]
fn trimmed_mean(mut values: Vec<f64>) -> f64 {
    let kept = values.len() * 9 / 10;
    values.select_nth_unstable_by(kept, f64::total_cmp);
    values[..kept].iter().sum::<f64>() / kept as f64
}

/// Each interval over the mean of the few around it, less one: what is left of a slow change of speed is small, and a
/// pattern that repeats after any number of edges still does.
#[must_use]
#[allow(clippy::cast_precision_loss)]
pub fn relative(intervals: &[f64]) -> Vec<f64> {
    const REACH: usize = 3;
    intervals
        .windows(2 * REACH + 1)
        .map(|window| {
            // Half weight at the ends makes the mean one of 2 REACH intervals, centred.
            let ends = (window[0] + window[2 * REACH]) / 2.0;
            let mean = (window[1..2 * REACH].iter().sum::<f64>() + ends) / (2 * REACH) as f64;
            window[REACH] / mean - 1.0
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Intervals of a pattern on a shaft whose speed swings slowly, with a little noise.
    fn intervals(pattern: &[f64], turns: usize) -> Vec<f64> {
        let mut noise = 1_u32;
        (0..pattern.len() * turns)
            .map(|k| {
                noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let jitter = f64::from(noise >> 16) / 65_536.0 - 0.5;
                (1.0 + pattern[k % pattern.len()] + 0.01 * jitter)
                    * (1.0 + 0.3 * (k as f64 / 500.0).sin())
            })
            .collect()
    }

    #[test]
    fn the_shortest_repeating_turn_is_found() {
        let pattern = [
            0.1, -0.05, 0.02, -0.1, 0.06, -0.03, 0.0, 0.04, -0.02, 0.03, -0.06, 0.01,
        ];
        let found = Repeat::shortest(&relative(&intervals(&pattern, 200)), 6, 60).unwrap();
        assert_eq!(found.edges, 12);
        assert!(found.left < 0.05 * found.total);
    }

    #[test]
    fn even_intervals_show_no_turn() {
        assert_eq!(
            Repeat::shortest(&relative(&intervals(&[0.0; 6], 300)), 6, 60),
            None
        );
    }
}

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
    /// Of `intervals` at a period of `edges`. Each interval is held against the mean of the whole turn around it, which holds
    /// no pattern of that period. None with fewer than three turns.
    #[must_use]
    #[allow(clippy::cast_precision_loss)]
    pub fn of(intervals: &[f64], edges: usize) -> Option<Self> {
        if edges < 2 || intervals.len() < 4 * edges {
            return None;
        }
        let mut times = Vec::with_capacity(intervals.len() + 1);
        times.push(0.0);
        for interval in intervals {
            times.push(times[times.len() - 1] + interval);
        }
        let before = edges / 2;
        let relative: Vec<f64> = (before..intervals.len() + before + 1 - edges)
            .map(|k| {
                intervals[k] * edges as f64 / (times[k - before + edges] - times[k - before]) - 1.0
            })
            .collect();
        let mut sums = vec![(0.0, 0.0); edges];
        for (k, y) in relative.iter().enumerate() {
            sums[k % edges].0 += y;
            sums[k % edges].1 += 1.0;
        }
        let mean = |k: usize| sums[k % edges].0 / sums[k % edges].1;
        let freedom = (relative.len() - edges).max(1) as f64;
        let left = relative
            .iter()
            .enumerate()
            .map(|(k, y)| (y - mean(k)).powi(2))
            .sum::<f64>()
            / freedom;
        let total = relative.iter().map(|y| y * y).sum::<f64>() / relative.len() as f64;
        Some(Self { edges, left, total })
    }

    /// The shortest period, among multiples of `unit` up to `most`, that leaves hardly more than the best one does; none if no
    /// period explains half of the variance.
    #[must_use]
    pub fn shortest(intervals: &[f64], unit: usize, most: usize) -> Option<Self> {
        let all: Vec<Self> = (1..=most / unit)
            .filter_map(|multiple| Self::of(intervals, multiple * unit))
            .collect();
        let best = all
            .iter()
            .map(|repeat| repeat.left)
            .fold(f64::INFINITY, f64::min);
        all.into_iter()
            .find(|repeat| repeat.left <= 1.1 * best && repeat.left < 0.5 * repeat.total)
    }
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
        let found = Repeat::shortest(&intervals(&pattern, 200), 6, 60).unwrap();
        assert_eq!(found.edges, 12);
        assert!(found.left < 0.05 * found.total);
    }

    #[test]
    fn even_intervals_show_no_turn() {
        assert_eq!(Repeat::shortest(&intervals(&[0.0; 6], 300), 6, 60), None);
    }
}

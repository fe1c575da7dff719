//! What slips differ by among each other, and whether what they have in common is more than that.
//!
//! Torque noise moves each slip in a way of its own, and so does whatever hangs on the place; what a law of all slips is wrong by, all
//! of them have in common. Residuals are brought to the same points of a slip; their mean over the slips is held against their
//! scatter by Fisher's F, with as many degrees of freedom as the scatter's shape has (F. E. Satterthwaite, Biometrics Bulletin 2, 1946)
//! and E. Paulson's normal approximation of F (Annals of Mathematical Statistics 13, 1942).

/// Points of a slip.
const POINTS: usize = 32;
/// Slips needed.
const LEAST: usize = 3;

/// How slips scatter.
#[derive(Clone, Copy, Debug)]
pub struct Scatter {
    /// Mean square by which slips differ, rad^2.
    noise: f64,
    /// Square of what the law itself is good to, rad^2.
    accuracy: f64,
    /// Degrees of freedom of one slip's shape.
    freedom: f64,
}

impl Scatter {
    /// Of the residuals of slips, rad; none of too few. What all have in common up to `accuracy_rad` says nothing.
    #[must_use]
    pub fn of<'a>(slips: impl Iterator<Item = &'a [f64]>, accuracy_rad: f64) -> Option<Self> {
        let rows: Vec<[f64; POINTS]> = slips.map(points).collect();
        if rows.len() < LEAST {
            return None;
        }
        let mean = mean(&rows);
        let own: Vec<[f64; POINTS]> = rows
            .iter()
            .map(|row| std::array::from_fn(|i| row[i] - mean[i]))
            .collect();
        let count = rows.len() as f64;
        let noise = own.iter().map(|row| product(row, row)).sum::<f64>() / (count - 1.0);
        let mut across = 0.0;
        for (i, one) in own.iter().enumerate() {
            across += own[..i]
                .iter()
                .map(|o| product(one, o).powi(2))
                .sum::<f64>();
        }
        across /= 0.5 * count * (count - 1.0);
        let freedom = (noise * noise / across).clamp(1.0, POINTS as f64);
        Some(Self {
            noise,
            accuracy: accuracy_rad * accuracy_rad,
            freedom: if freedom.is_nan() { 1.0 } else { freedom },
        })
    }

    /// What slips leave that have nothing in common, rad RMS.
    #[must_use]
    pub fn floor_rad(&self) -> f64 {
        (self.noise + self.accuracy).sqrt()
    }

    /// Probability that slips that scatter like this have as much in common as these; none of too few.
    #[must_use]
    pub fn p<'a>(&self, slips: impl Iterator<Item = &'a [f64]>) -> Option<f64> {
        let rows: Vec<[f64; POINTS]> = slips.map(points).collect();
        if rows.len() < LEAST {
            return None;
        }
        let mean = mean(&rows);
        let count = rows.len() as f64;
        let ratio = count * product(&mean, &mean) / (self.noise + count * self.accuracy);
        let p = exceeded(ratio, self.freedom, self.freedom * (count - 1.0));
        p.is_finite().then_some(p)
    }
}

/// Probability that F with these degrees of freedom is greater.
fn exceeded(ratio: f64, own: f64, others: f64) -> f64 {
    let (own, others) = (2.0 / (9.0 * own), 2.0 / (9.0 * others));
    let root = ratio.cbrt();
    upper(((1.0 - others) * root - (1.0 - own)) / (others * root * root + own).sqrt())
}

/// Probability that a normal number is so many deviations up or more.
#[must_use]
pub fn upper(deviations: f64) -> f64 {
    0.5 * libm::erfc(deviations / std::f64::consts::SQRT_2)
}

/// Deviations of a normal number that are as rare as Student's t (D. L. Wallace, Annals of Mathematical Statistics 30, 1959).
#[must_use]
pub fn normal(t: f64, freedom: f64) -> f64 {
    let plain = (freedom * (t * t / freedom).ln_1p()).sqrt();
    (8.0 * freedom + 1.0) / (8.0 * freedom + 3.0) * plain
}

/// A residual at the points, along its edges.
fn points(row: &[f64]) -> [f64; POINTS] {
    let last = row.len().saturating_sub(1);
    std::array::from_fn(|i| {
        let at = i as f64 / (POINTS - 1) as f64 * last as f64;
        let index = (at as usize).min(last.saturating_sub(1));
        let value = |at: usize| row.get(at).copied().unwrap_or(0.0);
        value(index) + (at - index as f64) * (value(index + 1) - value(index))
    })
}

fn mean(rows: &[[f64; POINTS]]) -> [f64; POINTS] {
    std::array::from_fn(|i| rows.iter().map(|row| row[i]).sum::<f64>() / rows.len() as f64)
}

fn product(a: &[f64; POINTS], b: &[f64; POINTS]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / POINTS as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt as _, SeedableRng as _};
    use rand_chacha::ChaCha8Rng;

    /// Slips of smooth noise about what they have in common, and the share of draws in which that is taken for noise.
    fn said(common: f64, slips: usize) -> Vec<f64> {
        let mut p = Vec::new();
        for seed in 0..200 {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let rows: Vec<Vec<f64>> = (0..slips)
                .map(|_| {
                    let sizes: [f64; 3] = std::array::from_fn(|_| random.random_range(-1.0..1.0));
                    let at = |i: usize| i as f64 / 99.0;
                    (0..100)
                        .map(|i| {
                            let waves = sizes.iter().zip(1..);
                            let sum: f64 = waves
                                .map(|(s, n)| s * (3.0 * f64::from(n) * at(i)).sin())
                                .sum();
                            sum + common * (2.0 * at(i)).cos()
                        })
                        .collect()
                })
                .collect();
            let rows = || rows.iter().map(Vec::as_slice);
            p.push(Scatter::of(rows(), 1e-9).unwrap().p(rows()).unwrap());
        }
        p
    }

    #[test]
    fn noise_is_seldom_taken_for_something_in_common_and_what_is_in_common_never_for_noise() {
        for slips in [4, 12, 48] {
            let none = said(0.0, slips);
            let below = |limit: f64| none.iter().filter(|p| **p < limit).count();
            assert!((2..=25).contains(&below(0.05)), "{slips}: {}", below(0.05));
            assert_eq!(below(1e-6), 0, "{slips}");
        }
        assert!(said(3.0, 48).iter().all(|p| *p < 1e-6));
    }

    #[test]
    fn a_t_of_few_is_worth_less() {
        // P(|t| > 12.924) with 3 degrees of freedom is 0.001, that of a normal number beyond 3.2905.
        assert!((normal(12.924, 3.0) - 3.2905).abs() < 0.1);
        assert!((normal(3.0, 1e6) - 3.0).abs() < 1e-4);
    }
}

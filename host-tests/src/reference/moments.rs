//! How turns of different speed count: shares of turns in means and contrasts.

use super::turns::Turn;

/// Means over turns, as shares of every turn.
#[derive(Debug, Clone)]
pub(super) struct Moments {
    /// Turns weighed by 2^-bin, about the square of their speed.
    pub weighed: Vec<f64>,
    /// Turns alike.
    pub plain: Vec<f64>,
    /// Squared duration as either mean has it.
    weighed_square: f64,
    plain_square: f64,
    /// `weighed_square` over the difference of the two, where the speeds differ.
    pub separation: Option<f64>,
}

impl Moments {
    pub(super) fn of(turns: &[Turn]) -> Self {
        let weights: Vec<f64> = turns
            .iter()
            .map(|turn| f64::from(-turn.bin).exp2())
            .collect();
        let total: f64 = weights.iter().sum();
        let weighed: Vec<f64> = weights.iter().map(|weight| weight / total).collect();
        let plain = vec![1.0 / turns.len() as f64; turns.len()];
        let square = |shares: &[f64]| dot(shares, turns, |turn| turn.ratio.powi(2));
        let (weighed_square, plain_square) = (square(&weighed), square(&plain));
        let longest = turns.iter().map(|turn| turn.ratio).fold(0.0, f64::max);
        let shortest = turns.iter().map(|turn| turn.ratio).fold(f64::MAX, f64::min);
        let separation = weighed_square / (plain_square - weighed_square);
        let two_speeds = longest >= 1.25 * shortest && plain_square > weighed_square;
        Self {
            weighed,
            plain,
            weighed_square,
            plain_square,
            separation: (two_speeds && turns.len() > 3).then_some(separation),
        }
    }

    /// Shares of the turns in the contrast of a mean, with what the signs leave of geometry and of torque taken out: torque
    /// in angle goes with the squared duration, so a combination of both means has as much of either.
    pub(super) fn contrast(&self, mean: &[f64], turns: &[Turn]) -> Vec<f64> {
        let geometry = dot(mean, turns, |turn| turn.sign);
        let torque = dot(mean, turns, |turn| turn.sign * turn.ratio.powi(2));
        let of_plain = if self.separation.is_some() {
            (torque - geometry * self.weighed_square) / (self.plain_square - self.weighed_square)
        } else {
            0.0
        };
        let repeats = self.weighed.iter().zip(&self.plain);
        let repeats =
            repeats.map(|(weighed, plain)| (geometry - of_plain) * weighed + of_plain * plain);
        let signed = mean
            .iter()
            .zip(turns)
            .map(|(share, turn)| turn.sign * share);
        signed
            .zip(repeats)
            .map(|(signed, repeats)| signed - repeats)
            .collect()
    }
}

/// Difference of shares.
pub(super) fn minus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// Sum over turns of a value times their share.
pub(super) fn dot(shares: &[f64], turns: &[Turn], value: impl Fn(&Turn) -> f64) -> f64 {
    shares
        .iter()
        .zip(turns)
        .map(|(share, turn)| share * value(turn))
        .sum()
}

/// Noise power in a sum over turns of which each has a power of its own.
pub(super) fn noise_of(shares: &[f64], turns: &[Turn], power: impl Fn(&Turn) -> f64) -> f64 {
    let squares: Vec<f64> = shares.iter().map(|share| share * share).collect();
    dot(&squares, turns, power)
}

/// Power of white torque noise in the angle of a turn over that at the first turn's speed: the cube of the duration.
pub(super) fn torque_power(turn: &Turn) -> f64 {
    (1.5 * f64::from(turn.bin)).exp2()
}

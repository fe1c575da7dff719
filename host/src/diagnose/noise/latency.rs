//! `capture_latency`, exponential: every capture waits for a time of mean m, and short waits are the most frequent.
//!
//! A wait has variance m^2 and third cumulant 2 m^3, where jitter has none. With y the angles, C the inverse of their covariance
//! and u = C y, the likelihood's slope along the third cumulants k_i of the single angles is sum k_i (u_i^3 - 3 C_ii u_i) / 6
//! (Edgeworth's series; McCullagh, Tensor Methods in Statistics, 1987, ch. 5), so that, with k_i = -w_i^3 k, w the signed speed and
//! k the stamps' third cumulant, k = sum a_i (u_i^3 - 3 C_ii u_i) / sum a_i a_j C_ij^3, a_i = -w_i^3. Its mean is exact whatever
//! the size, as third cumulants of independent numbers add. Late is behind: negative in forward motion, so k > 0 is late.

use super::super::board::{Board, PARTS};
use super::levels::Levels;

/// Edges to either side whose correlation counts.
const REACH: usize = 12;
/// Blocks of a recording that the scatter is taken from.
const BLOCKS: usize = 2 * PARTS;

/// Third cumulant of the stamps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Skew {
    /// Value, s^3; positive where captures come late.
    pub third_s3: f64,
    /// Standard error were the stamps normal, s^3.
    pub normal_error_s3: f64,
    /// Standard error as the recording's parts scatter, s^3.
    pub error_s3: f64,
}

/// The stamps' third cumulant, all recordings together.
#[must_use]
pub fn skew(board: &Board, levels: &Levels) -> Skew {
    let mut blocks: Vec<[f64; 2]> = Vec::new();
    for (at, bench) in board.benches.iter().enumerate() {
        let whitener = &levels.whiteners[at];
        let precisions = whitener.precisions();
        let mut weighed = levels.white[at].clone();
        whitener.transposed(&mut weighed);
        let each = weighed.iter().zip(&precisions);
        let unit: Vec<f64> = each
            .map(|(u, d)| u / d.max(f64::MIN_POSITIVE).sqrt())
            .collect();
        let shared = 1.0
            + 2.0
                * (1..=REACH)
                    .map(|lag| correlation(&unit, lag).powi(3))
                    .sum::<f64>();
        let count = unit.len();
        for block in 0..BLOCKS {
            let mut sums = [0.0; 2];
            for k in block * count / BLOCKS..(block + 1) * count / BLOCKS {
                let (x, d) = (unit[k], precisions[k]);
                let size = -(bench.seen.speeds[k] * d.sqrt()).powi(3);
                sums[0] += size * (x * x * x - 3.0 * x);
                sums[1] += size * size * shared.max(0.1);
            }
            blocks.push(sums);
        }
    }
    let [above, below] = blocks
        .iter()
        .fold([0.0; 2], |[a, b], block| [a + block[0], b + block[1]]);
    let third = above / below;
    let scatter: f64 = blocks.iter().map(|[a, b]| (a - third * b).powi(2)).sum();
    let more = blocks.len() as f64 / (blocks.len() as f64 - 1.0).max(1.0);
    Skew {
        third_s3: third,
        normal_error_s3: (6.0 / below).sqrt(),
        error_s3: (more * scatter).sqrt() / below,
    }
}

fn correlation(numbers: &[f64], lag: usize) -> f64 {
    let whole: f64 = numbers.iter().map(|x| x * x).sum();
    let both = numbers.iter().zip(numbers.iter().skip(lag));
    both.map(|(a, b)| a * b).sum::<f64>() / whole.max(f64::MIN_POSITIVE)
}

//! The part of the loop's displacement that repeats every turn, by gain: where the gains are wrong, it stays in the encoder's errors and
//! no scatter of turns shows it.

use nalgebra::Matrix2;

use super::crossing::Crossing;
use super::trend::Trend;
use crate::twin::Gains;

/// What moves on in a turn: the displacement by either gain, and the two motions of a free shaft.
const CHANNELS: usize = 4;

/// Sums of whole turns, from index to index, each closed as a calibration closes it.
#[derive(Clone, Debug)]
pub(super) struct TurnSums {
    turn: Vec<[f64; CHANNELS]>,
    sums: Vec<[f64; CHANNELS]>,
    turns: u32,
}

impl TurnSums {
    /// Of turns of so many edges.
    pub fn new(edges: u32) -> Self {
        Self {
            turn: Vec::with_capacity(edges as usize),
            sums: vec![[0.0; CHANNELS]; edges as usize],
            turns: 0,
        }
    }

    /// Takes an edge: the displacements by kp and ki there, and how far a free shaft goes by speed and by push.
    pub fn push(&mut self, crossing: &Crossing, moved: [f64; CHANNELS]) {
        if !crossing.sure || crossing.steps != 1 {
            self.turn.clear();
        }
        if crossing.edge == 0 {
            if self.turn.len() == self.sums.len() {
                self.close(&moved);
            }
            self.turn.clear();
            self.turn.push(moved);
        } else if !self.turn.is_empty() {
            self.turn.push(moved);
        }
    }

    #[allow(clippy::cast_precision_loss)]
    fn close(&mut self, end: &[f64; CHANNELS]) {
        let start = self.turn[0];
        let edges = self.sums.len() as f64;
        for (at, (sum, moved)) in self.sums.iter_mut().zip(&self.turn).enumerate() {
            let part = at as f64 / edges;
            for (channel, sum) in sum.iter_mut().enumerate() {
                *sum += moved[channel] - start[channel] - part * (end[channel] - start[channel]);
            }
        }
        self.turns += 1;
    }

    /// What repeats once the free motions of a trend are taken out.
    #[allow(clippy::cast_precision_loss)]
    pub fn repeated<const SHARES: usize>(&self, trend: &Trend<SHARES>) -> Repeated {
        let pattern = |sum: &[f64; CHANNELS]| {
            [0, 1].map(|gain| {
                let free = trend.speed(gain) * sum[2] + trend.push(gain) * sum[3];
                (sum[gain] - free) / f64::from(self.turns.max(1))
            })
        };
        let patterns: Vec<[f64; 2]> = self.sums.iter().map(pattern).collect();
        let count = patterns.len() as f64;
        let mean =
            |value: &dyn Fn(&[f64; 2]) -> f64| patterns.iter().map(value).sum::<f64>() / count;
        let middle = [mean(&|p| p[0]), mean(&|p| p[1])];
        let square = |i: usize, j: usize| mean(&|p| (p[i] - middle[i]) * (p[j] - middle[j]));
        Repeated(Matrix2::from_fn(square))
    }
}

/// Mean products over a turn of the displacements that repeat, rad^2 by unit of each gain squared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Repeated(Matrix2<f64>);

impl Repeated {
    /// RMS over a turn, rad, of what errors of gains with these standard errors and this correlation leave.
    pub fn rms(&self, error: Gains, correlation: f64) -> f64 {
        let cross = correlation * error.kp * error.ki;
        let square = self.0[(0, 0)] * error.kp.powi(2)
            + self.0[(1, 1)] * error.ki.powi(2)
            + 2.0 * self.0[(0, 1)] * cross;
        square.max(0.0).sqrt()
    }
}

//! What is taken off a recording before its noise is fitted: pushes that are steady, and what all edges of a class have.

use nalgebra::{DMatrix, DVector};

use super::basis::{Basis, channels};
use super::bench::Bench;

impl Bench {
    /// Takes off the steady push, which is nobody's finding.
    pub fn level(&mut self) {
        self.take_off(&[steady(f64::NEG_INFINITY, f64::INFINITY)]);
    }

    /// Takes off a push that is steady for each of so many parts of the recording, and what all edges of a class have.
    pub fn smooth(&mut self, parts: usize) {
        let (Some(first), Some(last)) = (self.seen.times_s.first(), self.seen.times_s.last())
        else {
            return;
        };
        let time_s = |part: usize| match part {
            0 => f64::NEG_INFINITY,
            part if part == parts => f64::INFINITY,
            part => first + (last - first) * part as f64 / parts as f64,
        };
        let mut bases: Vec<Basis> = (0..parts)
            .map(|part| steady(time_s(part), time_s(part + 1)))
            .collect();
        let channels = channels(self.seen.classes);
        bases.extend((0..channels).map(|channel| Basis::Width {
            channel: Some(channel),
        }));
        bases.extend((1..channels).map(|channel| Basis::Shift { channel }));
        self.take_off(&bases);
    }

    /// Takes patterns off, as large as they are most likely.
    fn take_off(&mut self, bases: &[Basis]) {
        let rows: Vec<Vec<f64>> = bases
            .iter()
            .map(|basis| basis.columns(&self.seen, &self.law).swap_remove(0))
            .collect();
        let white: Vec<Vec<f64>> = rows.iter().map(|row| self.whitened(row.clone())).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let length: Vec<f64> = white.iter().map(|one| dot(one, one).sqrt()).collect();
        let count = rows.len();
        let gram = DMatrix::from_fn(count, count, |i, j| {
            dot(&white[i], &white[j]) / (length[i] * length[j])
        });
        let right = DVector::from_fn(count, |i, _| dot(&white[i], &self.white) / length[i]);
        let Some(factor) = gram.cholesky() else {
            return;
        };
        let sizes = factor.solve(&right);
        for ((row, size), length) in rows.iter().zip(&sizes).zip(&length) {
            let each = self.seen.angles.iter_mut().zip(row);
            each.for_each(|(angle, value)| *angle -= size / length * value);
        }
        self.set_noise(self.noise);
    }
}

/// 1 N m from a time to another.
const fn steady(from_s: f64, until_s: f64) -> Basis {
    Basis::Load { from_s, until_s }
}

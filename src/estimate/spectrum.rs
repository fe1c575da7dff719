//! Orders of a closed sequence over one turn: the discrete Fourier transform, one order at a time, in integers.

use super::buffers::{read_wide, write_wide};
use crate::trig::{SINE_BITS, sin_cos};
use crate::units::Turn32;

/// A sequence of 32-bit numbers around the turn.
pub(super) trait Sequence {
    fn len(&self) -> usize;
    fn get(&self, index: usize) -> i32;
    fn set(&mut self, index: usize, value: i32);
}

impl Sequence for [i32] {
    fn len(&self) -> usize {
        <[i32]>::len(self)
    }

    fn get(&self, index: usize) -> i32 {
        self[index]
    }

    fn set(&mut self, index: usize, value: i32) {
        self[index] = value;
    }
}

impl Sequence for [[i16; 2]] {
    fn len(&self) -> usize {
        <[[i16; 2]]>::len(self)
    }

    fn get(&self, index: usize) -> i32 {
        read_wide(self[index])
    }

    fn set(&mut self, index: usize, value: i32) {
        self[index] = write_wide(value);
    }
}

/// One order's complex size, in 2^-[`COEFFICIENT_BITS`] of the sequence's unit: the mean of x exp(-i n theta).
#[derive(Clone, Copy, Default)]
pub(super) struct Coefficient {
    pub re: i64,
    pub im: i64,
}

/// Fraction bits of a [`Coefficient`].
pub(super) const COEFFICIENT_BITS: u32 = 8;

impl Coefficient {
    /// Squared size in 2^-16 of the squared unit, saturating.
    pub(super) fn power(self) -> u64 {
        let square = |x: i64| u128::from(x.unsigned_abs()) * u128::from(x.unsigned_abs());
        u64::try_from(square(self.re) + square(self.im)).unwrap_or(u64::MAX)
    }
}

/// Samples after which the running phasor is set anew, so that rounding can't grow.
const RESEED: usize = 64;

/// Steps a unit phasor around the turn; `visit(index, cos, sin)` gets Q30.
fn turn_phasor(order: usize, samples: usize, mut visit: impl FnMut(usize, i64, i64)) {
    let step_q32 = ((order as u64) << 32) / samples as u64;
    let remainder = ((order as u64) << 32) % samples as u64;
    let angle = |index: usize| {
        // order * index / samples of a turn; the remainder keeps the angle exact to one LSB.
        let index = index as u64;
        #[allow(clippy::cast_possible_truncation)]
        Turn32((step_q32 * index + remainder * index / samples as u64) as u32)
    };
    let (s1, c1) = sin_cos(angle(1));
    let (s1, c1) = (i64::from(s1), i64::from(c1));
    let half = 1_i64 << (SINE_BITS - 1);
    let mut index = 0;
    while index < samples {
        let (s, c) = sin_cos(angle(index));
        let (mut s, mut c) = (i64::from(s), i64::from(c));
        let end = samples.min(index + RESEED);
        while index < end {
            visit(index, c, s);
            (c, s) = (
                (c * c1 - s * s1 + half) >> SINE_BITS,
                (s * c1 + c * s1 + half) >> SINE_BITS,
            );
            index += 1;
        }
    }
}

/// The size of `order` in the first `samples` of a sequence.
pub(super) fn coefficient<S: Sequence + ?Sized>(
    sequence: &S,
    samples: usize,
    order: usize,
) -> Coefficient {
    const SUM_BITS: u32 = 15;
    let (mut re, mut im) = (0_i64, 0_i64);
    turn_phasor(order, samples, |index, c, s| {
        let x = i64::from(sequence.get(index));
        re += (x * c) >> (SINE_BITS - SUM_BITS);
        im -= (x * s) >> (SINE_BITS - SUM_BITS);
    });
    let scale = |sum: i64| (sum / samples as i64) >> (SUM_BITS - COEFFICIENT_BITS);
    Coefficient {
        re: scale(re),
        im: scale(im),
    }
}

/// Adds `2 Re(factor exp(i order theta))` to every sample; `factor` in 2^-`bits` of the sequence's unit.
pub(super) fn add_order<S: Sequence + ?Sized>(
    sequence: &mut S,
    order: usize,
    factor: Coefficient,
    bits: u32,
) {
    let samples = sequence.len();
    let shift = SINE_BITS + bits - 1;
    let half = 1_i64 << (shift - 1);
    turn_phasor(order, samples, |index, c, s| {
        let value = (factor.re * c - factor.im * s + half) >> shift;
        #[allow(clippy::cast_possible_truncation)]
        sequence.set(index, sequence.get(index).wrapping_add(value as i32));
    });
}

/// Replaces the first `len / factor` samples by smoothed ones and returns how many they are; `factor` is a power of two
/// that divides the length.
///
/// Each halving smooths with the binomial 1 4 6 4 1, whose gain cos^4 keeps high orders from folding onto low ones:
/// where a quarter of the samples' rate is left below an order, what folds onto it is below one percent.
pub(super) fn decimate<S: Sequence + ?Sized>(sequence: &mut S, factor: usize) -> usize {
    let mut length = sequence.len();
    for _ in 0..factor.trailing_zeros() {
        halve(sequence, length);
        length /= 2;
    }
    length
}

/// One halving of the first `length` samples, in place.
fn halve<S: Sequence + ?Sized>(sequence: &mut S, length: usize) {
    // The first two samples are overwritten before the last output, which wraps around to them, is made.
    let first = [i64::from(sequence.get(0)), i64::from(sequence.get(1))];
    let mut window = [
        i64::from(sequence.get(length - 2)),
        i64::from(sequence.get(length - 1)),
        first[0],
    ];
    for sample in 0..length / 2 {
        let centre = 2 * sample;
        let next = if sample == 0 {
            first[1]
        } else {
            i64::from(sequence.get(centre + 1))
        };
        let after = if centre + 2 < length {
            i64::from(sequence.get(centre + 2))
        } else {
            first[0]
        };
        let sum = window[0] + 4 * (window[1] + next) + 6 * window[2] + after;
        #[allow(clippy::cast_possible_truncation)]
        sequence.set(sample, ((sum + 8) >> 4) as i32);
        window = [window[2], next, after];
    }
}

/// Undoes [`decimate`]'s gain on a coefficient of `order`: cos^4 of pi order / length and of its doublings.
pub(super) fn undo_decimation(
    raw: Coefficient,
    order: usize,
    factor: usize,
    length: usize,
) -> Coefficient {
    let mut ratio_q30 = 1_i64 << SINE_BITS;
    let mut doublings = 1;
    while doublings < factor {
        #[allow(clippy::cast_possible_truncation)]
        let angle = Turn32((((order * doublings) as u64) << 31).div_euclid(length as u64) as u32);
        ratio_q30 = (ratio_q30 * i64::from(sin_cos(angle).1)) >> SINE_BITS;
        doublings *= 2;
    }
    let square_q30 = (ratio_q30 * ratio_q30) >> SINE_BITS;
    let gain_q30 = ((square_q30 * square_q30) >> SINE_BITS).max(1);
    let undo = |x: i64| {
        let quotient = (i128::from(x) << SINE_BITS) / i128::from(gain_q30);
        #[allow(clippy::cast_possible_truncation)]
        let quotient = quotient as i64;
        quotient
    };
    Coefficient {
        re: undo(raw.re),
        im: undo(raw.im),
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec::Vec;

    fn wave(samples: usize, parts: &[(usize, f64, f64)]) -> Vec<i32> {
        (0..samples)
            .map(|j| {
                let theta = core::f64::consts::TAU * j as f64 / samples as f64;
                parts
                    .iter()
                    .map(|&(n, size, phase)| size * (n as f64 * theta + phase).cos())
                    .sum::<f64>()
                    .round() as i32
            })
            .collect()
    }

    #[test]
    fn a_wave_comes_back_with_its_size_and_phase() {
        let parts = [(3, 1e6, 0.4), (100, 5e3, -1.0), (250, 2e5, 2.0)];
        for samples in [1250, 2048, 10_000] {
            let x = wave(samples, &parts);
            for &(n, size, phase) in &parts {
                let c = coefficient(x.as_slice(), samples, n);
                let expected = [size / 2.0 * phase.cos(), size / 2.0 * phase.sin()];
                for (got, want) in [c.re, c.im].into_iter().zip(expected) {
                    assert!(
                        (got as f64 / 256.0 - want).abs() < 0.6,
                        "{samples} {n}: {got} {want}"
                    );
                }
            }
        }
    }

    #[test]
    fn decimation_keeps_low_orders_once_its_gain_is_undone() {
        let parts = [(1, 3e5, 0.1), (40, 1e5, 0.7), (256, 4e4, -0.3)];
        let mut x = wave(10_000, &parts);
        let samples = decimate(x.as_mut_slice(), 8);
        assert_eq!(samples, 1250);
        for &(n, size, phase) in &parts {
            let c = undo_decimation(coefficient(x.as_slice(), samples, n), n, 8, 10_000);
            let size_back = (c.power() as f64).sqrt() / 128.0;
            assert!((size_back / size - 1.0).abs() < 2e-5, "{n}: {size_back}");
            assert!(((c.im as f64).atan2(c.re as f64) - phase).abs() < 2e-5);
        }
    }

    #[test]
    fn an_order_taken_out_leaves_nothing_of_it() {
        let mut x = wave(10_000, &[(7, 1e6, 0.3), (8, 100.0, 0.0)]);
        let c = coefficient(x.as_slice(), 10_000, 7);
        add_order(
            x.as_mut_slice(),
            7,
            Coefficient {
                re: -c.re,
                im: -c.im,
            },
            COEFFICIENT_BITS,
        );
        assert!(coefficient(x.as_slice(), 10_000, 7).power() < (2 << 16));
        assert!((coefficient(x.as_slice(), 10_000, 8).re - 50 * 256).abs() < 64);
    }
}

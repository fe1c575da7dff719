//! Orders of a closed sequence over one turn: the discrete Fourier transform, one order at a time, in integers.
//!
//! A sequence is first folded into its even and odd halves about edge 0, so that an order's cosine and sine each run over
//! half the samples.

use super::close::saturated;
use super::scale::Ratio;
use crate::trig::{SINE_BITS, sin_cos};
use crate::units::Turn32;

/// A sequence of 32-bit numbers around the turn.
pub(super) trait Sequence {
    fn get(&self, index: usize) -> i32;
    fn set(&mut self, index: usize, value: i32);
}

impl Sequence for [i32] {
    #[inline]
    fn get(&self, index: usize) -> i32 {
        self.get(index..)
            .and_then(|rest| rest.first())
            .copied()
            .unwrap_or(0)
    }

    #[inline]
    fn set(&mut self, index: usize, value: i32) {
        if let Some(entry) = self.get_mut(index) {
            *entry = value;
        }
    }
}

/// Pairs of 16-bit cells, each pair one number.
impl Sequence for [[i16; 2]] {
    #[inline]
    fn get(&self, index: usize) -> i32 {
        let [low, high] = self
            .get(index..)
            .and_then(|rest| rest.first())
            .copied()
            .unwrap_or([0; 2]);
        (i32::from(high) << 16) | i32::from(low.cast_unsigned())
    }

    #[inline]
    fn set(&mut self, index: usize, value: i32) {
        if let Some(entry) = self.get_mut(index) {
            #[allow(clippy::cast_possible_truncation)]
            {
                *entry = [value as i16, (value >> 16) as i16];
            }
        }
    }
}

/// One order's complex size, in 2^-[`COEFFICIENT_BITS`] of the sequence's unit: the mean of x exp(-i n theta).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Coefficient {
    pub re: i32,
    pub im: i32,
}

/// Fraction bits of a [`Coefficient`].
pub(super) const COEFFICIENT_BITS: u32 = 4;

/// Fraction bits of the square of one. With sequences below 2^27 no coefficient overflows 32 bits.
pub(super) const POWER_BITS: u32 = 2 * COEFFICIENT_BITS;

impl Coefficient {
    /// Squared size in 2^-[`POWER_BITS`] of the squared unit.
    pub(super) fn power(self) -> u64 {
        let square = |x: i32| u64::from(x.unsigned_abs()).pow(2);
        square(self.re) + square(self.im)
    }

    /// Both parts times `factor_q30` in Q30, capped.
    pub(super) fn scaled(self, factor_q30: i64) -> Self {
        let times = |x: i32| {
            let product = (i128::from(x) * i128::from(factor_q30)) >> 30;
            i32::try_from(product).unwrap_or(if x < 0 { i32::MIN } else { i32::MAX })
        };
        Self {
            re: times(self.re),
            im: times(self.im),
        }
    }

    pub(super) fn plus(self, other: Self) -> Self {
        Self {
            re: self.re.saturating_add(other.re),
            im: self.im.saturating_add(other.im),
        }
    }

    pub(super) fn minus(self, other: Self) -> Self {
        Self {
            re: self.re.saturating_sub(other.re),
            im: self.im.saturating_sub(other.im),
        }
    }
}

/// Samples after which the running phasor is set anew, so that rounding can't grow.
const RESEED: usize = 64;

/// Steps a unit phasor through the first half of the turn; `visit(index, cos, sin)` gets Q30.
#[inline]
fn half_turn_phasor(order: usize, samples: usize, mut visit: impl FnMut(usize, i32, i32)) {
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
    let (last, half) = (samples / 2, 1_i64 << (SINE_BITS - 1));
    let mut index = 0;
    while index <= last {
        let (mut s, mut c) = sin_cos(angle(index));
        let end = (last + 1).min(index + RESEED);
        while index < end {
            visit(index, c, s);
            let (ws, wc) = (i64::from(s), i64::from(c));
            #[allow(clippy::cast_possible_truncation)]
            {
                c = ((wc * c1 - ws * s1 + half) >> SINE_BITS) as i32;
                s = ((ws * c1 + wc * s1 + half) >> SINE_BITS) as i32;
            }
            index += 1;
        }
    }
}

/// Replaces x(j), x(-j) by their sum and difference.
pub(super) fn fold_halves<S: Sequence + ?Sized>(sequence: &mut S, samples: usize) {
    for index in 1..samples.div_ceil(2) {
        let (one, other) = (sequence.get(index), sequence.get(samples - index));
        sequence.set(index, one.wrapping_add(other));
        sequence.set(samples - index, one.wrapping_sub(other));
    }
}

/// The size of `order` in the first `samples` of a folded sequence.
pub(super) fn coefficient<S: Sequence + ?Sized>(
    folded: &S,
    samples: usize,
    order: usize,
) -> Coefficient {
    /// Digits of sine and cosine kept, so that sums of a thousand and more samples of 2^29 fit.
    const DROPPED: u32 = 8;
    let (mut re, mut im) = (0_i64, 0_i64);
    let half = samples.div_ceil(2);
    half_turn_phasor(order, samples, |index, c, s| {
        re += i64::from(folded.get(index)) * i64::from(c >> DROPPED);
        if index != 0 && index < half {
            im -= i64::from(folded.get(samples - index)) * i64::from(s >> DROPPED);
        }
    });
    let scale =
        |sum: i64| saturated((sum / samples as i64) >> (SINE_BITS - DROPPED - COEFFICIENT_BITS));
    Coefficient {
        re: scale(re),
        im: scale(im),
    }
}

/// Adds `2 Re(factor exp(i order theta))` to a folded sequence, `factor` in 2^-[`COEFFICIENT_BITS`] of its unit.
pub(super) fn add_order<S: Sequence + ?Sized>(
    folded: &mut S,
    samples: usize,
    order: usize,
    factor: Coefficient,
) {
    const SHIFT: u32 = SINE_BITS + COEFFICIENT_BITS - 1;
    const ROUNDING: i64 = 1 << (SHIFT - 1);
    let Coefficient { re, im } = factor;
    let half = samples.div_ceil(2);
    half_turn_phasor(order, samples, |index, c, s| {
        #[allow(clippy::cast_possible_truncation)]
        let even = ((i64::from(re) * i64::from(c) + ROUNDING) >> SHIFT) as i32;
        folded.set(index, folded.get(index).wrapping_add(even));
        if index != 0 && index < half {
            #[allow(clippy::cast_possible_truncation)]
            let odd = ((i64::from(im) * i64::from(s) + ROUNDING) >> SHIFT) as i32;
            let mirror = samples - index;
            folded.set(mirror, folded.get(mirror).wrapping_sub(odd));
        }
    });
}

/// Turns the even and odd halves that [`add_order`] wrote back into samples.
pub(super) fn unfold_halves<S: Sequence + ?Sized>(sequence: &mut S, samples: usize) {
    for index in 1..samples.div_ceil(2) {
        let (even, odd) = (sequence.get(index), sequence.get(samples - index));
        sequence.set(index, even.wrapping_add(odd));
        sequence.set(samples - index, even.wrapping_sub(odd));
    }
}

/// Fills `target` with every `factor`-th sample of `source`, smoothed, and returns how many they are; `factor` is a power
/// of two that divides the length.
///
/// Each halving smooths with the binomial 1 4 6 4 1, whose gain cos^4 keeps high orders from folding onto low ones:
/// where a quarter of the samples' rate is left below an order, what folds onto it is below one percent.
pub(super) fn decimate<S: Sequence + ?Sized>(
    source: &[i32],
    target: &mut S,
    factor: usize,
) -> usize {
    let mut length = source.len();
    if factor == 1 {
        for (index, &value) in source.iter().enumerate() {
            target.set(index, value);
        }
        return length;
    }
    let mut halver = Halver::new(|index| Sequence::get(source, index), length);
    for sample in 0..length / 2 {
        let value = halver.next(|index| Sequence::get(source, index), sample);
        target.set(sample, value);
    }
    length /= 2;
    for _ in 1..factor.trailing_zeros() {
        let mut halver = Halver::new(|index| target.get(index), length);
        for sample in 0..length / 2 {
            let value = halver.next(|index| target.get(index), sample);
            target.set(sample, value);
        }
        length /= 2;
    }
    length
}

/// Halves a sequence, in place if need be: sample j may overwrite what is at j.
struct Halver {
    length: usize,
    /// The first two samples, which the last output wraps around to.
    first: [i32; 2],
    /// The two samples before the next centre, and the centre.
    window: [i32; 3],
}

impl Halver {
    fn new(get: impl Fn(usize) -> i32, length: usize) -> Self {
        let first = [get(0), get(1)];
        Self {
            length,
            first,
            window: [get(length - 2), get(length - 1), first[0]],
        }
    }

    fn next(&mut self, get: impl Fn(usize) -> i32, sample: usize) -> i32 {
        let centre = 2 * sample;
        let after = if sample == 0 {
            self.first[1]
        } else {
            get(centre + 1)
        };
        let second = if centre + 2 < self.length {
            get(centre + 2)
        } else {
            self.first[0]
        };
        let [a, b, c] = self.window.map(i64::from);
        let sum = a + 4 * (b + i64::from(after)) + 6 * c + i64::from(second);
        self.window = [self.window[2], after, second];
        #[allow(clippy::cast_possible_truncation)]
        let smooth = ((sum + 8) >> 4) as i32;
        smooth
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
    let gain_q30 = ((square_q30 * square_q30) >> SINE_BITS)
        .max(1)
        .unsigned_abs();
    let inverse = Ratio::new(SINE_BITS, gain_q30);
    Coefficient {
        re: saturated(inverse.times(raw.re.into())),
        im: saturated(inverse.times(raw.im.into())),
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
        let parts = [(3, 1e8, 0.4), (100, 5e3, -1.0), (250, 2e5, 2.0)];
        for samples in [1250, 1001, 2048, 10_000] {
            let mut x = wave(samples, &parts);
            fold_halves(x.as_mut_slice(), samples);
            for &(n, size, phase) in &parts {
                let c = coefficient(x.as_slice(), samples, n);
                let expected = [size / 2.0 * phase.cos(), size / 2.0 * phase.sin()];
                for (got, want) in [c.re, c.im].into_iter().zip(expected) {
                    assert!(
                        (got as f64 / 16.0 - want).abs() < 0.6 + 1e8 * 2e-8,
                        "{samples} {n}: {got} {want}"
                    );
                }
            }
        }
    }

    #[test]
    fn decimation_keeps_low_orders_once_its_gain_is_undone() {
        let parts = [(1, 3e5, 0.1), (40, 1e5, 0.7), (256, 4e4, -0.3)];
        let x = wave(10_000, &parts);
        let mut small = std::vec![[0_i16; 2]; 5000];
        let samples = decimate(&x, small.as_mut_slice(), 4);
        assert_eq!(samples, 2500);
        fold_halves(small.as_mut_slice(), samples);
        for &(n, size, phase) in &parts {
            let c = undo_decimation(coefficient(small.as_slice(), samples, n), n, 4, 10_000);
            let size_back = (c.power() as f64).sqrt() / 8.0;
            assert!((size_back / size - 1.0).abs() < 2e-5, "{n}: {size_back}");
            assert!(((c.im as f64).atan2(c.re as f64) - phase).abs() < 2e-5);
        }
    }

    #[test]
    fn orders_added_to_halves_are_the_wave() {
        for samples in [999, 2500] {
            let parts = [(7, 1e6, 0.3_f64), (211, 3e7, -2.0)];
            let mut x = std::vec![0_i32; samples];
            for &(n, size, phase) in &parts {
                let factor = Coefficient {
                    re: (size * 8.0 * phase.cos()) as i32,
                    im: (size * 8.0 * phase.sin()) as i32,
                };
                add_order(x.as_mut_slice(), samples, n, factor);
            }
            unfold_halves(x.as_mut_slice(), samples);
            let off = x
                .iter()
                .zip(wave(samples, &parts))
                .map(|(got, want)| (got - want).abs());
            // One LSB of a phasor, taken on over 64 samples.
            assert!(off.max().unwrap() < 12, "{samples}");
        }
    }
}

//! Orders of a closed sequence over one turn: the discrete Fourier transform, one order at a time, in integers.
//!
//! A sequence is first folded into its even and odd halves about edge 0, so that an order's cosine and sine each run over
//! half the samples.

use super::close::saturated;
use super::scale::Ratio;
use crate::trig::{SINE_BITS, sin_cos};
use crate::units::Turn32;

/// One 32-bit number of a sequence around the turn.
pub(super) trait Sample: Copy {
    fn value(self) -> i32;
    fn of(value: i32) -> Self;
}

impl Sample for i32 {
    #[inline]
    fn value(self) -> i32 {
        self
    }

    #[inline]
    fn of(value: i32) -> Self {
        value
    }
}

/// Two 16-bit cells that hold one number.
impl Sample for [i16; 2] {
    #[inline]
    fn value(self) -> i32 {
        (i32::from(self[1]) << 16) | i32::from(self[0].cast_unsigned())
    }

    #[inline]
    #[allow(clippy::cast_possible_truncation)]
    fn of(value: i32) -> Self {
        [value as i16, (value >> 16) as i16]
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

/// Angle of `order` at a sample, exact to one LSB.
struct OrderAngle {
    step_q32: u64,
    remainder: u64,
    samples: u64,
}

impl OrderAngle {
    fn new(order: usize, samples: usize) -> Self {
        let samples = samples.max(1) as u64;
        let turns = (order as u64) << 32;
        Self {
            step_q32: turns / samples,
            remainder: turns % samples,
            samples,
        }
    }

    /// Cosine and sine at a sample, Q30.
    fn phasor(&self, index: usize) -> [i32; 2] {
        let index = index as u64;
        #[allow(clippy::cast_possible_truncation)]
        let angle = (self.step_q32 * index + self.remainder * index / self.samples) as u32;
        let (sin, cos) = sin_cos(Turn32(angle));
        [cos, sin]
    }
}

/// A phasor turned by a step.
#[inline]
fn turned([c, s]: [i32; 2], [c1, s1]: [i32; 2]) -> [i32; 2] {
    const HALF: i64 = 1 << (SINE_BITS - 1);
    let product = |a: i32, b: i32| i64::from(a) * i64::from(b);
    #[allow(clippy::cast_possible_truncation)]
    [
        ((product(c, c1) - product(s, s1) + HALF) >> SINE_BITS) as i32,
        ((product(s, c1) + product(c, s1) + HALF) >> SINE_BITS) as i32,
    ]
}

/// A folded sequence, part by part.
struct Halves<'a, S> {
    /// The sample at edge 0.
    first: &'a mut S,
    even: &'a mut [S],
    /// The sample half a turn on, where there is one.
    middle: Option<&'a mut S>,
    /// The partners of `even`, in reverse.
    odd: &'a mut [S],
}

impl<'a, S> Halves<'a, S> {
    fn of(folded: &'a mut [S]) -> Option<Self> {
        let half = folded.len().div_ceil(2).checked_sub(1)?;
        let (first, rest) = folded.split_first_mut()?;
        let (even, rest) = rest.split_at_mut(half);
        let (middle, odd) = rest.split_at_mut(rest.len() - half);
        Some(Self {
            first,
            even,
            middle: middle.first_mut(),
            odd,
        })
    }
}

/// Replaces x(j), x(-j) by their sum and difference.
pub(super) fn fold_halves<S: Sample>(sequence: &mut [S]) {
    if let Some(Halves { even, odd, .. }) = Halves::of(sequence) {
        for (one, other) in even.iter_mut().zip(odd.iter_mut().rev()) {
            let (a, b) = (one.value(), other.value());
            *one = S::of(a.wrapping_add(b));
            *other = S::of(a.wrapping_sub(b));
        }
    }
}

/// Turns the even and odd halves that [`add_order`] wrote back into samples.
pub(super) fn unfold_halves<S: Sample>(sequence: &mut [S]) {
    fold_halves(sequence);
}

/// The size of `order` in a folded sequence.
pub(super) fn coefficient<S: Sample>(folded: &mut [S], order: usize) -> Coefficient {
    /// Digits of sine and cosine kept, so that sums of a thousand and more samples of 2^28 fit.
    const DROPPED: u32 = 8;
    let samples = folded.len();
    let Some(Halves {
        first,
        even,
        middle,
        odd,
    }) = Halves::of(folded)
    else {
        return Coefficient::default();
    };
    let angle = OrderAngle::new(order, samples);
    let step = angle.phasor(1);
    let one = i64::from(first.value()) << (SINE_BITS - DROPPED);
    let (mut re, mut im) = (one, 0_i64);
    let chunks = even.chunks(RESEED).zip(odd.rchunks(RESEED));
    for (chunk, (even, odd)) in chunks.enumerate() {
        let mut now = angle.phasor(1 + chunk * RESEED);
        for (even, odd) in even.iter().zip(odd.iter().rev()) {
            re += i64::from(even.value()) * i64::from(now[0] >> DROPPED);
            im -= i64::from(odd.value()) * i64::from(now[1] >> DROPPED);
            now = turned(now, step);
        }
    }
    if let Some(middle) = middle {
        let far = i64::from(middle.value()) << (SINE_BITS - DROPPED);
        re += if order.is_multiple_of(2) { far } else { -far };
    }
    let scale =
        |sum: i64| saturated((sum / samples as i64) >> (SINE_BITS - DROPPED - COEFFICIENT_BITS));
    Coefficient {
        re: scale(re),
        im: scale(im),
    }
}

/// Adds `2 Re(factor exp(i order theta))` to a folded sequence, `factor` in 2^-[`COEFFICIENT_BITS`] of its unit.
pub(super) fn add_order<S: Sample>(folded: &mut [S], order: usize, factor: Coefficient) {
    const SHIFT: u32 = SINE_BITS + COEFFICIENT_BITS - 1;
    const ROUNDING: i64 = 1 << (SHIFT - 1);
    #[allow(clippy::cast_possible_truncation)]
    let part = |factor: i32, share: i32| {
        ((i64::from(factor) * i64::from(share) + ROUNDING) >> SHIFT) as i32
    };
    let add = |sample: &mut S, more: i32| *sample = S::of(sample.value().wrapping_add(more));
    let samples = folded.len();
    let Some(Halves {
        first,
        even,
        middle,
        odd,
    }) = Halves::of(folded)
    else {
        return;
    };
    let angle = OrderAngle::new(order, samples);
    let step = angle.phasor(1);
    let one = part(factor.re, 1 << SINE_BITS);
    add(first, one);
    let chunks = even.chunks_mut(RESEED).zip(odd.rchunks_mut(RESEED));
    for (chunk, (even, odd)) in chunks.enumerate() {
        let mut now = angle.phasor(1 + chunk * RESEED);
        for (even, odd) in even.iter_mut().zip(odd.iter_mut().rev()) {
            add(even, part(factor.re, now[0]));
            add(odd, -part(factor.im, now[1]));
            now = turned(now, step);
        }
    }
    if let Some(middle) = middle {
        add(middle, if order.is_multiple_of(2) { one } else { -one });
    }
}

/// Fills `target` with every `factor`-th sample of `source`, smoothed, and returns how many they are; `factor` is a power
/// of two that divides the length.
///
/// Each halving smooths with the binomial 1 4 6 4 1, whose gain cos^4 keeps high orders from folding onto low ones:
/// where a quarter of the samples' rate is left below an order, what folds onto it is below one percent.
pub(super) fn decimate<S: Sample>(source: &[i32], target: &mut [S], factor: usize) -> usize {
    let mut length = source.len();
    if factor == 1 {
        for (target, &value) in target.iter_mut().zip(source) {
            *target = S::of(value);
        }
        return length;
    }
    let get = |source: &[i32], index: usize| source.get(index).copied().unwrap_or(0);
    let mut halver = Halver::new(|index| get(source, index), length);
    length /= 2;
    for (sample, target) in target.iter_mut().enumerate().take(length) {
        *target = S::of(halver.next(|index| get(source, index), sample));
    }
    let get = |target: &[S], index: usize| target.get(index).map_or(0, |sample| sample.value());
    for _ in 1..factor.trailing_zeros() {
        let mut halver = Halver::new(|index| get(target, index), length);
        length /= 2;
        for sample in 0..length {
            let value = halver.next(|index| get(target, index), sample);
            if let Some(target) = target.get_mut(sample) {
                *target = S::of(value);
            }
        }
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
            fold_halves(&mut x);
            for &(n, size, phase) in &parts {
                let c = coefficient(&mut x, n);
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
        let samples = decimate(&x, &mut small, 4);
        assert_eq!(samples, 2500);
        let small = &mut small[..samples];
        fold_halves(small);
        for &(n, size, phase) in &parts {
            let c = undo_decimation(coefficient(small, n), n, 4, 10_000);
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
                add_order(&mut x, n, factor);
            }
            unfold_halves(&mut x);
            let off = x
                .iter()
                .zip(wave(samples, &parts))
                .map(|(got, want)| (got - want).abs());
            // One LSB of a phasor, taken on over 64 samples.
            assert!(off.max().unwrap() < 12, "{samples}");
        }
    }
}

//! Every second, fourth, ... sample of a turn, smoothed first so that high orders don't fold onto low ones.

use super::close::saturated;
use super::scale::Ratio;
use super::spectrum::{Coefficient, Sample};
use crate::trig::{SINE_BITS, sin_cos};
use crate::units::Turn32;

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
    use super::super::spectrum::waves::wave;
    use super::super::transform::take_orders;
    use super::*;

    #[test]
    fn decimation_keeps_low_orders_once_its_gain_is_undone() {
        let parts = [(1, 3e5, 0.1), (40, 1e5, 0.7), (256, 4e4, -0.3)];
        let x = wave(10_000, &parts);
        let mut small = std::vec![[0_i16; 2]; 5000];
        let samples = decimate(&x, &mut small, 4);
        assert_eq!(samples, 2500);
        let mut sizes = [Coefficient::default(); 256];
        take_orders(&small[..samples], &mut sizes);
        for &(n, size, phase) in &parts {
            let c = undo_decimation(sizes[n - 1], n, 4, 10_000);
            let size_back = (c.power() as f64).sqrt() / 8.0;
            assert!((size_back / size - 1.0).abs() < 2e-5, "{n}: {size_back}");
            assert!(((c.im as f64).atan2(c.re as f64) - phase).abs() < 2e-5);
        }
    }
}

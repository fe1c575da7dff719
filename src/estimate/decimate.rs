//! Every second, fourth, ... sample of a turn, smoothed first so that high orders don't fold onto low ones.

use core::ops::Range;
use core::task::{Poll, ready};

use super::close::saturated;
use super::cursor::Cursor;
use super::scale::Ratio;
use super::spectrum::{Coefficient, Sample};
use crate::trig::{SINE_BITS, sin_cos};
use crate::units::Turn32;

/// Samples that a slice makes.
const SAMPLES: usize = 250;

/// Fills a target with every 2nd, 4th, ... sample of a source, smoothed.
///
/// Each halving smooths with the binomial 1 4 6 4 1, whose gain cos^4 keeps high orders from folding onto low ones:
/// where a quarter of the samples' rate is left below an order, what folds onto it is below one percent.
pub(super) struct Decimation {
    /// Halved so often so far.
    halvings: u32,
    halver: Option<Halver>,
    cursor: Cursor,
}

impl Decimation {
    pub(super) const START: Self = Self {
        halvings: 0,
        halver: None,
        cursor: Cursor::START,
    };

    /// `factor` is a power of two that divides the source's length; in the end the target begins with the samples that are left.
    pub(super) fn slice<S: Sample>(
        &mut self,
        source: &[i32],
        target: &mut [S],
        factor: usize,
    ) -> Poll<()> {
        if factor == 1 {
            let stretch = self.cursor.next(SAMPLES, source.len());
            for (target, &value) in target[stretch.clone()].iter_mut().zip(&source[stretch]) {
                *target = S::of(value);
            }
            return self.cursor.at_end(source.len());
        }
        let length = source.len() >> self.halvings;
        let stretch = self.cursor.next(SAMPLES, length / 2);
        if self.halvings == 0 {
            self.halve(length, stretch, target, |_, at| source[at]);
        } else {
            self.halve(length, stretch, target, |target, at| target[at].value());
        }
        ready!(self.cursor.at_end(length / 2));
        *self = Self {
            halvings: self.halvings + 1,
            ..Self::START
        };
        if 1 << self.halvings >= factor {
            Poll::Ready(())
        } else {
            Poll::Pending
        }
    }

    fn halve<S: Sample>(
        &mut self,
        length: usize,
        stretch: Range<usize>,
        target: &mut [S],
        get: impl Fn(&[S], usize) -> i32,
    ) {
        let halver = self
            .halver
            .get_or_insert_with(|| Halver::new(|at| get(target, at), length));
        for sample in stretch {
            let value = halver.next(|at| get(target, at), sample);
            target[sample] = S::of(value);
        }
    }
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

/// Undoes [`Decimation`]'s gain on a coefficient of `order`: cos^4 of pi order / length and of its doublings.
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
    use super::super::cursor::whole;
    use super::super::spectrum::waves::wave;
    use super::super::transform::TakeOrders;
    use super::*;

    #[test]
    fn decimation_keeps_low_orders_once_its_gain_is_undone() {
        let parts = [(1, 3e5, 0.1), (40, 1e5, 0.7), (256, 4e4, -0.3)];
        let x = wave(10_000, &parts);
        let mut small = std::vec![[0_i16; 2]; 5000];
        let mut decimation = Decimation::START;
        whole(|| decimation.slice(&x, &mut small, 4));
        let mut sizes = [Coefficient::default(); 256];
        let mut take = TakeOrders::START;
        whole(|| take.slice(&small[..2500], &mut sizes));
        for &(n, size, phase) in &parts {
            let c = undo_decimation(sizes[n - 1], n, 4, 10_000);
            let size_back = (c.power() as f64).sqrt() / 8.0;
            assert!((size_back / size - 1.0).abs() < 2e-5, "{n}: {size_back}");
            assert!(((c.im as f64).atan2(c.re as f64) - phase).abs() < 2e-5);
        }
    }
}

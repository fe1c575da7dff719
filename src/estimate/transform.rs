//! Many orders of a sequence at once, and back: the discrete Fourier transform in two steps, in integers.
//!
//! With L = P Q samples, sample p + P q and order n, `exp(-2 pi i n (p + P q) / L)` is `exp(-2 pi i n p / L)` times
//! `exp(-2 pi i r q / Q)` where r = n mod Q. So the sums over q are shared by all orders of one residue, and as samples are
//! real, by those of -r as well.

use super::close::saturated;
use super::spectrum::{COEFFICIENT_BITS, Coefficient, Sample};
use crate::trig::{SINE_BITS, sin_cos};
use crate::units::Turn32;

/// Q at the most.
const INNER_MAX: usize = 64;

/// Sums over q that are held at a time.
const CHUNK: usize = 32;

/// Digits of sine and cosine dropped where products are summed.
const DROPPED: u32 = 8;

/// Fraction bits that are left.
const FACTOR_BITS: u32 = SINE_BITS - DROPPED;

/// Cosine and sine, Q30.
type Phasor = [i32; 2];

/// Fills `sizes` with orders 1, 2, ... of a sequence whose samples are below 2^27.
#[inline(never)]
pub(super) fn take_orders<S: Sample>(sequence: &[S], sizes: &mut [Coefficient]) {
    sizes.fill(Coefficient::default());
    let Some(split) = Split::of(sequence.len()) else {
        return;
    };
    let circle = split.circle();
    for residue in 0..=split.inner / 2 {
        let factors = split.walk(&circle, residue).map(shortened);
        for start in (0..split.outer).step_by(CHUNK) {
            let mut sums = [[0; 2]; CHUNK];
            for (sum, p) in sums.iter_mut().zip(start..split.outer) {
                *sum = split.inner_sum(sequence, p, &factors);
            }
            let sums = &sums[..CHUNK.min(split.outer - start)];
            split.each_order(residue, sizes.len(), |order, mirrored| {
                let part = split.outer_sum(sums, order, mirrored, start);
                sizes[order - 1] = sizes[order - 1].plus(part);
            });
        }
    }
}

/// Adds `2 Re(sizes[n - 1] exp(i n theta))` for n = 1, 2, ... to a sequence.
#[inline(never)]
pub(super) fn add_orders<S: Sample>(sequence: &mut [S], sizes: &[Coefficient]) {
    let Some(split) = Split::of(sequence.len()) else {
        return;
    };
    let circle = split.circle();
    for residue in 0..=split.inner / 2 {
        let factors = split.walk(&circle, residue);
        for start in (0..split.outer).step_by(CHUNK) {
            let mut curves = [[0_i64; 2]; CHUNK];
            let curves = &mut curves[..CHUNK.min(split.outer - start)];
            let mut any = false;
            split.each_order(residue, sizes.len(), |order, mirrored| {
                let size = sizes[order - 1];
                if size.leaves_a_trace() {
                    any = true;
                    split.add_curve(curves, size, order, mirrored, start);
                }
            });
            if any {
                for (curve, p) in curves.iter().zip(start..) {
                    split.add_inner(sequence, p, curve.map(saturated), &factors);
                }
            }
        }
    }
}

/// L = P Q.
#[derive(Clone, Copy)]
struct Split {
    length: usize,
    /// Q, at most [`INNER_MAX`].
    inner: usize,
    /// P.
    outer: usize,
}

impl Split {
    /// The largest Q that fits.
    fn of(length: usize) -> Option<Self> {
        let inner = (1..=INNER_MAX).rev().find(|&q| length.is_multiple_of(q))?;
        Some(Self {
            length,
            inner,
            outer: length / inner,
        })
        .filter(|_| length > 0)
    }

    /// Phasors of all parts of a turn by Q.
    fn circle(self) -> [Phasor; INNER_MAX] {
        core::array::from_fn(|q| phasor(q % self.inner, self.inner))
    }

    /// Every `residue`-th phasor of the circle.
    fn walk(self, circle: &[Phasor; INNER_MAX], residue: usize) -> [Phasor; INNER_MAX] {
        let mut place = 0;
        circle.map(|_| {
            let phasor = circle[place];
            place += residue;
            if place >= self.inner {
                place -= self.inner;
            }
            phasor
        })
    }

    /// Orders of a residue up to `last`, and with "true" those of its negative.
    fn each_order(self, residue: usize, last: usize, mut visit: impl FnMut(usize, bool)) {
        let mut visit_from = |first: usize, mirrored| {
            for order in (first..=last).step_by(self.inner).filter(|&n| n > 0) {
                visit(order, mirrored);
            }
        };
        visit_from(residue, false);
        if residue != 0 && 2 * residue != self.inner {
            visit_from(self.inner - residue, true);
        }
    }

    /// Digits that a sum over q of samples below 2^27 has too many for 31.
    fn excess(self) -> u32 {
        27 + FACTOR_BITS - 30 + self.inner.next_power_of_two().trailing_zeros()
    }

    /// Sum over q of sample p + P q times the factors, conjugate.
    fn inner_sum<S: Sample>(
        self,
        sequence: &[S],
        p: usize,
        factors: &[Phasor; INNER_MAX],
    ) -> [i32; 2] {
        let (mut re, mut im) = (0_i64, 0_i64);
        let samples = sequence[p..].iter().step_by(self.outer);
        for (sample, [cos, sin]) in samples.zip(factors) {
            let value = i64::from(sample.value());
            re += value * i64::from(*cos);
            im -= value * i64::from(*sin);
        }
        let excess = self.excess();
        [re, im].map(|sum| saturated((sum + (1 << excess >> 1)) >> excess))
    }

    /// What a chunk of those sums from p = `start` on adds to an order.
    fn outer_sum(
        self,
        sums: &[[i32; 2]],
        order: usize,
        mirrored: bool,
        start: usize,
    ) -> Coefficient {
        let step = self.step(order);
        let mut now = self.at(order, start);
        let (mut re, mut im) = (0_i64, 0_i64);
        for &[a, b] in sums {
            let [a, b] = [a, if mirrored { -b } else { b }].map(i64::from);
            let [cos, sin] = shortened(now).map(i64::from);
            re += a * cos + b * sin;
            im += b * cos - a * sin;
            now = turned(now, step);
        }
        let down = 2 * FACTOR_BITS - self.excess() - COEFFICIENT_BITS;
        let mean = |sum: i64| saturated((sum / self.length as i64 + (1 << down >> 1)) >> down);
        Coefficient {
            re: mean(re),
            im: mean(im),
        }
    }

    /// Adds an order to the curves of its residue from p = `start` on.
    fn add_curve(
        self,
        curves: &mut [[i64; 2]],
        size: Coefficient,
        order: usize,
        mirrored: bool,
        start: usize,
    ) {
        let step = self.step(order);
        let mut now = self.at(order, start);
        for [re, im] in curves {
            let [a, b] = turned([size.re, size.im], now);
            *re += i64::from(a);
            *im += i64::from(if mirrored { -b } else { b });
            now = turned(now, step);
        }
    }

    /// Adds twice the real part of `curve` times the factors to the samples p + P q.
    fn add_inner<S: Sample>(
        self,
        sequence: &mut [S],
        p: usize,
        [re, im]: [i32; 2],
        factors: &[Phasor; INNER_MAX],
    ) {
        const SHIFT: u32 = SINE_BITS + COEFFICIENT_BITS - 1;
        let samples = sequence[p..].iter_mut().step_by(self.outer);
        for (sample, [cos, sin]) in samples.zip(factors) {
            let product = i64::from(re) * i64::from(*cos) - i64::from(im) * i64::from(*sin);
            #[allow(clippy::cast_possible_truncation)]
            let more = ((product + (1 << (SHIFT - 1))) >> SHIFT) as i32;
            *sample = S::of(sample.value().wrapping_add(more));
        }
    }

    fn step(self, order: usize) -> Phasor {
        phasor(order, self.length)
    }

    fn at(self, order: usize, p: usize) -> Phasor {
        phasor(order * p % self.length, self.length)
    }
}

/// At `part / whole` of a turn.
pub(super) fn phasor(part: usize, whole: usize) -> Phasor {
    #[allow(clippy::cast_possible_truncation)]
    let angle = (((part as u64) << 32) / whole as u64) as u32;
    let (sin, cos) = sin_cos(Turn32(angle));
    [cos, sin]
}

/// With [`FACTOR_BITS`]; rounded, as a bias would count the same in all products.
#[inline]
fn shortened(phasor: Phasor) -> Phasor {
    phasor.map(|x| (x + (1 << DROPPED >> 1)) >> DROPPED)
}

/// A phasor turned by another.
#[inline]
pub(super) fn turned([c, s]: Phasor, [c1, s1]: Phasor) -> Phasor {
    const HALF: i64 = 1 << (SINE_BITS - 1);
    let product = |a: i32, b: i32| i64::from(a) * i64::from(b);
    #[allow(clippy::cast_possible_truncation)]
    [
        ((product(c, c1) - product(s, s1) + HALF) >> SINE_BITS) as i32,
        ((product(s, c1) + product(c, s1) + HALF) >> SINE_BITS) as i32,
    ]
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::super::spectrum::waves::wave;
    use super::*;

    #[test]
    fn a_wave_comes_back_with_its_size_and_phase() {
        let parts = [(3, 6e7, 0.4), (100, 5e3, -1.0), (231, 2e5, 2.0)];
        for samples in [1250, 1001, 2048, 10_000, 997, 480] {
            let x = wave(samples, &parts);
            let mut sizes = [Coefficient::default(); 240];
            take_orders(&x, &mut sizes);
            for (n, size) in (1..).zip(sizes) {
                let part = parts.iter().find(|part| part.0 == n);
                let (size_in, phase) = part.map_or((0.0, 0.0), |part| (part.1, part.2));
                // At 480 samples order 240 would be its own mirror, and 231 is not.
                let expected = [size_in / 2.0 * phase.cos(), size_in / 2.0 * phase.sin()];
                for (got, want) in [size.re, size.im].into_iter().zip(expected) {
                    let off = f64::from(got) / 16.0 - want;
                    assert!(off.abs() < 0.6 + 6e7 * 2e-8, "{samples} {n}: {off}");
                }
            }
        }
    }

    #[test]
    fn orders_added_are_the_wave() {
        for samples in [999, 2500, 1021, 96] {
            let parts = [(7, 1e6, 0.3_f64), (40, 1e4, 1.0), (211, 3e7, -2.0)];
            let parts = &parts[..if samples < 422 { 2 } else { 3 }];
            let mut sizes = [Coefficient::default(); 211];
            for &(n, size, phase) in parts {
                sizes[n - 1] = Coefficient {
                    re: (size * 8.0 * phase.cos()) as i32,
                    im: (size * 8.0 * phase.sin()) as i32,
                };
            }
            let mut x = std::vec![0_i32; samples];
            add_orders(&mut x, &sizes);
            let off = x
                .iter()
                .zip(wave(samples, parts))
                .map(|(got, want)| (got - want).abs());
            assert!(off.max().unwrap() < 6, "{samples}");
        }
    }
}

//! Many orders of a sequence at once, and back: the discrete Fourier transform in two steps, in integers.
//!
//! With L = P Q samples, sample p + P q and order n, `exp(-2 pi i n (p + P q) / L)` is `exp(-2 pi i n p / L)` times
//! `exp(-2 pi i r q / Q)` where r = n mod Q. So the sums over q are shared by all orders of one residue, and as samples are
//! real, by those of -r as well.

use core::mem;
use core::task::{Poll, ready};

use super::close::saturated;
use super::cursor::Cursor;
use super::spectrum::{Coefficient, Sample};
use super::split::{CHUNK, INNER_MAX, Phasor, Split, shortened};

/// Sums over q that a slice makes, samples over q that it draws, and orders that it sums up or draws.
const INNER: usize = 12;
const DRAWN: usize = 8;
const ORDERS: usize = 6;

/// What comes next for a residue.
enum Step {
    /// Its factors.
    Factors,
    /// Sums over q, or samples, from here on.
    Inner(Cursor),
    /// Its orders, from here on.
    Orders(Cursor),
}

/// The way through all residues, and for each through all p, chunk by chunk.
struct Tour {
    step: Step,
    residue: usize,
    start: usize,
    factors: [Phasor; INNER_MAX],
}

impl Tour {
    const START: Self = Self {
        step: Step::Factors,
        residue: 0,
        start: 0,
        factors: [[0; 2]; INNER_MAX],
    };

    /// The p of this chunk.
    fn chunk(&self, split: Split) -> usize {
        CHUNK.min(split.outer - self.start)
    }

    /// Goes on to the next chunk with `step`; ready at the end of the last.
    fn next_chunk(&mut self, split: Split, step: Step) -> Poll<()> {
        (self.start, self.step) = (self.start + CHUNK, step);
        if self.start >= split.outer {
            (self.start, self.step) = (0, Step::Factors);
            self.residue += 1;
        }
        if 2 * self.residue > split.inner {
            Poll::Ready(())
        } else {
            Poll::Pending
        }
    }
}

/// Takes orders 1, 2, ... of a sequence whose samples are below 2^27.
pub(super) struct TakeOrders {
    tour: Tour,
    sums: [[i32; 2]; CHUNK],
}

impl TakeOrders {
    pub(super) const START: Self = Self {
        tour: Tour::START,
        sums: [[0; 2]; CHUNK],
    };

    /// The first slice clears the `sizes`.
    #[inline(never)]
    pub(super) fn slice<S: Sample>(
        &mut self,
        sequence: &[S],
        sizes: &mut [Coefficient],
    ) -> Poll<()> {
        let Some(split) = Split::of(sequence.len()) else {
            return Poll::Ready(());
        };
        let tour = &mut self.tour;
        let chunk = tour.chunk(split);
        match &mut tour.step {
            Step::Factors => {
                if tour.residue == 0 {
                    sizes.fill(Coefficient::default());
                }
                split.walk(&mut tour.factors, tour.residue);
                for factor in &mut tour.factors {
                    *factor = shortened(*factor);
                }
                tour.step = Step::Inner(Cursor::START);
            }
            Step::Inner(cursor) => {
                let stretch = cursor.next(INNER, chunk);
                let places = stretch.clone().map(|p| tour.start + p);
                for (sum, p) in self.sums[stretch].iter_mut().zip(places) {
                    *sum = split.inner_sum(sequence, p, &tour.factors);
                }
                ready!(cursor.at_end(chunk));
                tour.step = Step::Orders(Cursor::START);
            }
            Step::Orders(cursor) => {
                let orders = split.orders(tour.residue, sizes.len());
                for nth in cursor.next(ORDERS, orders.count()) {
                    let (order, mirrored) = orders.nth(nth);
                    let part = split.outer_sum(&self.sums[..chunk], order, mirrored, tour.start);
                    sizes[order - 1] = sizes[order - 1].plus(part);
                }
                ready!(cursor.at_end(orders.count()));
                return tour.next_chunk(split, Step::Inner(Cursor::START));
            }
        }
        Poll::Pending
    }
}

/// Adds `2 Re(sizes[n - 1] exp(i n theta))` for n = 1, 2, ... to a sequence.
pub(super) struct AddOrders {
    tour: Tour,
    curves: [[i64; 2]; CHUNK],
    any: bool,
}

impl AddOrders {
    pub(super) const START: Self = Self {
        tour: Tour::START,
        curves: [[0; 2]; CHUNK],
        any: false,
    };

    #[inline(never)]
    pub(super) fn slice<S: Sample>(
        &mut self,
        sequence: &mut [S],
        sizes: &[Coefficient],
    ) -> Poll<()> {
        let Some(split) = Split::of(sequence.len()) else {
            return Poll::Ready(());
        };
        let tour = &mut self.tour;
        let chunk = tour.chunk(split);
        match &mut tour.step {
            Step::Factors => {
                split.walk(&mut tour.factors, tour.residue);
                tour.step = Step::Orders(Cursor::START);
            }
            Step::Orders(cursor) => {
                let orders = split.orders(tour.residue, sizes.len());
                for nth in cursor.next(ORDERS, orders.count()) {
                    let (order, mirrored) = orders.nth(nth);
                    let size = sizes[order - 1];
                    if size.leaves_a_trace() {
                        self.any = true;
                        let curves = &mut self.curves[..chunk];
                        split.add_curve(curves, size, order, mirrored, tour.start);
                    }
                }
                ready!(cursor.at_end(orders.count()));
                if !self.any {
                    return tour.next_chunk(split, Step::Orders(Cursor::START));
                }
                tour.step = Step::Inner(Cursor::START);
            }
            Step::Inner(cursor) => {
                for p in cursor.next(DRAWN, chunk) {
                    let curve = mem::take(&mut self.curves[p]).map(saturated);
                    split.add_inner(sequence, tour.start + p, curve, &tour.factors);
                }
                ready!(cursor.at_end(chunk));
                self.any = false;
                return tour.next_chunk(split, Step::Orders(Cursor::START));
            }
        }
        Poll::Pending
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::super::cursor::whole;
    use super::super::spectrum::waves::wave;
    use super::*;

    #[test]
    fn a_wave_comes_back_with_its_size_and_phase() {
        let parts = [(3, 6e7, 0.4), (100, 5e3, -1.0), (231, 2e5, 2.0)];
        for samples in [1250, 1001, 2048, 10_000, 997, 480] {
            let x = wave(samples, &parts);
            let mut sizes = [Coefficient::default(); 240];
            let mut take = TakeOrders::START;
            whole(|| take.slice(&x, &mut sizes));
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
            let mut add = AddOrders::START;
            whole(|| add.slice(&mut x, &sizes));
            let off = x
                .iter()
                .zip(wave(samples, parts))
                .map(|(got, want)| (got - want).abs());
            assert!(off.max().unwrap() < 6, "{samples}");
        }
    }
}

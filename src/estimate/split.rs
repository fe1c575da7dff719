//! The two steps of the transform: L = P Q samples, sums over q that all orders of a residue share, and the orders from those.

use super::close::saturated;
use super::spectrum::{COEFFICIENT_BITS, Coefficient, Sample};
use crate::trig::{SINE_BITS, sin_cos};
use crate::units::Turn32;

/// Q at the most.
pub(super) const INNER_MAX: usize = 64;

/// Sums over q that are held at a time.
pub(super) const CHUNK: usize = 32;

/// Digits of sine and cosine dropped where products are summed.
const DROPPED: u32 = 8;

/// Fraction bits that are left.
const FACTOR_BITS: u32 = SINE_BITS - DROPPED;

/// Cosine and sine, Q30.
pub(super) type Phasor = [i32; 2];

/// Orders of one residue, and those of its negative, which are mirrored.
#[derive(Clone, Copy)]
pub(super) struct Orders {
    inner: usize,
    first: [usize; 2],
    counts: [usize; 2],
}

impl Orders {
    pub fn count(&self) -> usize {
        self.counts[0] + self.counts[1]
    }

    /// One of them, and whether it is mirrored.
    pub fn nth(&self, nth: usize) -> (usize, bool) {
        if nth < self.counts[0] {
            (self.first[0] + nth * self.inner, false)
        } else {
            (self.first[1] + (nth - self.counts[0]) * self.inner, true)
        }
    }
}

/// L = P Q.
#[derive(Clone, Copy)]
pub(super) struct Split {
    length: usize,
    /// Q, at most [`INNER_MAX`].
    pub inner: usize,
    /// P.
    pub outer: usize,
}

impl Split {
    /// The largest Q that fits.
    pub fn of(length: usize) -> Option<Self> {
        let inner = (1..=INNER_MAX).rev().find(|&q| length.is_multiple_of(q))?;
        Some(Self {
            length,
            inner,
            outer: length / inner,
        })
        .filter(|_| length > 0)
    }

    /// Fills in the phasors of every `residue`-th part of a turn by Q.
    pub fn walk(self, factors: &mut [Phasor; INNER_MAX], residue: usize) {
        let mut place = 0;
        for factor in factors {
            *factor = phasor(place, self.inner);
            place += residue;
            if place >= self.inner {
                place -= self.inner;
            }
        }
    }

    /// Orders of a residue up to `last`.
    pub fn orders(self, residue: usize, last: usize) -> Orders {
        let own_mirror = residue == 0 || 2 * residue == self.inner;
        let first = [
            if residue == 0 { self.inner } else { residue },
            self.inner - residue,
        ];
        let count = |first: usize| (last + self.inner).saturating_sub(first) / self.inner;
        Orders {
            inner: self.inner,
            first,
            counts: [
                count(first[0]),
                if own_mirror { 0 } else { count(first[1]) },
            ],
        }
    }

    /// Digits that a sum over q of samples below 2^27 has too many for 31.
    fn excess(self) -> u32 {
        27 + FACTOR_BITS - 30 + self.inner.next_power_of_two().trailing_zeros()
    }

    /// Sum over q of sample p + P q times the factors, conjugate.
    pub fn inner_sum<S: Sample>(
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
    pub fn outer_sum(
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
    pub fn add_curve(
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
    pub fn add_inner<S: Sample>(
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

/// At `part / whole` of a turn, of which neither is above 2^16.
pub(super) fn phasor(part: usize, whole: usize) -> Phasor {
    // 2^32 / whole as a whole number and a rest: 64 bits take ten times as long to divide.
    #[allow(clippy::cast_possible_truncation)]
    let (part, whole) = (part as u32, whole as u32);
    let (step, rest) = (u32::MAX / whole, u32::MAX % whole + 1);
    let angle = part
        .wrapping_mul(step)
        .wrapping_add(part.wrapping_mul(rest) / whole);
    let (sin, cos) = sin_cos(Turn32(angle));
    [cos, sin]
}

/// With [`FACTOR_BITS`]; rounded, as a bias would count the same in all products.
#[inline]
pub(super) fn shortened(phasor: Phasor) -> Phasor {
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

//! From summed deviations to a closed turn: every edge's error, with the mean speed and the class means taken out.

use core::mem;
use core::task::{Poll, ready};

use super::Parts;
use super::cursor::Cursor;
use super::fold::thirds;
use super::order::OrderPlan;
use super::scale::{Fine, Ratio};
use crate::shape::CLASSES_MAX;

/// Deviations that a slice adds up, and those that it turns into errors.
const ADDED: usize = 1500;
const WALKED: usize = 200;

/// Lines that a slice goes through at the most: with few classes they cost more than their edges.
const LINES: usize = 400;

/// How a sum over turns becomes angle: it counts 2^`unit_shift` of 2^-32 turn, for turns of `weight_q16` together.
#[derive(Clone, Copy)]
pub(super) struct SumScale {
    pub unit_shift: u32,
    pub weight_q16: u64,
}

impl SumScale {
    /// Factor to 2^-(32 + bits) turn.
    fn ratio(self, bits: u32) -> Ratio {
        Ratio::new(self.unit_shift + 16 + bits, self.weight_q16)
    }
}

/// Where a turn's origin is in a row of summed deviations.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Origin {
    /// At the first one, which is the turn's last.
    First,
    /// At the last one.
    Last,
}

/// Adds up the deviations of a turn.
#[derive(Default)]
struct Total {
    sum: i64,
    cursor: Cursor,
}

/// Runs along the deviations of a turn: edge 0 is the origin, and the turn is closed.
struct Walk {
    /// The mean step as a whole number and a fraction in Q32.
    whole: i64,
    part_q32: i64,
    sum: i64,
    fraction: i64,
    /// The deviation before, where the origin is at the last.
    before: i32,
    origin: Origin,
    cursor: Cursor,
}

impl Total {
    fn slice(&mut self, deviations: &[i32], origin: Origin) -> Poll<Walk> {
        let stretch = self.cursor.next(ADDED, deviations.len());
        let stretch = &deviations[stretch];
        self.sum += stretch.iter().map(|&x| i64::from(x)).sum::<i64>();
        ready!(self.cursor.at_end(deviations.len()));
        let count = deviations.len().max(1) as i64;
        Poll::Ready(Walk {
            whole: self.sum.div_euclid(count),
            part_q32: (self.sum.rem_euclid(count) << 32) / count,
            sum: 0,
            fraction: 0,
            before: 0,
            origin,
            cursor: Cursor::START,
        })
    }
}

impl Walk {
    /// Hands `visit` the next edges and their errors in the sums' unit.
    fn slice(&mut self, slots: &mut [i32], mut visit: impl FnMut(&mut i32, i64)) -> Poll<()> {
        let mut stretch = self.cursor.next(WALKED, slots.len());
        if stretch.start == 0
            && let Some(first) = slots.first_mut()
        {
            self.before = *first;
            visit(first, 0);
            stretch.start = 1;
        }
        for slot in &mut slots[stretch] {
            let here = *slot;
            let before = mem::replace(&mut self.before, here);
            let deviation = match self.origin {
                Origin::First => here,
                Origin::Last => before,
            };
            self.sum += i64::from(deviation) - self.whole;
            self.fraction += self.part_q32;
            visit(slot, (self.fraction >> 32) - self.sum);
        }
        self.cursor.at_end(slots.len())
    }
}

/// A sum that is closed.
#[derive(Clone, Copy)]
enum Closed {
    Weighed,
    Plain,
    PlainContrast,
    Contrast,
}

/// What is done with it.
#[derive(Clone, Copy)]
enum Pass {
    /// The largest error is looked for.
    Measure,
    /// The deviations become errors.
    Close,
}

const PASSES: [(Closed, Pass); 6] = [
    (Closed::Weighed, Pass::Measure),
    (Closed::Plain, Pass::Measure),
    (Closed::Weighed, Pass::Close),
    (Closed::Plain, Pass::Close),
    (Closed::PlainContrast, Pass::Close),
    (Closed::Contrast, Pass::Close),
];

/// How the sums become angle.
#[derive(Clone, Copy)]
pub(super) struct Scales {
    pub weighed: SumScale,
    pub plain: SumScale,
}

/// Closes all sums: of every edge, and at the blocks' first edges.
pub(super) struct Closing {
    pass: usize,
    total: Total,
    walk: Option<Walk>,
    /// Largest error so far, 2^-32 turn.
    largest: u64,
}

impl Closing {
    pub(super) fn new() -> Self {
        Self {
            pass: 0,
            total: Total::default(),
            walk: None,
            largest: 0,
        }
    }

    pub(super) fn slice(
        &mut self,
        parts: &mut Parts<'_>,
        plan: OrderPlan,
        scales: Scales,
    ) -> Poll<Fine> {
        // The class means are still in; what they leave of the range is not worth a second look.
        let fine = Fine::for_angles(self.largest);
        let Some(&(closed, pass)) = PASSES.get(self.pass) else {
            return Poll::Ready(fine);
        };
        let thirds = thirds(parts.coarse).map(|third| &mut third[..plan.blocks]);
        let [plain, plain_contrast, contrast] = thirds;
        let (slots, scale, origin) = match closed {
            Closed::Weighed => (&mut *parts.sum, scales.weighed, Origin::First),
            Closed::Plain => (plain, scales.plain, Origin::Last),
            Closed::PlainContrast => (plain_contrast, scales.plain, Origin::Last),
            Closed::Contrast => (contrast, scales.weighed, Origin::Last),
        };
        let Some(walk) = &mut self.walk else {
            self.walk = Some(ready!(self.total.slice(slots, origin)));
            return Poll::Pending;
        };
        match pass {
            Pass::Measure => {
                let ratio = scale.ratio(0);
                let mut largest = 0;
                let walked = walk.slice(slots, |_, error| {
                    largest = largest.max(error.unsigned_abs())
                });
                let largest = ratio.times(largest.cast_signed()).unsigned_abs();
                self.largest = self.largest.max(largest);
                ready!(walked);
            }
            Pass::Close => {
                let ratio = scale.ratio(fine.bits);
                ready!(walk.slice(slots, |slot, error| *slot = saturated(ratio.times(error))));
            }
        }
        *self = Self {
            pass: self.pass + 1,
            largest: self.largest,
            ..Self::new()
        };
        Poll::Pending
    }
}

/// Takes the mean of every class out of a turn.
pub(super) struct ClassMeans {
    sums: [i64; CLASSES_MAX],
    /// The means, once they are known.
    means: Option<[i32; CLASSES_MAX]>,
    cursor: Cursor,
}

impl ClassMeans {
    pub(super) fn new() -> Self {
        Self {
            sums: [0; CLASSES_MAX],
            means: None,
            cursor: Cursor::START,
        }
    }

    /// In the end, the means less their own mean.
    pub(super) fn slice(&mut self, errors: &mut [i32], classes: usize) -> Poll<[i32; CLASSES_MAX]> {
        let classes = classes.max(1);
        let lines = errors.len() / classes;
        let stretch = self.cursor.next((ADDED / 2 / classes).min(LINES), lines);
        let stretch = &mut errors[stretch.start * classes..stretch.end * classes];
        let Some(mut means) = self.means else {
            for line in stretch.chunks_exact(classes) {
                for (sum, &error) in self.sums.iter_mut().zip(line) {
                    *sum += i64::from(error);
                }
            }
            ready!(self.cursor.at_end(lines));
            let mean = |sum| saturated(rounded_quotient(sum, lines.max(1) as i64));
            self.means = Some(self.sums.map(mean));
            self.cursor = Cursor::START;
            return Poll::Pending;
        };
        for line in stretch.chunks_exact_mut(classes) {
            for (error, mean) in line.iter_mut().zip(means) {
                *error = error.saturating_sub(mean);
            }
        }
        ready!(self.cursor.at_end(lines));
        let total: i64 = means[..classes].iter().map(|&mean| i64::from(mean)).sum();
        let middle = saturated(rounded_quotient(total, classes as i64));
        for mean in &mut means[..classes] {
            *mean -= middle;
        }
        Poll::Ready(means)
    }
}

/// `value` as 32 bits, capped.
#[allow(clippy::cast_possible_truncation)]
pub(super) fn saturated(value: i64) -> i32 {
    value.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32
}

/// Quotient to the nearest integer, halves up.
pub(super) fn rounded_quotient(numerator: i64, denominator: i64) -> i64 {
    (2 * numerator + denominator).div_euclid(2 * denominator)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::super::cursor::whole;
    use super::*;
    use std::vec::Vec;

    #[test]
    fn a_pattern_comes_back_from_its_steps_whatever_the_mean_step() {
        let error = |k: usize| 1000.0 * (k as f64 * 0.9).sin();
        let step = |k: usize| 700 - (error(k) - error((k + 1999) % 2000)) as i32;
        let mut sum: Vec<i32> = (0..2000).map(step).collect();
        // The coarse sums have their origin at the last block.
        let mut coarse: Vec<i32> = (0..3 * 2000).map(|k| step((k + 1) % 2000)).collect();
        let scale = SumScale {
            unit_shift: 0,
            weight_q16: 1 << 16,
        };
        let scales = Scales {
            weighed: scale,
            plain: scale,
        };
        let mut parts = Parts {
            sum: &mut sum,
            cells: &mut [],
            coarse: &mut coarse,
        };
        let plan = OrderPlan::new(2000, 500, 2000);
        let mut closing = Closing::new();
        let fine = whole(|| closing.slice(&mut parts, plan, scales));
        for (k, &found) in sum.iter().enumerate() {
            let found = f64::from(found) / f64::from(1 << fine.bits);
            assert!(
                (found - (error(k) - error(0))).abs() < 1001.0,
                "{k}: {found}"
            );
        }
        assert!(coarse.chunks(2000).all(|third| third == sum));
    }

    #[test]
    fn class_means_leave_nothing_of_a_class() {
        let mut errors: Vec<i32> = (0..4000).map(|k| [5, -3, 8, 2][k % 4] * 100).collect();
        let mut means = ClassMeans::new();
        let means = whole(|| means.slice(&mut errors, 4));
        assert_eq!(means[..4], [200, -600, 500, -100]);
        assert!(errors.iter().all(|&error| error == 0));
    }
}

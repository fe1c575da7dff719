//! Edge classes against speed: what of a class's mean error is angle, and what is time.
//!
//! A delay makes an error in angle that grows with speed, o = c + d / rho with rho the turn's duration over the first one's.
//! Time stamps are as sharp at every speed, so a turn's class means are off in angle by 1 / rho, and turns are weighed with
//! rho^2; the moments are those of least squares.

use core::task::Poll;

use super::close::saturated;
use super::fold::FoldShape;
use super::scale::Fine;
use crate::edge::Direction;
use crate::shape::CLASSES_MAX;
use crate::wide::{over, over_signed};

/// Fraction bits of a relative duration here.
const RATIO_BITS: u32 = 16;

/// Moments over the turns, by class; rho in Q16, nothing rounded.
#[derive(Clone, Copy)]
pub(super) struct Delays {
    /// Sums of rho^2 x and rho x, with x the sum of a class's deviations over a turn.
    by_square: [i128; CLASSES_MAX],
    by_duration: [i128; CLASSES_MAX],
    /// Sum of (rho x)^2.
    squares: [u128; CLASSES_MAX],
    /// Sums of rho^2 and rho, and the number of turns.
    square: u128,
    duration: u64,
    turns: u32,
    /// Smallest rho, of the fastest turn.
    shortest: u64,
    /// Direction of all these turns: a delay moves an edge the other way in reverse.
    direction: Direction,
}

impl Delays {
    pub(super) const NONE: Self = Self {
        by_square: [0; CLASSES_MAX],
        by_duration: [0; CLASSES_MAX],
        squares: [0; CLASSES_MAX],
        square: 0,
        duration: 0,
        turns: 0,
        shortest: u64::MAX,
        direction: Direction::Forward,
    };

    /// Takes the class sums of a turn, if it went the way of the first.
    pub(super) fn take(
        &mut self,
        classes: &[i32; CLASSES_MAX],
        ratio_q32: u64,
        direction: Direction,
    ) {
        if self.turns == 0 {
            self.direction = direction;
        }
        if direction != self.direction {
            return;
        }
        let ratio = i128::from(ratio_q32 >> (32 - RATIO_BITS));
        let sums = classes.iter().map(|&sum| i128::from(sum) * ratio);
        let of_class = self
            .by_square
            .iter_mut()
            .zip(&mut self.by_duration)
            .zip(&mut self.squares);
        for (((by_square, by_duration), squares), scaled) in of_class.zip(sums) {
            *by_square += scaled * ratio;
            *by_duration += scaled;
            *squares += scaled.unsigned_abs() * scaled.unsigned_abs();
        }
        self.square += (ratio * ratio).unsigned_abs();
        self.duration = self.duration.saturating_add(ratio_q32 >> (32 - RATIO_BITS));
        self.shortest = self.shortest.min(ratio_q32 >> (32 - RATIO_BITS));
        self.turns += 1;
    }
}

/// Delays found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct SolvedDelays {
    /// Error that each class has at the first turn's speed for its delay, in sums' units times 2^8, zero mean.
    angle_q8: [i64; CLASSES_MAX],
    unit_shift: u32,
    /// The delays in 2^-8 ticks, and their standard error.
    pub ticks_q8: [i32; CLASSES_MAX],
    pub error_q8: u32,
}

/// A delay counts at so many times its standard error.
const CERTAIN: u128 = 5;

/// Share of the classes' own errors, as a power of one half, that may seem to be delay.
const MIXED_BITS: u32 = 9;

/// Looks for the delays of the classes: least squares with weights rho^2, x = c + d / rho.
pub(super) struct DelayFit {
    /// The next class.
    class: usize,
    /// d and c of the classes so far.
    slopes_q8: [i64; CLASSES_MAX],
    levels_q8: [i64; CLASSES_MAX],
    residual: u128,
}

impl DelayFit {
    pub(super) const START: Self = Self {
        class: 0,
        slopes_q8: [0; CLASSES_MAX],
        levels_q8: [0; CLASSES_MAX],
        residual: 0,
    };

    /// The delays, where the speeds differ enough to show them; `reference` is the first turn's duration.
    #[inline(never)]
    pub(super) fn slice(
        &mut self,
        moments: &Delays,
        shape: &FoldShape,
        reference: u64,
    ) -> Poll<Option<SolvedDelays>> {
        let classes = shape.classes as usize;
        let determinant = moments.determinant();
        // A tenth of spread in speed at least.
        let square = moments.square.cast_signed() * i128::from(moments.turns);
        if classes < 2 || determinant * 100 <= square {
            return Poll::Ready(None);
        }
        if self.class < classes {
            self.fit(
                moments,
                i128::from(shape.edges / shape.classes),
                determinant,
            );
            self.class += 1;
            return Poll::Pending;
        }
        Poll::Ready(self.finish(moments, shape, determinant, reference))
    }

    fn fit(&mut self, moments: &Delays, lines: i128, determinant: i128) {
        let (square, duration, turns) = moments.sums();
        let class = self.class;
        let (a, b) = (moments.by_square[class], moments.by_duration[class]);
        let slope_q8 = over_signed((square * b - duration * a) >> (RATIO_BITS - 8), determinant);
        let level_q8 = over_signed((turns * a - duration * b) << 8, determinant);
        // Sum of rho^2 (x - c - d / rho)^2 = squares - c by_square - d by_duration.
        let explained = (level_q8 * a + ((slope_q8 * b) << RATIO_BITS)) >> 8;
        self.residual += moments.squares[class].saturating_sub(explained.max(0).unsigned_abs());
        // The sum over a class's intervals, to one edge.
        self.slopes_q8[class] = saturated_i64(over_signed(slope_q8, lines));
        self.levels_q8[class] = saturated_i64(over_signed(level_q8, lines));
    }

    fn finish(
        &self,
        moments: &Delays,
        shape: &FoldShape,
        determinant: i128,
        reference: u64,
    ) -> Option<SolvedDelays> {
        let classes = shape.classes as usize;
        let lines = u128::from(shape.edges / shape.classes);
        let freedom = u128::from(moments.turns.saturating_sub(2).max(1)) * classes as u128;
        let variance = over(self.residual, freedom) >> RATIO_BITS;
        // Var d = s^2 square / determinant; Q16 for the 8 bits of the slope.
        let slope_variance_q16 = over(
            variance * (moments.square >> RATIO_BITS),
            (determinant.unsigned_abs() >> RATIO_BITS).max(1),
        );
        let slope_variance_q16 = over(slope_variance_q16, lines * lines);
        let largest_of = |angles: &[i64]| angles.iter().map(|x| x.unsigned_abs()).max();
        let angle_q8 = angles(&self.slopes_q8, classes);
        let largest = u128::from(largest_of(&angle_q8).unwrap_or(0));
        // What ripple and the classes' own errors make together changes with speed too, by a share of these; at the fastest
        // turn that is told from a delay worst.
        let mixed = largest_of(&angles(&self.levels_q8, classes)).unwrap_or(0);
        let mixed = (u128::from(mixed >> MIXED_BITS) * u128::from(moments.shortest)) >> RATIO_BITS;
        let error = (slope_variance_q16 + mixed * mixed).isqrt().max(1);
        if largest <= CERTAIN * error {
            return None;
        }
        // A delay of t ticks makes an edge's error smaller by t / reference of a turn.
        let ticks = |angle_q8| ticks(angle_q8, reference, shape.unit_shift);
        // In reverse the other edge of the channel passes, and what is late is behind.
        let of_class = |class: usize| match moments.direction {
            Direction::Forward => ticks(angle_q8[class]),
            Direction::Reverse if class < classes => {
                ticks(-angle_q8[(class + classes / 2) % classes])
            }
            Direction::Reverse => 0,
        };
        Some(SolvedDelays {
            angle_q8,
            unit_shift: shape.unit_shift,
            ticks_q8: core::array::from_fn(of_class),
            error_q8: ticks(saturated_i64(error.cast_signed()))
                .unsigned_abs()
                .max(1),
        })
    }
}

impl Delays {
    /// Sums of rho^2, rho and 1.
    fn sums(&self) -> (i128, i128, i128) {
        (
            self.square.cast_signed(),
            i128::from(self.duration),
            i128::from(self.turns),
        )
    }

    fn determinant(&self) -> i128 {
        let (square, duration, turns) = self.sums();
        square * turns - duration * duration
    }
}

/// From the mean steps into each class to the classes' errors, zero mean: a step is short by what the error grows.
fn angles(steps: &[i64; CLASSES_MAX], classes: usize) -> [i64; CLASSES_MAX] {
    let total: i64 = steps[..classes].iter().sum();
    let mean = total / classes as i64;
    let mut errors = [0; CLASSES_MAX];
    for class in 1..classes {
        errors[class] = errors[class - 1] - (steps[class] - mean);
    }
    let middle = errors[..classes].iter().sum::<i64>() / classes as i64;
    for error in &mut errors[..classes] {
        *error -= middle;
    }
    errors
}

impl SolvedDelays {
    /// Takes what the delays made at a speed (over the first turn's, Q16) out of class offsets in fine angles.
    pub(super) fn take_from(&self, offsets: &mut [i32; CLASSES_MAX], speed_q16: u64, fine: Fine) {
        for (offset, angle_q8) in offsets.iter_mut().zip(self.angle_q8) {
            let angle =
                (i128::from(angle_q8) * i128::from(speed_q16)) << (self.unit_shift + fine.bits);
            *offset = saturated(i64::from(*offset) - saturated_i64(angle >> 24));
        }
    }
}

/// A delay, 2^-8 tick, whose angle is that with the duration of a turn.
#[inline(never)]
fn ticks(angle_q8: i64, reference: u64, unit_shift: u32) -> i32 {
    let product = i128::from(angle_q8) * i128::from(reference);
    i32::try_from(-product >> (32 - unit_shift)).unwrap_or(0)
}

#[allow(clippy::cast_possible_truncation)]
fn saturated_i64(value: i128) -> i64 {
    value.clamp(i64::MIN.into(), i64::MAX.into()) as i64
}

#[cfg(test)]
mod tests {
    use super::super::cursor::whole;
    use super::*;

    fn solved(moments: &Delays, shape: &FoldShape, reference: u64) -> Option<SolvedDelays> {
        let mut fit = DelayFit::START;
        whole(|| fit.slice(moments, shape, reference))
    }

    #[test]
    fn a_delay_of_one_edge_is_told_from_its_width_by_two_speeds() {
        let shape = FoldShape::new(10_000, 4, 10);
        let (reference, late) = (336_000_000_u64, 17.0);
        // Class errors in the sums' unit at the first speed: widths of a tenth of a step, A's falling edge late by 17 ticks.
        let unit = f64::from(1_u32 << shape.unit_shift) / 4_294_967_296.0;
        let delay = -late / reference as f64 / unit;
        let mut delays = Delays::NONE;
        for (turn, rho) in [1.0, 1.001, 0.999, 0.025, 0.0251, 0.0249]
            .into_iter()
            .enumerate()
        {
            let error = |class: usize| {
                [0.0, 2500.0, -1700.0, 900.0][class % 4]
                    + if class % 4 == 2 { delay / rho } else { 0.0 }
            };
            let mut sums = [0; CLASSES_MAX];
            for (class, sum) in sums.iter_mut().enumerate().take(4) {
                let jitter = f64::from((turn * 7 + class * 3) as u32 % 5) - 2.0;
                *sum = (-2500.0 * (error(class) - error(class + 3)) + jitter) as i32;
            }
            delays.take(&sums, (rho * 4_294_967_296.0) as u64, Direction::Forward);
        }
        let found = solved(&delays, &shape, reference).unwrap();
        // The mean over the classes is nobody's to know.
        for (class, expected) in [-late / 4.0, -late / 4.0, late * 0.75, -late / 4.0]
            .into_iter()
            .enumerate()
        {
            let ticks = f64::from(found.ticks_q8[class]) / 256.0;
            assert!(
                (ticks - expected).abs() < 0.5,
                "{class}: {ticks} {expected}"
            );
        }
    }

    #[test]
    fn widths_alone_at_two_speeds_are_no_delay() {
        let shape = FoldShape::new(10_000, 4, 10);
        let mut delays = Delays::NONE;
        for rho in [1.0, 1.0, 0.03, 0.03] {
            delays.take(
                &[1_000_000, -400_000, -900_000, 300_000, 0, 0],
                (rho * 4_294_967_296.0) as u64,
                Direction::Forward,
            );
        }
        assert!(solved(&delays, &shape, 336_000_000).is_none());
    }
}

//! Edge classes against speed: what of a class's mean error is angle, and what is time.
//!
//! A delay makes an error in angle that grows with speed, o = c + d / rho with rho the turn's duration over the first one's.
//! Time stamps are as sharp at every speed, so a turn's class means are off in angle by 1 / rho, and turns are weighed with
//! rho^2; the moments are those of least squares.

use super::close::saturated;
use super::fold::FoldShape;
use super::scale::Fine;
use crate::edge::Direction;
use crate::shape::CLASSES_MAX;

/// Fraction bits that a squared relative duration keeps here.
const SQUARE_BITS: u32 = 12;

/// Moments over the turns, by class.
#[derive(Clone, Copy)]
pub(super) struct Delays {
    /// Sums of rho^2 x and rho x, Q12, with x the sum of a class's deviations over a turn.
    pub(super) by_square: [i64; CLASSES_MAX],
    pub(super) by_duration: [i64; CLASSES_MAX],
    /// Sum of (rho x)^2.
    pub(super) squares: [u128; CLASSES_MAX],
    /// Sums of rho^2 and rho, Q12, and the number of turns.
    pub(super) square: u64,
    pub(super) duration: u64,
    pub(super) turns: u32,
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
        let ratio = (ratio_q32 >> (32 - SQUARE_BITS)).cast_signed();
        let square = (ratio * ratio) >> SQUARE_BITS;
        for (class, &sum) in classes.iter().enumerate() {
            let sum = i64::from(sum);
            self.by_square[class] = self.by_square[class].saturating_add(sum * square);
            self.by_duration[class] = self.by_duration[class].saturating_add(sum * ratio);
            let scaled = u128::from(((sum * ratio) >> SQUARE_BITS).unsigned_abs());
            self.squares[class] = self.squares[class].saturating_add(scaled * scaled);
        }
        self.square = self.square.saturating_add(square.cast_unsigned());
        self.duration = self.duration.saturating_add(ratio.cast_unsigned());
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

impl Delays {
    /// Delays of the classes, where the speeds differ enough to show them; `reference` is the first turn's duration.
    pub(super) fn solve(&self, shape: &FoldShape, reference: u64) -> Option<SolvedDelays> {
        let classes = shape.classes as usize;
        let lines = i128::from(shape.edges / shape.classes.max(1));
        // Least squares with weights rho^2: x = c + d / rho.
        let (square, duration, turns) = (
            i128::from(self.square),
            i128::from(self.duration),
            i128::from(self.turns) << SQUARE_BITS,
        );
        let determinant = square * turns - duration * duration;
        // A tenth of spread in speed at least.
        if classes < 2 || determinant * 100 <= square * turns {
            return None;
        }
        let mut slopes_q8 = [0_i64; CLASSES_MAX];
        let mut residual = 0_u128;
        for class in 0..classes {
            let (a, b) = (
                i128::from(self.by_square[class]),
                i128::from(self.by_duration[class]),
            );
            let slope_q8 = ((square * b - duration * a) << 8) / determinant;
            let level_q8 = ((turns * a - duration * b) << 8) / determinant;
            // Sum of rho^2 (x - c - d / rho)^2 = squares - c by_square - d by_duration.
            let explained = (level_q8 * a + slope_q8 * b) >> (8 + SQUARE_BITS);
            residual += self.squares[class].saturating_sub(explained.max(0).unsigned_abs());
            // The sum over a class's intervals, to one edge.
            slopes_q8[class] = saturated_i64(slope_q8 / lines);
        }
        let freedom = u128::from(self.turns.saturating_sub(2).max(1)) * classes as u128;
        let variance = residual / freedom;
        // Var d = s^2 square / determinant, each in Q12; Q16 for the 8 bits of the slope.
        let slope_variance_q16 = ((variance << 16) * square.unsigned_abs() << SQUARE_BITS)
            / determinant.unsigned_abs()
            / (lines * lines).unsigned_abs();
        let angle_q8 = angles(&slopes_q8, classes);
        let largest = angle_q8.iter().map(|x| x.unsigned_abs()).max().unwrap_or(0);
        let error = slope_variance_q16.isqrt().max(1);
        if u128::from(largest) <= CERTAIN * error {
            return None;
        }
        // A delay of t ticks makes an edge's error smaller by t / reference of a turn.
        let ticks = |angle_q8: i64| {
            let product = i128::from(angle_q8) * i128::from(reference);
            i32::try_from(-product >> (32 - shape.unit_shift)).unwrap_or(0)
        };
        // In reverse the other edge of the channel passes, and what is late is behind.
        let of_class = |class: usize| match self.direction {
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

#[allow(clippy::cast_possible_truncation)]
fn saturated_i64(value: i128) -> i64 {
    value.clamp(i64::MIN.into(), i64::MAX.into()) as i64
}

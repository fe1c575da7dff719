//! How the shaft is damped beyond the friction that its speed's course shows, told by the angle of locked torque at many speeds.
//!
//! Torque turns the shaft of speed w by an angle that goes with 1 / w^2. Damping d adds d / (n w) of that, a quarter of a cycle on, which goes
//! with 1 / w^3. Both and the disc are fitted to the lowest orders of the turns by least squares, and the order with the most torque says
//! how much of the third there is.

use core::task::{Poll, ready};

use super::cursor::Cursor;
use super::low::{LOW_ORDERS, LowOrder};
use crate::edge::Direction;
use crate::wide::over_signed;

/// Fraction bits of the regressors.
const BITS: u32 = 20;
const ONE: i64 = 1 << BITS;

/// Turns that three regressors are fitted to, at the least.
const TURNS: u16 = 6;

/// Sums over turns. With t the duration over the first turn's the regressors are 1, t^2 - 1 and t^3 - 1.5 t^2 + 0.5.
pub(super) struct Damped {
    direction: Option<Direction>,
    turns: u16,
    /// Of the second and the third regressor, their squares, and their product between those.
    sums: [i64; 2],
    products: [i128; 3],
    /// Of the lowest orders times each regressor.
    orders: [[[i128; 2]; 3]; LOW_ORDERS],
    /// Of the speed's fall in a radian by t^2, times each regressor.
    falls: [i128; 3],
}

/// Damping over the first turn's speed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Told {
    /// Square of it and of its standard error, Q32.
    pub size_q32: u64,
    pub error_q32: u64,
}

impl Damped {
    pub(super) const NONE: Self = Self {
        direction: None,
        turns: 0,
        sums: [0; 2],
        products: [0; 3],
        orders: [[[0; 2]; 3]; LOW_ORDERS],
        falls: [0; 3],
    };

    /// Takes a turn in which the speed falls by so much: those in the direction of the first count.
    pub(super) fn take(
        &mut self,
        direction: Direction,
        ratio_q32: u64,
        low: &[LowOrder; LOW_ORDERS],
        fall_q32: i64,
    ) {
        if *self.direction.get_or_insert(direction) != direction || self.turns == u16::MAX {
            return;
        }
        self.turns += 1;
        let time = (ratio_q32 >> (32 - BITS)).cast_signed();
        let square = (time * time) >> BITS;
        let cube = (square * time) >> BITS;
        let [second, third] = [square - ONE, cube - square - square / 2 + ONE / 2];
        self.sums[0] += second;
        self.sums[1] += third;
        let product = |a: i64, b: i64| i128::from(a) * i128::from(b);
        self.products[0] += product(second, second);
        self.products[1] += product(second, third);
        self.products[2] += product(third, third);
        for (sums, order) in self.orders.iter_mut().zip(low) {
            for (sum, regressor) in sums.iter_mut().zip([1, second, third]) {
                sum[0] += product(order.re.into(), regressor);
                sum[1] += product(order.im.into(), regressor);
            }
        }
        for (sum, regressor) in self.falls.iter_mut().zip([1, second, third]) {
            *sum += product(fall_q32, regressor);
        }
    }

    /// Square of an order's torque over the order.
    fn strength(&self, fit: &Fit, index: usize) -> u128 {
        let [re, im] = [0, 1].map(|part| {
            let [second, _] = fit.fitted(self.orders[index].map(|sum| sum[part]));
            i64::try_from(second >> BITS)
                .unwrap_or(i64::MAX)
                .unsigned_abs()
                / (index as u64 + 1)
        });
        u128::from(re).pow(2) + u128::from(im).pow(2)
    }

    /// The second and the third regressor without what others hold of them; none where turns are few or of one speed.
    fn fit(&self) -> Option<Fit> {
        if self.turns < TURNS {
            return None;
        }
        let turns = i128::from(self.turns);
        let [second, third] = self.sums.map(i128::from);
        let means = [quotient(second, turns), quotient(third, turns)];
        let squares = self.products[0] - second * means[0];
        let mixed = self.products[1] - second * means[1];
        let share_q20 = quotient(mixed << BITS, squares);
        let left = self.products[2] - third * means[1] - ((mixed * share_q20) >> BITS);
        // Speeds within a thousandth tell nothing but how the sums are rounded.
        (left > 0 && squares > turns << (2 * (BITS - 10))).then_some(Fit {
            means,
            squares,
            share_q20,
            left,
        })
    }
}

/// A fit of the regressors to sums.
#[derive(Clone, Copy)]
struct Fit {
    /// Of the second and the third regressor.
    means: [i128; 2],
    /// Sum of the second one's squares about its mean.
    squares: i128,
    /// How much of the third one is the second.
    share_q20: i128,
    /// Sum of squares that the others leave of the third one.
    left: i128,
}

impl Fit {
    const NONE: Self = Self {
        means: [0; 2],
        squares: 0,
        share_q20: 0,
        left: 0,
    };

    /// Sums times the regressors, without what the ones before hold of each.
    #[inline(never)]
    fn fitted(&self, [first, second, third]: [i128; 3]) -> [i128; 2] {
        let second = second - first * self.means[0];
        let third = third - first * self.means[1] - ((second * self.share_q20) >> BITS);
        [second, third]
    }
}

/// What comes next of a [`Telling`].
#[derive(Clone, Copy)]
enum Step {
    Fit,
    /// The order with the most torque is looked for.
    Strength(Cursor),
    /// Real and imaginary part of that.
    Size(Cursor),
    Parts,
    Error,
}

/// Tells the damping beyond friction by the order with the most torque, in slices.
pub(super) struct Telling {
    step: Step,
    fit: Fit,
    /// The most torque yet, and its order less one.
    strength: u128,
    index: usize,
    /// Torque at the first turn's speed, and what goes with the third regressor, Q8: real and imaginary part.
    parts: [[i128; 2]; 2],
    power: i128,
    across: i128,
    along: i128,
}

impl Telling {
    pub(super) const START: Self = Self {
        step: Step::Fit,
        fit: Fit::NONE,
        strength: 0,
        index: 0,
        parts: [[0; 2]; 2],
        power: 1,
        across: 0,
        along: 0,
    };

    /// With friction that goes with a power of the speed, and `noise`, slice by slice, the power of a turn at one of the lowest orders, in
    /// squared units of theirs.
    pub(super) fn slice(
        &mut self,
        damped: &Damped,
        friction_q16: i64,
        noise: impl FnOnce(usize) -> Poll<Option<u64>>,
    ) -> Poll<Option<Told>> {
        match &mut self.step {
            Step::Fit => {
                let Some(fit) = damped.fit() else {
                    return Poll::Ready(None);
                };
                (self.fit, self.step) = (fit, Step::Strength(Cursor::START));
            }
            Step::Strength(cursor) => {
                for index in cursor.next(1, LOW_ORDERS) {
                    let strength = damped.strength(&self.fit, index);
                    if strength >= self.strength {
                        (self.strength, self.index) = (strength, index);
                    }
                }
                ready!(cursor.at_end(LOW_ORDERS));
                self.step = Step::Size(Cursor::START);
            }
            Step::Size(cursor) => {
                let Fit { squares, left, .. } = self.fit;
                for part in cursor.next(1, 2) {
                    let sums = damped.orders[self.index].map(|sum| sum[part]);
                    let [second, third] = self.fit.fitted(sums);
                    self.parts[part] = [
                        quotient(second << BITS, squares),
                        quotient(third << (BITS + 8), left),
                    ];
                }
                ready!(cursor.at_end(2));
                self.step = Step::Parts;
            }
            Step::Parts => {
                self.take_parts(damped, friction_q16);
                self.step = Step::Error;
            }
            Step::Error => {
                let noise = ready!(noise(self.index));
                return Poll::Ready(noise.map(|noise| self.told(noise)));
            }
        }
        Poll::Pending
    }

    /// In parts of the torque: across it is damping's, along it nothing should be, but for what turns of falling speed make.
    fn take_parts(&mut self, damped: &Damped, friction_q16: i64) {
        let order = self.index as i128 + 1;
        let [re, im] = self.parts;
        let power = (re[0] * re[0] + im[0] * im[0]).max(1);
        let [_, fall] = self.fit.fitted(damped.falls);
        let fall_q32 = quotient(fall << BITS, self.fit.left);
        let across = quotient((order * (im[1] * re[0] - re[1] * im[0])) << 24, power);
        let along = quotient((order * (re[1] * re[0] + im[1] * im[0])) << 24, power);
        let share_q16 = |product: i128| quotient(product << 17, power);
        self.across =
            across - ((fall_q32 * (i128::from(friction_q16) + share_q16(im[0] * im[0]))) >> 16);
        self.along = along + ((fall_q32 * share_q16(re[0] * im[0])) >> 16);
        self.power = power;
    }

    fn told(&self, noise: u64) -> Told {
        let order = self.index as i128 + 1;
        let noise = i128::from(noise) / 2;
        let per_regressor = quotient((order * order * noise) << (2 * BITS), self.fit.left);
        let error = quotient(per_regressor.saturating_mul(1 << 32), self.power);
        let square = |part_q32: i128| part_q32.saturating_mul(part_q32) >> 32;
        let fits = |value: i128| u64::try_from(value).unwrap_or(u64::MAX);
        Told {
            size_q32: fits(square(self.across)),
            error_q32: fits(error + square(self.along)).max(1),
        }
    }
}

/// A quotient by a divisor above zero.
fn quotient(value: i128, divisor: i128) -> i128 {
    over_signed(value, divisor.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::cursor::whole;

    fn tell(damped: &Damped, noise: u64) -> Option<Told> {
        let mut telling = Telling::START;
        whole(|| telling.slice(damped, 0, |_| Poll::Ready(Some(noise))))
    }

    /// What is told of torque at order 2 on a shaft of such a damping over the first turn's speed, and how noise is uncertain to make it.
    fn told(damping: f64, noise: u64) -> Told {
        let mut damped = Damped::NONE;
        for turn in 0..33 {
            let time = 1.0 + f64::from(turn) / 100.0;
            let swing = 4e6 * time * time;
            let mut low = [LowOrder {
                re: 40_000,
                im: -9000,
            }; LOW_ORDERS];
            // i of the torque itself, by order, times the damping.
            low[1].re += swing as i32;
            low[1].im += (swing * damping * time / 2.0) as i32;
            damped.take(Direction::Forward, (time * 4_294_967_296.0) as u64, &low, 0);
        }
        tell(&damped, noise).expect("turns enough")
    }

    #[test]
    fn damping_is_told_from_torque_and_disc() {
        for damping in [0.003, 0.1] {
            let told = told(damping, 1 << 20);
            let size = (told.size_q32 as f64 / 4_294_967_296.0).sqrt();
            assert!((size / damping - 1.0).abs() < 0.02, "{damping}: {size}");
        }
        let [quiet, loud] = [1 << 20, 1 << 30].map(|noise| told(0.0, noise).error_q32);
        assert!((900..1200).contains(&(loud / quiet)), "{loud} {quiet}");
    }

    #[test]
    fn turns_of_one_speed_tell_nothing() {
        let mut damped = Damped::NONE;
        for _ in 0..33 {
            damped.take(
                Direction::Forward,
                1 << 32,
                &[LowOrder { re: 40_000, im: 0 }; LOW_ORDERS],
                0,
            );
        }
        assert!(tell(&damped, 1).is_none());
    }
}

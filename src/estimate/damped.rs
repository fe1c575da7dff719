//! How the shaft is damped beyond the friction that its speed's course shows, told by the angle of locked torque at many speeds.
//!
//! Torque turns the shaft of speed w by an angle that goes with 1 / w^2. Damping d adds d / (n w) of that, a quarter of a cycle on, which goes
//! with 1 / w^3. Both and the disc are fitted to the lowest orders of the turns by least squares, and the order with the most torque says
//! how much of the third there is.

use super::low::{LOW_ORDERS, LowOrder};
use crate::edge::Direction;

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

    /// The damping beyond friction that goes with a power of the speed, by the order with the most torque.
    /// `noise` is the power of a turn at one of the lowest orders, in squared units of theirs.
    pub(super) fn told(
        &self,
        friction_q16: i64,
        noise: impl Fn(usize) -> Option<u64>,
    ) -> Option<Told> {
        if self.turns < TURNS {
            return None;
        }
        let turns = i128::from(self.turns);
        let [second, third] = self.sums.map(i128::from);
        let means = [second / turns, third / turns];
        let squares = self.products[0] - second * means[0];
        let mixed = self.products[1] - second * means[1];
        let share_q20 = (mixed << BITS) / squares.max(1);
        // What of the third regressor the others leave.
        let left = self.products[2] - third * means[1] - ((mixed * share_q20) >> BITS);
        if left <= 0 || squares <= 0 {
            return None;
        }
        let fitted = |[first, second, third]: [i128; 3]| {
            let second = second - first * means[0];
            let third = third - first * means[1] - ((second * share_q20) >> BITS);
            [second, third]
        };
        let strength = |index: usize| {
            let [re, im] = [0, 1].map(|part| {
                let [second, _] = fitted(self.orders[index].map(|sum| sum[part]));
                i64::try_from(second >> BITS)
                    .unwrap_or(i64::MAX)
                    .unsigned_abs()
                    / (index as u64 + 1)
            });
            u128::from(re).pow(2) + u128::from(im).pow(2)
        };
        let index = (0..LOW_ORDERS).max_by_key(|&index| strength(index))?;
        let order = index as i128 + 1;
        // Torque at the first turn's speed, and what goes with the third regressor, Q8.
        let [re, im] = [0, 1].map(|part| {
            let [second, third] = fitted(self.orders[index].map(|sum| sum[part]));
            [(second << BITS) / squares, (third << (BITS + 8)) / left]
        });
        let power = (re[0] * re[0] + im[0] * im[0]).max(1);
        let [_, fall] = fitted(self.falls);
        let fall_q32 = (fall << BITS) / left;
        // In parts of the torque: across it is damping's, along it nothing should be, but for what turns of falling speed make.
        let across = ((order * (im[1] * re[0] - re[1] * im[0])) << 24) / power;
        let along = ((order * (re[1] * re[0] + im[1] * im[0])) << 24) / power;
        let share_q16 = |product: i128| (product << 17) / power;
        let across =
            across - ((fall_q32 * (i128::from(friction_q16) + share_q16(im[0] * im[0]))) >> 16);
        let along = along + ((fall_q32 * share_q16(re[0] * im[0])) >> 16);
        let noise = i128::from(noise(index)?) / 2;
        let error = (((order * order * noise) << (2 * BITS)) / left << 32) / power;
        let square = |part_q32: i128| (part_q32 * part_q32) >> 32;
        let fits = |value: i128| u64::try_from(value).unwrap_or(u64::MAX);
        Some(Told {
            size_q32: fits(square(across)),
            error_q32: fits(error + square(along)).max(1),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        damped.told(0, |_| Some(noise)).expect("turns enough")
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
        assert!(damped.told(0, |_| Some(1)).is_none());
    }
}

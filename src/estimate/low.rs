//! The lowest orders of every turn as it comes in: they hold nearly all of the shaft's noise, so their scatter from turn to
//! turn says how well the estimate is known, and which turn does not agree with the others.

use super::close::saturated;
use crate::edge::Direction;
use crate::trig::sin_cos;
use crate::units::Turn32;

/// Orders looked at in every turn.
pub(super) const LOW_ORDERS: usize = 6;

/// Fraction bits of a phasor beside a sample.
const PHASOR_BITS: u32 = 16;

/// Fraction bits of a [`LowOrder`]'s parts.
pub(super) const LOW_BITS: u32 = 4;

/// One order of one turn, complex, 2^-(32 + LOW_BITS) turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct LowOrder {
    pub re: i32,
    pub im: i32,
}

impl LowOrder {
    /// Half way to another.
    pub(super) fn between(self, other: Self) -> Self {
        Self {
            re: i32::midpoint(self.re, other.re),
            im: i32::midpoint(self.im, other.im),
        }
    }

    /// The difference from another.
    pub(super) fn less(self, other: Self) -> Self {
        Self {
            re: self.re.saturating_sub(other.re),
            im: self.im.saturating_sub(other.im),
        }
    }

    /// As a turn in a direction sees what is seen forward, and the other way around.
    pub(super) fn ahead(self, direction: Direction) -> Self {
        match direction {
            Direction::Forward => self,
            Direction::Reverse => Self {
                re: self.re.saturating_neg(),
                ..self
            },
        }
    }

    /// Squared distance.
    pub(super) fn distance(self, other: Self) -> u64 {
        let square = |a: i32, b: i32| (i64::from(a) - i64::from(b)).unsigned_abs().pow(2);
        square(self.re, other.re).saturating_add(square(self.im, other.im))
    }
}

/// Unit phasors of the lowest orders, Q30.
#[derive(Clone, Copy)]
struct Phasor {
    cos: i32,
    sin: i32,
}

/// Sums of the lowest orders over the samples of the turn that is coming in.
#[derive(Clone, Copy)]
pub(super) struct LowOrders {
    step: [Phasor; LOW_ORDERS],
    now: [Phasor; LOW_ORDERS],
    re: [i64; LOW_ORDERS],
    im: [i64; LOW_ORDERS],
    /// From a sum of samples to the mean, from step fractions to turns: 2^45 / (edges samples).
    scale: i64,
    /// 1 / (2 P), Q32.
    half_block_q32: i64,
    /// Blocks of a sample, and those to come until the next.
    apart: u32,
    wait: u32,
}

/// Samples of a turn at the least: six orders need few, and every one costs.
const SAMPLES_MIN: usize = 240;

impl LowOrders {
    /// For turns of `edges` edges in `blocks`.
    pub(super) fn new(edges: usize, blocks: usize) -> Self {
        let mut apart = 1;
        while blocks.is_multiple_of(2 * apart) && blocks / (2 * apart) >= SAMPLES_MIN {
            apart *= 2;
        }
        let samples = (blocks / apart).max(1);
        #[allow(clippy::cast_possible_truncation)]
        let apart = apart as u32;
        let step = core::array::from_fn(|index| {
            #[allow(clippy::cast_possible_truncation)]
            let angle = (((index as u64 + 1) << 32) / samples as u64) as u32;
            let (sin, cos) = sin_cos(Turn32(angle));
            Phasor { cos, sin }
        });
        Self {
            step,
            now: [Phasor {
                cos: 1 << 30,
                sin: 0,
            }; LOW_ORDERS],
            re: [0; LOW_ORDERS],
            im: [0; LOW_ORDERS],
            scale: ((1_u64 << 45) / (edges * samples).max(1) as u64).cast_signed(),
            half_block_q32: (1_i64 << 31) / samples as i64,
            apart,
            wait: apart,
        }
    }

    /// Starts a turn.
    pub(super) fn start(&mut self) {
        self.now = [Phasor {
            cos: 1 << 30,
            sin: 0,
        }; LOW_ORDERS];
        self.re = [0; LOW_ORDERS];
        self.im = [0; LOW_ORDERS];
        self.wait = self.apart;
    }

    /// Takes where the shaft is at the end of a block, in step fractions from the grid.
    pub(super) fn take(&mut self, sample: i32) {
        self.wait -= 1;
        if self.wait != 0 {
            return;
        }
        self.wait = self.apart;
        let high = |a: i32, b: i32, c: i32, d: i32| {
            let sum = i64::from(a) * i64::from(b) + i64::from(c) * i64::from(d);
            #[allow(clippy::cast_possible_truncation)]
            let rounded = ((sum + (1 << 29)) >> 30) as i32;
            rounded
        };
        let sums = self.re.iter_mut().zip(&mut self.im);
        for ((now, step), (re, im)) in self.now.iter_mut().zip(&self.step).zip(sums) {
            *now = Phasor {
                cos: high(now.cos, step.cos, -now.sin, step.sin),
                sin: high(now.sin, step.cos, now.cos, step.sin),
            };
            *re += i64::from(sample) * i64::from(now.cos >> (30 - PHASOR_BITS));
            *im -= i64::from(sample) * i64::from(now.sin >> (30 - PHASOR_BITS));
        }
    }

    /// The orders of the turn that is over: its samples' less those of a motion of constant acceleration through the turn's
    /// ends, which is `linear` too long (2^-32 turn) and has the bend of [`Motion`](super::fold::Motion).
    ///
    /// With x = 0..1 of the turn such a motion is passed at `(1 + linear) (x + bend x (1 - x) + bend^2 x (1 - x) (1 - 2 x))`.
    /// Sampled at the ends of P parts, `x` has the orders i / (2 pi n) - i pi n / (6 P^2) + 1 / (2 P), `x (1 - x)` has
    /// -1 / (2 pi^2 n^2) - 1 / (6 P^2), and `x (1 - x) (1 - 2 x)` has -3 i / (2 pi^3 n^3).
    pub(super) fn finish(&self, linear: i64, bend_q32: i32) -> [LowOrder; LOW_ORDERS] {
        let bend = i64::from(bend_q32);
        let stretched = bend + ((bend * (linear >> 4)) >> 28);
        let square = (bend * bend) >> 32;
        let shorter_q32 = linear - ((linear * linear) >> 32);
        // 1 / (4 P^2) of both, of which 2 pi / 3 and 2 / 3 count.
        let square_q32 = (self.half_block_q32 * self.half_block_q32) >> 32;
        let sampled = |size: i64, share_q16: i64| {
            ((((size >> 4) * square_q32) >> (28 - LOW_BITS)) * share_q16) >> 16
        };
        let (linear_sampled, bend_sampled) = (sampled(linear, 137_258), sampled(stretched, 43_691));
        core::array::from_fn(|index| {
            let mean = |sum: i64| ((sum >> PHASOR_BITS) * self.scale) >> (28 - LOW_BITS);
            let part = |size: i64, share_q16: i64| (size * share_q16) >> (16 - LOW_BITS);
            let offset = (linear * self.half_block_q32) >> (32 - LOW_BITS);
            let re =
                mean(self.re[index]) - offset + part(stretched, BEND_Q16[index]) + bend_sampled;
            let im = mean(self.im[index]) - part(linear, LINEAR_Q16[index])
                + linear_sampled * (index as i64 + 1)
                + part(square, SQUARE_Q16[index]);
            // The samples are as much too large as the turn is too long.
            let own = |size: i64| {
                let size = i64::from(saturated(size));
                saturated(size - ((size * shorter_q32) >> 32))
            };
            LowOrder {
                re: own(re),
                im: own(im),
            }
        })
    }
}

/// 1 / (2 pi n), 1 / (2 pi^2 n^2) and 3 / (2 pi^3 n^3), Q16.
const LINEAR_Q16: [i64; LOW_ORDERS] = [10_430, 5215, 3477, 2608, 2086, 1738];
const BEND_Q16: [i64; LOW_ORDERS] = [3320, 830, 369, 208, 133, 92];
const SQUARE_Q16: [i64; LOW_ORDERS] = [3170, 396, 117, 50, 25, 15];

#[cfg(test)]
mod tests {
    use super::*;

    /// The orders of a turn that is a fiftieth longer than the one before and swings at order 3 by so much of itself, in turns.
    fn orders_of(swing: f64) -> [[f64; 2]; LOW_ORDERS] {
        let (edges, blocks) = (10_000, 1000);
        let mut orders = LowOrders::new(edges, blocks);
        orders.start();
        let (linear, bend) = (0.02, -0.01);
        let steps = f64::from(1 << 15) * edges as f64;
        for i in 1..=blocks {
            let x = i as f64 / blocks as f64;
            let arc = x * (1.0 - x);
            let motion = x + bend * arc + bend * bend * arc * (1.0 - 2.0 * x);
            let swinging = motion + swing * (core::f64::consts::TAU * 3.0 * x + 0.5).cos();
            let angle = (1.0 + linear) * swinging - x;
            orders.take((angle * steps).round() as i32);
        }
        let turn = 4_294_967_296.0;
        let found = orders.finish((linear * turn) as i64, (bend * turn) as i32);
        let unit = turn * f64::from(1 << LOW_BITS);
        found.map(|order| [order.re, order.im].map(|part| f64::from(part) / unit))
    }

    #[test]
    fn a_steady_acceleration_has_no_low_orders_and_a_swing_has_its_own() {
        for swing in [1e-5, 1e-3] {
            for (index, found) in orders_of(swing).into_iter().enumerate() {
                let expected = if index == 2 {
                    [0.5_f64.cos(), 0.5_f64.sin()]
                } else {
                    [0.0; 2]
                };
                for (got, want) in found.into_iter().zip(expected) {
                    let off = got - want * swing / 2.0;
                    assert!(off.abs() < 1e-6, "{index}: {off:e}");
                }
            }
        }
    }
}

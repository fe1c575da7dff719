//! From edge to edge: what stays of angle and speed, and what the torque's noise adds.
//!
//! A twin's torque noise is held constant over each step of a time grid. Where stamps are good and edges few, it shows that the
//! torque of an edge's interval goes on into the next, so the held torque is a state of the filter. Where a twin says nothing of its
//! noise the torque is white, and the state is the mean speed's drift.

use super::kalman::ShaftNoise;
use super::shaft::Leap;

/// Covariance of a state: angle, speed, third state (held acceleration or drift of the speed), and what a spring swings.
pub type Covariance<const N: usize> = [[f64; N]; N];

/// Place of the angle in a state.
pub const ANGLE: usize = 0;
/// Place of the speed.
pub const SPEED: usize = 1;
/// Place of the third state.
pub const THIRD: usize = 2;

/// How a state goes on over a time.
pub trait Way<const N: usize>: Copy {
    /// Puts into a covariance what nobody knows of a shaft at first but angle and speed, whose variance is given, (rad/s)^2.
    fn begin(_start: &mut Covariance<N>, _leap: Leap, _speed2: f64) {}
    /// Over a time, a push being held.
    fn pushed(leap: Leap, after_s: f64) -> Self;
    /// Over all of a leap, the mean speed drifting.
    fn drifting(leap: Leap) -> Self;
    /// This way and then another.
    fn then(self, next: Self) -> Self;
    /// The same, of the third state nothing being left at its end.
    fn over(self) -> Self;
    /// Angle that a speed makes.
    fn reach(&self) -> f64;
    /// State at its end.
    fn on(&self, state: [f64; N]) -> [f64; N];
    /// The transposed of [`Self::on`].
    fn back(&self, state: [f64; N]) -> [f64; N];
    /// The covariance at its end, without noise.
    fn spread(&self, before: &Covariance<N>) -> Covariance<N>;
    /// What is back of a covariance, as [`Self::back`] has it.
    fn spread_back(&self, after: &Covariance<N>) -> Covariance<N>;
    /// What white noise adds over a leap.
    fn stirred(spread: Covariance<N>, leap: Leap, noise: ShaftNoise) -> Covariance<N>;
}

/// How angle y, speed v and third state m of a stiff shaft go on: y + b v + c m, d v + e m, k m.
#[derive(Clone, Copy, Debug)]
pub struct Stiff {
    /// Angle from speed.
    reach: f64,
    /// What stays of the speed.
    stays: f64,
    /// Angle from the third state.
    angle: f64,
    /// Speed from the third state.
    speed: f64,
    /// What stays of the third state.
    keeps: f64,
}

/// Steps of the grid in an interval from which on the noise in between is as good as white.
const MANY: f64 = 6.0;

/// The way of one interval that ends at a time, and the covariance at its end.
#[must_use]
pub fn way<W: Way<N>, const N: usize>(
    leap: Leap,
    ends_s: f64,
    noise: ShaftNoise,
    before: &Covariance<N>,
) -> (W, Covariance<N>) {
    if noise.hold_s > 0.0 {
        let (far, near) = noise.apart();
        let (way, spread) = held(leap, ends_s, near, before);
        (way, W::stirred(spread, leap, far))
    } else {
        let way = W::drifting(leap);
        let spread = W::stirred(way.spread(before), leap, noise);
        (way, spread)
    }
}

impl Way<3> for Stiff {
    fn pushed(leap: Leap, after_s: f64) -> Self {
        let (reach, stays) = leap.reach(after_s);
        let x = leap.damping * after_s;
        Self {
            reach,
            stays,
            angle: if x.abs() < 1e-3 {
                0.5 * after_s * after_s * (1.0 - x / 3.0)
            } else {
                (after_s - reach) / leap.damping
            },
            speed: reach,
            keeps: 1.0,
        }
    }

    fn drifting(leap: Leap) -> Self {
        let (reach, stays) = leap.reach(leap.after_s);
        Self {
            reach,
            stays,
            angle: leap.after_s,
            speed: 0.0,
            keeps: 1.0,
        }
    }

    fn then(self, next: Self) -> Self {
        Self {
            reach: self.reach + next.reach * self.stays,
            stays: next.stays * self.stays,
            angle: self.angle + next.reach * self.speed + next.angle * self.keeps,
            speed: next.stays * self.speed + next.speed * self.keeps,
            keeps: next.keeps * self.keeps,
        }
    }

    fn over(self) -> Self {
        Self { keeps: 0.0, ..self }
    }

    fn reach(&self) -> f64 {
        self.reach
    }

    #[inline(always)]
    fn on(&self, [y, v, m]: [f64; 3]) -> [f64; 3] {
        [
            y + self.reach * v + self.angle * m,
            self.stays * v + self.speed * m,
            self.keeps * m,
        ]
    }

    #[inline(always)]
    fn back(&self, [y, v, m]: [f64; 3]) -> [f64; 3] {
        [
            y,
            self.reach * y + self.stays * v,
            self.angle * y + self.speed * v + self.keeps * m,
        ]
    }

    fn spread(&self, [[yy, yv, ym], [_, vv, vm], [_, _, mm]]: &Covariance<3>) -> Covariance<3> {
        let Self {
            reach: b,
            stays: d,
            angle: c,
            speed: e,
            keeps: k,
        } = self;
        let (ry, rv, rm) = (
            yy + b * yv + c * ym,
            yv + b * vv + c * vm,
            ym + b * vm + c * mm,
        );
        mirrored([
            ry + b * rv + c * rm,
            d * rv + e * rm,
            k * rm,
            d * d * vv + 2.0 * d * e * vm + e * e * mm,
            k * (d * vm + e * mm),
            k * k * mm,
        ])
    }

    fn spread_back(&self, after: &Covariance<3>) -> Covariance<3> {
        let [[yy, yv, ym], [_, vv, vm], [_, _, mm]] = after;
        let Self {
            reach: b,
            stays: d,
            angle: c,
            speed: e,
            keeps: k,
        } = self;
        let (cy, cv, cm) = (
            c * yy + e * yv + k * ym,
            c * yv + e * vv + k * vm,
            c * ym + e * vm + k * mm,
        );
        mirrored([
            *yy,
            b * yy + d * yv,
            cy,
            b * b * yy + 2.0 * b * d * yv + d * d * vv,
            b * cy + d * cv,
            c * cy + e * cv + k * cm,
        ])
    }

    fn stirred(spread: Covariance<3>, leap: Leap, noise: ShaftNoise) -> Covariance<3> {
        let [[yy, yv, ym], [_, vv, vm], [_, _, mm]] = spread;
        let t = leap.after_s;
        let [angle, both, speed] = stir(leap.damping * t);
        let q = noise.acceleration * t;
        mirrored([
            yy + q * t * t * angle + noise.drift * t * t * t / 3.0,
            yv + q * t * both,
            ym + noise.drift * t * t / 2.0,
            vv + q * speed,
            vm,
            mm + noise.drift * t,
        ])
    }
}

/// A covariance from its upper triangle.
fn mirrored([yy, yv, ym, vv, vm, mm]: [f64; 6]) -> Covariance<3> {
    [[yy, yv, ym], [yv, vv, vm], [ym, vm, mm]]
}

/// A new torque: nothing of the old one stays.
fn renewed<const N: usize>(mut spread: Covariance<N>, noise: ShaftNoise) -> Covariance<N> {
    spread[THIRD] = [0.0; N];
    spread.iter_mut().for_each(|row| row[THIRD] = 0.0);
    spread[THIRD][THIRD] = noise.acceleration / noise.hold_s;
    spread
}

fn held<W: Way<N>, const N: usize>(
    leap: Leap,
    ends_s: f64,
    noise: ShaftNoise,
    before: &Covariance<N>,
) -> (W, Covariance<N>) {
    let hold = noise.hold_s;
    let starts_s = ends_s - leap.after_s;
    let next = ((starts_s / hold).floor() + 1.0) * hold;
    if next >= ends_s {
        let way = W::pushed(leap, leap.after_s);
        let spread = way.spread(before);
        return (way, spread);
    }
    let steps = ((ends_s - next) / hold).floor();
    let first = W::pushed(leap, next - starts_s);
    let mut spread = renewed(first.spread(before), noise);
    // The torque that was held until here is over.
    let mut way = first.over();
    let mut go = |after_s: f64, spread: &mut Covariance<N>| {
        let part = W::pushed(leap, after_s);
        *spread = part.spread(spread);
        way = way.then(part);
    };
    if steps > MANY {
        let between = Leap {
            after_s: steps * hold,
            ..leap
        };
        spread[THIRD][THIRD] = 0.0;
        go(between.after_s, &mut spread);
        spread = renewed(W::stirred(spread, between, noise), noise);
    } else {
        for _ in 0..steps as usize {
            go(hold, &mut spread);
            spread = renewed(spread, noise);
        }
    }
    go((ends_s - next - steps * hold).max(0.0), &mut spread);
    (way, spread)
}

/// Variance of the angle, covariance with the speed and variance of the speed that white noise of unit density gives over unit time
/// from rest, damped by `x` (G. E. Uhlenbeck, L. S. Ornstein, Physical Review 36, 1930).
fn stir(x: f64) -> [f64; 3] {
    if x.abs() < 1e-2 {
        return [
            1.0 / 3.0 - x / 4.0 + 7.0 / 60.0 * x * x,
            0.5 * (1.0 - x + 7.0 / 12.0 * x * x),
            1.0 - x + 2.0 / 3.0 * x * x,
        ];
    }
    let forgotten = -(-x).exp_m1();
    let reach = forgotten / x;
    [
        (1.0 - reach - 0.5 * reach * forgotten) / (x * x),
        0.5 * reach * reach,
        reach * (1.0 - 0.5 * forgotten),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEAP: Leap = Leap {
        after_s: 3.7e-3,
        damping: 20.0,
        spring: None,
    };

    fn noise(hold_s: f64) -> ShaftNoise {
        ShaftNoise {
            acceleration: 2.0,
            stamp_s: 0.0,
            drift: 0.0,
            forgets_per_s: 0.0,
            hold_s,
            load: 0.0,
        }
    }

    /// A held torque, step by step of its grid, as the sum of what each step's own does.
    #[test]
    fn held_noise_spreads_as_its_steps_add_up() {
        let (hold_s, ends_s) = (1e-3, 10.2e-3);
        let mut before = [[0.0; 3]; 3];
        before[THIRD][THIRD] = 2.0 / hold_s;
        let (way, spread) = way::<Stiff, 3>(LEAP, ends_s, noise(hold_s), &before);
        let starts_s = ends_s - LEAP.after_s;
        // The torque at the start is over at 7 ms; three whole steps and a part follow.
        let mut angle2 = 0.0;
        for (from, until) in [
            (starts_s, 7e-3),
            (7e-3, 8e-3),
            (8e-3, 9e-3),
            (9e-3, 10e-3),
            (10e-3, ends_s),
        ] {
            let push = Stiff::pushed(LEAP, until - from);
            let free = Stiff::pushed(LEAP, ends_s - until);
            let angle = push.angle + free.reach * push.speed;
            angle2 += angle * angle * 2.0 / hold_s;
        }
        assert!(
            (spread[ANGLE][ANGLE] / angle2 - 1.0).abs() < 1e-9,
            "{} {angle2}",
            spread[ANGLE][ANGLE]
        );
        assert!(way.keeps == 0.0 && way.angle > 0.0);
        let whole = LEAP.reach(LEAP.after_s);
        assert!(
            (way.reach / whole.0 - 1.0).abs() < 1e-9 && (way.stays / whole.1 - 1.0).abs() < 1e-9
        );
    }

    /// Pushes in short steps, each followed to the end.
    #[test]
    fn noise_spreads_as_its_pushes_add_up_however_damped() {
        const STEPS: u32 = 20_000;
        let step = 1.0 / f64::from(STEPS);
        for x in [-0.7, 0.0, 9e-3, 1.1e-2, 0.5, 3.0, 12.0] {
            let mut sums = [0.0; 3];
            for number in 0..STEPS {
                let left = step * (f64::from(number) + 0.5);
                let free = Leap {
                    after_s: left,
                    damping: x,
                    spring: None,
                };
                let (angle, speed) = free.reach(left);
                sums[0] += angle * angle * step;
                sums[1] += angle * speed * step;
                sums[2] += speed * speed * step;
            }
            for (exact, sum) in stir(x).into_iter().zip(sums) {
                assert!((exact / sum - 1.0).abs() < 2e-6, "{x}: {exact} {sum}");
            }
        }
    }

    #[test]
    fn a_fine_grid_is_white() {
        let (_, held) = way::<Stiff, 3>(LEAP, 1.0, noise(2e-5), &[[0.0; 3]; 3]);
        let (_, white) = way::<Stiff, 3>(LEAP, 1.0, noise(0.0), &[[0.0; 3]; 3]);
        for [row, at] in [[ANGLE, ANGLE], [ANGLE, SPEED], [SPEED, SPEED]] {
            assert!(
                (held[row][at] / white[row][at] - 1.0).abs() < 0.03,
                "{held:?} {white:?}"
            );
        }
    }

    #[test]
    fn back_is_the_transpose_of_on() {
        let (way, _) = way::<Stiff, 3>(LEAP, 4.3e-3, noise(5e-3), &[[0.0; 3]; 3]);
        let (a, b) = ([0.3, -2.0, 5.0], [1.5, 0.7, -0.2]);
        let dot = |x: [f64; 3], y: [f64; 3]| x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
        let there = dot(way.on(a), b);
        let back = dot(way.back(b), a);
        assert!((there - back).abs() < 1e-12, "{there} {back}");
    }
}

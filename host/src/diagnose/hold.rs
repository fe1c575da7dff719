//! From edge to edge: what stays of angle and speed, and what the torque's noise adds.
//!
//! A twin's torque noise is held constant over each step of a time grid. Where stamps are good and edges few, it shows that the
//! torque of an edge's interval goes on into the next, so the held torque is a state of the filter. Where a twin says nothing of its
//! noise the torque is white, and the state is the mean speed's drift.

use super::kalman::ShaftNoise;
use super::shaft::Leap;

/// How angle y, speed v and the third state m (held acceleration or drift of the speed) go on: y + b v + c m, d v + e m, k m.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// Angle from speed.
    pub reach: f64,
    /// What stays of the speed.
    pub stays: f64,
    /// Angle from the third state.
    pub angle: f64,
    /// Speed from the third state.
    pub speed: f64,
    /// What stays of the third state.
    pub keeps: f64,
}

/// Upper triangle of the covariance of y, v, m: yy, yv, ym, vv, vm, mm.
pub type Spread = [f64; 6];

/// Steps of the grid in an interval from which on the noise in between is as good as white.
const MANY: f64 = 6.0;

impl Way {
    /// The way of one interval that ends at a time, and the covariance at its end.
    #[must_use]
    pub fn of(leap: Leap, ends_s: f64, noise: ShaftNoise, before: Spread) -> (Self, Spread) {
        if noise.hold_s > 0.0 {
            held(leap, ends_s, noise, before)
        } else {
            let (reach, stays) = leap.reach(leap.after_s);
            let way = Self {
                reach,
                stays,
                angle: leap.after_s,
                speed: 0.0,
                keeps: 1.0,
            };
            (way, stirred(way.spread(before), leap, noise))
        }
    }

    /// Angle, speed and third state at its end.
    #[must_use]
    pub fn on(self, y: f64, v: f64, m: f64) -> (f64, f64, f64) {
        (
            y + self.reach * v + self.angle * m,
            self.stays * v + self.speed * m,
            self.keeps * m,
        )
    }

    /// The transposed of [`Self::on`].
    #[must_use]
    pub fn back(self, y: f64, v: f64, m: f64) -> (f64, f64, f64) {
        (
            y,
            self.reach * y + self.stays * v,
            self.angle * y + self.speed * v + self.keeps * m,
        )
    }

    /// A push held over a time.
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

    /// This way and then another.
    fn then(self, next: Self) -> Self {
        Self {
            reach: self.reach + next.reach * self.stays,
            stays: next.stays * self.stays,
            angle: self.angle + next.reach * self.speed + next.angle * self.keeps,
            speed: next.stays * self.speed + next.speed * self.keeps,
            keeps: next.keeps * self.keeps,
        }
    }

    /// The covariance at its end, without noise.
    fn spread(self, before: Spread) -> Spread {
        let [yy, yv, ym, vv, vm, mm] = before;
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
        [
            ry + b * rv + c * rm,
            d * rv + e * rm,
            k * rm,
            d * d * vv + 2.0 * d * e * vm + e * e * mm,
            k * (d * vm + e * mm),
            k * k * mm,
        ]
    }
}

/// A new torque: nothing of the old one stays.
fn renewed(mut spread: Spread, noise: ShaftNoise) -> Spread {
    spread[2] = 0.0;
    spread[4] = 0.0;
    spread[5] = noise.acceleration / noise.hold_s;
    spread
}

fn held(leap: Leap, ends_s: f64, noise: ShaftNoise, before: Spread) -> (Way, Spread) {
    let hold = noise.hold_s;
    let starts_s = ends_s - leap.after_s;
    let next = ((starts_s / hold).floor() + 1.0) * hold;
    if next >= ends_s {
        let way = Way::pushed(leap, leap.after_s);
        return (way, way.spread(before));
    }
    let steps = ((ends_s - next) / hold).floor();
    let mut way = Way::pushed(leap, next - starts_s);
    let mut spread = renewed(way.spread(before), noise);
    // The torque that was held until here is over.
    way.keeps = 0.0;
    let mut go = |after_s: f64, spread: &mut Spread| {
        let part = Way::pushed(leap, after_s);
        *spread = part.spread(*spread);
        way = way.then(part);
    };
    if steps > MANY {
        let between = Leap {
            after_s: steps * hold,
            ..leap
        };
        spread[5] = 0.0;
        go(between.after_s, &mut spread);
        spread = renewed(stirred(spread, between, noise), noise);
    } else {
        for _ in 0..steps as usize {
            go(hold, &mut spread);
            spread = renewed(spread, noise);
        }
    }
    go((ends_s - next - steps * hold).max(0.0), &mut spread);
    (way, spread)
}

/// What white noise adds over an interval.
fn stirred(mut spread: Spread, leap: Leap, noise: ShaftNoise) -> Spread {
    let t = leap.after_s;
    let [angle, both, speed] = stir(leap.damping * t);
    let q = noise.acceleration * t;
    spread[0] += q * t * t * angle + noise.drift * t * t * t / 3.0;
    spread[1] += q * t * both;
    spread[2] += noise.drift * t * t / 2.0;
    spread[3] += q * speed;
    spread[5] += noise.drift * t;
    spread
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
    };

    fn noise(hold_s: f64) -> ShaftNoise {
        ShaftNoise {
            acceleration: 2.0,
            stamp_s: 0.0,
            drift: 0.0,
            forgets_per_s: 0.0,
            hold_s,
        }
    }

    /// A held torque, step by step of its grid, as the sum of what each step's own does.
    #[test]
    fn held_noise_spreads_as_its_steps_add_up() {
        let (hold_s, ends_s) = (1e-3, 10.2e-3);
        let mut before = [0.0; 6];
        before[5] = 2.0 / hold_s;
        let (way, spread) = Way::of(LEAP, ends_s, noise(hold_s), before);
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
            let push = Way::pushed(LEAP, until - from);
            let free = Way::pushed(LEAP, ends_s - until);
            let angle = push.angle + free.reach * push.speed;
            angle2 += angle * angle * 2.0 / hold_s;
        }
        assert!(
            (spread[0] / angle2 - 1.0).abs() < 1e-9,
            "{} {angle2}",
            spread[0]
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
        let (_, held) = Way::of(LEAP, 1.0, noise(2e-5), [0.0; 6]);
        let (_, white) = Way::of(LEAP, 1.0, noise(0.0), [0.0; 6]);
        for at in [0, 1, 3] {
            assert!(
                (held[at] / white[at] - 1.0).abs() < 0.03,
                "{held:?} {white:?}"
            );
        }
    }

    #[test]
    fn back_is_the_transpose_of_on() {
        let (way, _) = Way::of(LEAP, 4.3e-3, noise(5e-3), [0.0; 6]);
        let (a, b) = ([0.3, -2.0, 5.0], [1.5, 0.7, -0.2]);
        let dot = |x: (f64, f64, f64), y: [f64; 3]| x.0 * y[0] + x.1 * y[1] + x.2 * y[2];
        let there = dot(way.on(a[0], a[1], a[2]), b);
        let back = dot(way.back(b[0], b[1], b[2]), a);
        assert!((there - back).abs() < 1e-12, "{there} {back}");
    }
}

//! From edge to edge where a part of the inertia is behind a spring: what stays of angle, speed, third state and swing, and what the
//! noise of the torques on either side adds.

use super::hold::{ANGLE, Covariance, SPEED, THIRD, Way};
use super::kalman::ShaftNoise;
use super::shaft::{AT_REST, Leap, State};
use super::spring::Spring;

/// Angle, speed, third state, and angle and speed of the swing.
pub const STATES: usize = 5;
const SWING: usize = 3;
const SWINGS: usize = 4;
/// Terms of a covariance's series at the most, and the size of the last one.
const TERMS: usize = 16;
const SMALL: f64 = 1e-10;

type Square = Covariance<STATES>;

/// A way as a matrix.
#[derive(Clone, Copy, Debug)]
pub struct Sprung {
    way: Square,
}

/// The order of a shaft's state.
const ORDER: [usize; 4] = [ANGLE, SPEED, SWING, SWINGS];

impl Sprung {
    /// Of a leap's shaft over a time, the third state being a push or a drift of the speed: a series over a part of it, squared again and
    /// again (C. Moler, C. F. Van Loan, SIAM Review 45, 2003).
    fn over_time(leap: Leap, after_s: f64, held: bool) -> Self {
        let mut way = [[0.0; STATES]; STATES];
        way[THIRD][THIRD] = 1.0;
        let Some(spring) = &leap.spring else {
            return Self { way };
        };
        let (part_s, doublings) = spring.part(after_s, leap.damping);
        let mut column = |place: usize, start: State, push: f64| {
            let end = spring.series(part_s, leap.damping, start, [push, 0.0, 0.0]);
            let rows = ORDER.into_iter().zip(end);
            rows.for_each(|(row, end)| way[row][place] = end);
        };
        for (at, place) in ORDER.into_iter().enumerate() {
            column(place, unit(at), 0.0);
        }
        if held {
            column(THIRD, AT_REST, 1.0);
        }
        for _ in 0..doublings {
            way = times(&way, &way);
        }
        if !held {
            way[ANGLE][THIRD] = after_s;
        }
        Self { way }
    }
}

impl Way<STATES> for Sprung {
    fn begin(start: &mut Square, leap: Leap, speed2: f64) {
        start[SWINGS][SWINGS] = speed2;
        start[SWING][SWING] = leap.spring.map_or(0.0, |spring| speed2 / spring.square);
    }

    fn pushed(leap: Leap, after_s: f64) -> Self {
        Self::over_time(leap, after_s, true)
    }

    fn drifting(leap: Leap) -> Self {
        Self::over_time(leap, leap.after_s, false)
    }

    fn then(self, next: Self) -> Self {
        Self {
            way: times(&next.way, &self.way),
        }
    }

    fn over(mut self) -> Self {
        self.way[THIRD] = [0.0; STATES];
        self
    }

    fn reach(&self) -> f64 {
        self.way[ANGLE][SPEED]
    }

    #[inline]
    fn on(&self, state: [f64; STATES]) -> [f64; STATES] {
        let mut end = [0.0; STATES];
        for (end, row) in end.iter_mut().zip(&self.way) {
            for at in 0..STATES {
                *end += row[at] * state[at];
            }
        }
        end
    }

    #[inline]
    fn back(&self, state: [f64; STATES]) -> [f64; STATES] {
        let mut end = [0.0; STATES];
        for (row, value) in self.way.iter().zip(state) {
            for at in 0..STATES {
                end[at] += row[at] * value;
            }
        }
        end
    }

    fn spread(&self, before: &Square) -> Square {
        times(&times(&self.way, before), &transposed(&self.way))
    }

    fn spread_back(&self, after: &Square) -> Square {
        times(&times(&transposed(&self.way), after), &self.way)
    }

    fn stirred(mut spread: Square, leap: Leap, noise: ShaftNoise) -> Square {
        let t = leap.after_s;
        if let Some(spring) = &leap.spring {
            let added = stirred(spring, leap, noise);
            for (row, at) in ORDER.into_iter().enumerate() {
                for (column, place) in ORDER.into_iter().enumerate() {
                    spread[at][place] += added[row][column];
                }
            }
        }
        spread[ANGLE][ANGLE] += noise.drift * t * t * t / 3.0;
        spread[ANGLE][THIRD] += noise.drift * t * t / 2.0;
        spread[THIRD][ANGLE] = spread[ANGLE][THIRD];
        spread[THIRD][THIRD] += noise.drift * t;
        spread
    }
}

/// Covariance that white torques add to a shaft over a leap, in its state's own order: the series of C' = A C + C A^T + noise over a
/// part, and then twice as long again and again (C. F. Van Loan, IEEE Trans. Autom. Control 23, 1978).
fn stirred(spring: &Spring, leap: Leap, noise: ShaftNoise) -> Covariance<4> {
    let (part_s, doublings) = spring.part(leap.after_s, leap.damping);
    let near = spring.slope(0.0, AT_REST, 1.0);
    let mut term: Covariance<4> =
        near.map(|one| near.map(|other| noise.acceleration * one * other));
    // What pushes the far side swings it back.
    term[3][3] += noise.load;
    let mut sum = [[0.0; 4]; 4];
    let phase = 2.0 * spring.fastest(leap.damping) * part_s;
    let mut size = 1.0;
    for k in 0..TERMS {
        let over = part_s / (k as f64 + 1.0);
        let mut forth = [[0.0; 4]; 4];
        for row in 0..4 {
            for column in 0..4 {
                term[row][column] *= over;
                sum[row][column] += term[row][column];
            }
            // A C, as C is its own transpose.
            forth[row] = spring.slope(leap.damping, term[row], 0.0);
        }
        size *= phase / (k as f64 + 1.0);
        // The angle alone begins with the third term.
        if k > 3 && size < SMALL {
            break;
        }
        for row in 0..4 {
            for column in 0..4 {
                term[row][column] = forth[row][column] + forth[column][row];
            }
        }
    }
    if doublings > 0 {
        let ends = [0, 1, 2, 3].map(|at| spring.series(part_s, leap.damping, unit(at), [0.0; 3]));
        let mut way = transposed(&ends);
        for _ in 0..doublings {
            let later = times(&times(&way, &sum), &transposed(&way));
            add(&mut sum, &later);
            way = times(&way, &way);
        }
    }
    sum
}

/// A state of which one number is 1.
fn unit(at: usize) -> State {
    let mut state = AT_REST;
    state[at] = 1.0;
    state
}

#[inline]
fn add<const N: usize>(sum: &mut Covariance<N>, more: &Covariance<N>) {
    for row in 0..N {
        for column in 0..N {
            sum[row][column] += more[row][column];
        }
    }
}

#[inline]
fn transposed<const N: usize>(square: &Covariance<N>) -> Covariance<N> {
    let mut turned = [[0.0; N]; N];
    for row in 0..N {
        for column in 0..N {
            turned[column][row] = square[row][column];
        }
    }
    turned
}

#[inline]
fn times<const N: usize>(one: &Covariance<N>, other: &Covariance<N>) -> Covariance<N> {
    let mut product = [[0.0; N]; N];
    for row in 0..N {
        for middle in 0..N {
            let factor = one[row][middle];
            for column in 0..N {
                product[row][column] += factor * other[middle][column];
            }
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::hold::way;
    use crate::twin::TorsionalResonance;

    fn leap(after_s: f64) -> Leap {
        Leap {
            after_s,
            damping: 20.0,
            spring: Some(Spring::of(&TorsionalResonance {
                f_hz: 120.0,
                damping_ratio: 0.02,
                inertia_share: 0.3,
                load_psd_n2_m2_s: None,
                load_hold_s: None,
            })),
        }
    }

    fn noise(hold_s: f64) -> ShaftNoise {
        ShaftNoise {
            acceleration: 2.0,
            stamp_s: 0.0,
            drift: 0.0,
            forgets_per_s: 0.0,
            hold_s,
            load: 3.0,
        }
    }

    /// Pushes on either side in short steps, each followed to the end; over less and over more than a period of the swing.
    #[test]
    fn noise_spreads_as_its_pushes_add_up() {
        const STEPS: u32 = 4_000;
        for after_s in [2e-4, 3e-2] {
            let step = after_s / f64::from(STEPS);
            let mut sums = [[0.0; 4]; 4];
            for number in 0..STEPS {
                let left = step * (f64::from(number) + 0.5);
                let stride = leap(left).stride();
                let spring = leap(left).spring.unwrap();
                for (push, density) in [
                    (spring.slope(0.0, [0.0; 4], 1.0), 2.0),
                    ([0.0, 0.0, 0.0, -1.0], 3.0),
                ] {
                    let end = stride.step(push, [0.0; 3]);
                    add(
                        &mut sums,
                        &end.map(|one| end.map(|other| density * step * one * other)),
                    );
                }
            }
            let exact = stirred(&leap(after_s).spring.unwrap(), leap(after_s), noise(0.0));
            for (row, at) in [(0, 0), (0, 1), (1, 1), (1, 3), (3, 3)] {
                let (exact, sum) = (exact[row][at], sums[row][at]);
                assert!(
                    (exact / sum - 1.0).abs() < 1e-5,
                    "{after_s} {row} {at}: {exact} {sum}"
                );
            }
        }
    }

    /// A spring so hard that nothing swings, and a torque that is held: as a stiff shaft.
    #[test]
    fn behind_a_hard_spring_it_goes_as_a_stiff_shaft() {
        use crate::diagnose::hold::Stiff;
        let hard = Leap {
            spring: leap(0.0).spring.map(|spring| Spring {
                square: 1e10,
                damping: 1e5,
                ..spring
            }),
            ..leap(3.7e-3)
        };
        let mut before = [[0.0; STATES]; STATES];
        before[THIRD][THIRD] = 2.0 / 1e-3;
        let quiet = ShaftNoise {
            load: 0.0,
            ..noise(1e-3)
        };
        let (sprung, spread) = way::<Sprung, STATES>(hard, 10.2e-3, quiet, &before);
        let mut before = [[0.0; 3]; 3];
        before[THIRD][THIRD] = 2.0 / 1e-3;
        let stiff = Leap {
            spring: None,
            ..hard
        };
        let (stiff, expected) = way::<Stiff, 3>(stiff, 10.2e-3, quiet, &before);
        assert!((spread[ANGLE][ANGLE] / expected[ANGLE][ANGLE] - 1.0).abs() < 1e-3);
        assert!((sprung.reach() / stiff.reach() - 1.0).abs() < 1e-3);
    }

    #[test]
    fn back_is_the_transpose_of_on() {
        let (way, _) =
            way::<Sprung, STATES>(leap(3.7e-3), 4.3e-3, noise(5e-3), &[[0.0; STATES]; STATES]);
        let (a, b) = ([0.3, -2.0, 5.0, 0.1, 7.0], [1.5, 0.7, -0.2, 2.0, 1e-3]);
        let dot = |one: [f64; STATES], other: [f64; STATES]| -> f64 {
            one.iter().zip(other).map(|(one, other)| one * other).sum()
        };
        let there = dot(way.on(a), b);
        let back = dot(way.back(b), a);
        assert!((there - back).abs() < 1e-9 * there.abs(), "{there} {back}");
    }
}

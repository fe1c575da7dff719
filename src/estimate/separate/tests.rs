//! Side bands against a plain Fourier sum.

extern crate std;
use super::*;
use crate::edge::Direction;
use crate::estimate::course::Course;
use crate::estimate::damping::Damping;
use crate::estimate::speeds::{Speeds, Weighing};
use std::vec::Vec;

const SAMPLES: usize = 4096;
/// Share of the speed that goes in a radian.
const FALL: f64 = 2e-3;
const SIZE: Coefficient = Coefficient {
    re: 50_000_000,
    im: -80_000_000,
};

fn angle(sample: usize) -> f64 {
    core::f64::consts::TAU * sample as f64 / SAMPLES as f64
}

/// What torque of an order makes beside its angle at a steady speed, folded between the ends of the turn.
fn beside(order: usize, friction: f64) -> Vec<f64> {
    let n = order as f64;
    let (re, im) = (f64::from(SIZE.re), f64::from(SIZE.im));
    let wave = |theta: f64| 2.0 * (re * (n * theta).cos() - im * (n * theta).sin());
    let quadrature = |theta: f64| -2.0 * (re * (n * theta).sin() + im * (n * theta).cos());
    let of = |sample| {
        let theta = angle(sample);
        let middle = theta - core::f64::consts::PI;
        let swing = 2.0 * middle * (wave(theta) - wave(0.0));
        FALL * (swing + (3.0 + friction) / n * quadrature(theta))
    };
    (0..SAMPLES).map(of).collect()
}

#[test]
fn side_bands_are_those_of_a_turn_of_falling_speed() {
    for (order, friction) in [(1, 1), (5, 0), (5, 2), (40, 1)] {
        let curve = beside(order, f64::from(friction));
        let known = Known { order, size: SIZE };
        for at in 1..=60 {
            let sum = |turn: fn(f64) -> f64| {
                let parts = curve.iter().enumerate();
                let sum: f64 = parts.map(|(k, x)| x * turn(at as f64 * angle(k))).sum();
                sum / SAMPLES as f64
            };
            let exact = [sum(f64::cos), -sum(f64::sin)];
            let fall_q30 = (FALL * f64::from(1 << 30)) as i64;
            let told = known.beside(at, i64::from(friction) << 16, fall_q30);
            for (told, exact) in [told.re, told.im].into_iter().zip(exact) {
                let off = (f64::from(told) - exact).abs();
                assert!(off < 300.0, "{order} at {at}: {told} {exact}");
            }
        }
    }
}

/// What the angle is at edges that a swing passes at the time, in turns: the mean of the whole by an order.
#[test]
fn products_are_those_of_the_motion_itself() {
    // Swings of orders 2 and 3, radians: the angle is r where the slope of the time's is -(1 + slope)^(-1/2).
    let swings = [(2, 3e-3, 0.4), (3, 2e-3, -1.1)];
    let fine = Fine { bits: 4 };
    let unit = 2_f64.powi(40) / core::f64::consts::TAU;
    let known = swings.map(|(order, size, phase): (usize, f64, f64)| Known {
        order,
        // The sums hold what is off with a minus.
        size: Coefficient {
            re: (-size / 2.0 * unit * phase.cos()) as i32,
            im: (-size / 2.0 * unit * phase.sin()) as i32,
        },
    });
    // (w + v)^2 = w^2 (1 - 2 dr / d theta).
    let slope = |theta: f64| -> f64 {
        let parts = swings.iter();
        parts
            .map(|&(n, size, phase)| -size * n as f64 * (n as f64 * theta + phase).sin())
            .sum()
    };
    let time_slope = |theta: f64| (1.0 - 2.0 * slope(theta)).sqrt().recip() - 1.0 - slope(theta);
    for order in [1, 4, 5, 6] {
        // i n times an order is that of the slope.
        let [mut re, mut im] = [0.0; 2];
        for theta in (0..SAMPLES).map(angle) {
            let (sin, cos) = (order as f64 * theta).sin_cos();
            re += time_slope(theta) * cos / SAMPLES as f64;
            im -= time_slope(theta) * sin / SAMPLES as f64;
        }
        let exact = [im, -re].map(|part| -part / order as f64 * unit);
        let mut told = Coefficient::ZERO;
        for (at, one) in known.iter().enumerate() {
            for other in &known[..=at] {
                if let Some(both) = one.with(*other, order, 1 << 30, fine) {
                    told = told.plus(both);
                }
            }
        }
        let off = (f64::from(told.re) - exact[0]).hypot(f64::from(told.im) - exact[1]);
        let size = exact[0].hypot(exact[1]);
        assert!(
            size > 1e5 && off < 0.02 * size,
            "{order}: {told:?} {exact:?}"
        );
    }
}

#[test]
fn torque_is_met_where_the_mounting_puts_the_edges() {
    let fine = Fine { bits: 4 };
    let unit = 2_f64.powi(40) / core::f64::consts::TAU;
    let (torque, mounting) = (6e-4, [5e-4, 1e-4]);
    let of = |size: f64, phase: f64| Coefficient {
        re: (size / 2.0 * unit * phase.cos()) as i32,
        im: (size / 2.0 * unit * phase.sin()) as i32,
    };
    let known = Known {
        order: 5,
        size: of(-torque, 0.3),
    };
    let mounted = [of(mounting[0], 0.7), of(mounting[1], -1.9)];
    let error =
        |theta: f64| mounting[0] * (theta + 0.7).cos() + mounting[1] * (2.0 * theta - 1.9).cos();
    let swing = |theta: f64| torque * (5.0 * theta + 0.3).cos();
    for order in [3, 4, 6, 7] {
        let [mut re, mut im] = [0.0; 2];
        for theta in (0..SAMPLES).map(angle) {
            let met = -(swing(theta - error(theta)) - swing(theta)) / SAMPLES as f64 * unit;
            let (sin, cos) = (order as f64 * theta).sin_cos();
            re += met * cos;
            im -= met * sin;
        }
        let told = known.with_mounting(mounted, order, fine, 1 << 30);
        let off = (f64::from(told.re) - re).hypot(f64::from(told.im) - im);
        assert!(off < 0.01 * re.hypot(im), "{order}: {told:?} {re} {im}");
    }
}

/// What is left at orders 1 to 20 of a weighed mean of five turns each of these durations, with a torque at order 5 as it is in turns of
/// 40 million ticks.
fn left_of_torque(durations: [u64; 2], torque: Known, fine: Fine) -> Vec<Coefficient> {
    let mut speeds = Speeds::NONE;
    let mut weighing = Weighing::NEW;
    let turns: Vec<_> = durations.into_iter().flat_map(|ticks| [ticks; 5]).collect();
    let places: Vec<_> = turns
        .iter()
        .map(|&ticks| speeds.place(ticks).unwrap())
        .collect();
    for (at, &place) in places.iter().enumerate() {
        weighing.add(place.bin);
        speeds.count(place, at % 2 == 0);
    }
    let mut course = Course::NONE;
    for (&ticks, &place) in turns.iter().zip(&places) {
        course.take((ticks, Direction::Forward, place), None, 0, &weighing);
    }
    let moments = Moments::of(&speeds, &weighing, true);

    let mean = |weight: &dyn Fn(usize) -> f64, power: i32| {
        let parts = turns.iter().zip(&places).map(|(&ticks, place)| {
            let weight = weight(place.bin);
            [weight, weight * (ticks as f64 / 40e6).powi(power)]
        });
        let [weights, sum] = parts.fold([0.0; 2], |sum, part| [sum[0] + part[0], sum[1] + part[1]]);
        (sum / weights * f64::from(1 << 30)) as i64
    };
    let means = |power| {
        let weighed = mean(&|bin| weighing.weight_q16(bin) as f64, power);
        [weighed, mean(&|_| 1.0, power) - weighed]
    };
    let mut orders = std::boxed::Box::new(Orders {
        coefficients: [Coefficient::ZERO; ORDERS_MAX],
        noise: [1000; ORDERS_MAX],
        own: [0; ORDERS_MAX],
        difference: [Coefficient::ZERO; ORDERS_MAX],
        doubt: [1_000_000; ORDERS_MAX],
    });
    let twice = torque.with(torque, 10, 1 << 30, fine).unwrap();
    for (order, size, power) in [(5, torque.size, 2), (10, twice, 4)] {
        let [weighed, more] = means(power).map(|share| size.scaled(share));
        (orders.coefficients[order - 1], orders.difference[order - 1]) = (weighed, more);
    }

    let damping = Damping {
        likely_q32: 0,
        most_q32: 0,
    };
    let falls = course.falls(moments.weight_q16, moments.turns);
    let mut separation = Separation::new(&moments, Shaft { damping, falls });
    let mut torques = Torques::NONE;
    let plan = OrderPlan::new(10_000, 2500, 1000);
    while separation
        .slice(plan, &mut orders, fine, &mut torques)
        .is_pending()
    {}
    orders.coefficients[..20].to_vec()
}

#[test]
fn products_are_taken_out_as_well_from_a_fast_first_turn_as_from_a_slow_one() {
    let torque = Known {
        order: 5,
        size: Coefficient {
            re: 12_000_000,
            im: -8_000_000,
        },
    };
    for durations in [[40_000_000, 1_000_000], [1_000_000, 40_000_000]] {
        for (index, left) in left_of_torque(durations, torque, Fine { bits: 4 })
            .into_iter()
            .enumerate()
        {
            let order = index + 1;
            assert!(left.power() < 100 * 100, "{durations:?} {order}: {left:?}");
        }
    }
}

use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;

mod recordings;

fn one_speed() -> Rig {
    Rig {
        scenario: Scenario::OneSpeed,
        lines: 2500,
    }
}

fn problem(scenario: Scenario, lines: u32, points: usize, every: bool) -> Problem {
    let orders: Vec<usize> = (1..points / 2).collect();
    Problem {
        passes: passes(Rig { scenario, lines }),
        points,
        stamp_share: points as f64 / (4.0 * f64::from(lines)),
        ripple: if every { orders.clone() } else { Vec::new() },
        orders,
    }
}

/// Covariance of the angle between two times, 0 at time 0, of a settled shaft, plus the time stamps' on the diagonal.
fn covariance(pass: &Pass, times: &[f64], share: f64) -> DMatrix<f64> {
    let d = pass.shaft.damping;
    // Where the start speed may be anything, its variance changes nothing.
    let level = pass.shaft.density / (2.0 * d) / (d * d);
    DMatrix::from_fn(times.len(), times.len(), |i, j| {
        let (s, t) = (times[i].min(times[j]), times[i].max(times[j]));
        let motion = 2.0 * d * s - 1.0 + (-d * s).exp() + (-d * t).exp() - (-d * (t - s)).exp();
        let stamp = if i == j {
            (pass.speed(t) * pass.stamp_s).powi(2) * share
        } else {
            0.0
        };
        level * motion + stamp
    })
}

#[test]
fn the_filter_gives_what_the_whole_covariance_matrix_gives() {
    for (scenario, every) in [
        (Scenario::OneSpeed, false),
        (Scenario::TwoSpeeds, true),
        (Scenario::Ramp, true),
    ] {
        let mut problem = problem(scenario, 2500, 16, every);
        // The closed form of the covariance loses digits where steps are short: larger stamp errors keep it sound.
        problem.passes.iter_mut().for_each(|pass| {
            pass.turns = pass.turns.min(8);
            pass.stamp_s *= 100.0;
        });
        let fast = Gls::new(problem.clone()).unwrap().variances();
        let trends: Vec<usize> = problem
            .passes
            .iter()
            .map(|p| p.trends(&[0.0]).len())
            .collect();
        let locked = 2 * (problem.orders.len() + problem.ripple.len());
        let unknowns = locked + trends.iter().sum::<usize>();
        let mut information = DMatrix::<f64>::zeros(unknowns, unknowns);
        for (at, pass) in problem.passes.iter().enumerate() {
            let times = pass.times(problem.points);
            let mut design = DMatrix::<f64>::zeros(times.len(), unknowns);
            for (i, order) in problem.orders.iter().enumerate() {
                for row in 0..times.len() {
                    let (sin, cos) = (TAU * (order * row) as f64 / problem.points as f64).sin_cos();
                    design[(row, 2 * i)] = cos;
                    design[(row, 2 * i + 1)] = sin;
                }
                if every {
                    for (part, series) in pass.ripple(*order, &times).iter().enumerate() {
                        let column = 2 * problem.orders.len() + 2 * i + part;
                        design.column_mut(column).copy_from_slice(series);
                    }
                }
            }
            let own = locked + trends[..at].iter().sum::<usize>();
            for (i, series) in pass.trends(&times).iter().enumerate() {
                design.column_mut(own + i).copy_from_slice(series);
            }
            let factor = covariance(pass, &times, problem.stamp_share)
                .cholesky()
                .unwrap();
            information += design.tr_mul(&factor.solve(&design));
        }
        let scale = information.diagonal().map(|x| 1.0 / x.sqrt());
        let scaled = DMatrix::from_fn(unknowns, unknowns, |r, c| {
            information[(r, c)] * scale[r] * scale[c]
        });
        let inverse = scaled.cholesky().unwrap().inverse();
        for (i, fast) in fast.iter().enumerate() {
            let of = |c: usize| inverse[(c, c)] * scale[c].powi(2);
            let plain = f64::midpoint(of(2 * i), of(2 * i + 1));
            assert!(
                (fast / plain - 1.0).abs() < 1e-3,
                "{scenario:?} {i}: {fast:e} {plain:e}"
            );
        }
    }
}

#[test]
fn at_15_r_min_order_1_is_known_to_1_5e_minus_4_rad() {
    let bound = bound(one_speed(), LockedTorque::None, 64);
    assert!(
        (bound.orders[0] / 1.5e-4 - 1.0).abs() < 0.02,
        "{:e}",
        bound.orders[0]
    );
}

#[test]
fn a_long_recording_comes_to_the_closed_form() {
    // By plain arithmetic: 2 S / T with S = q / (w^2 (w^2 + d^2)), at the rotation's own frequency.
    let pass = passes(one_speed())[0];
    let w = anywhere::slow_rad_s();
    let d = 2.0 * w;
    let q = 2.0 * d * (1e-3 * w).powi(2);
    let plain = 2.0 * q / (w * w * (w * w + d * d)) / (11.0 * TAU / w);
    assert!((high::variance(&[pass], 1.0, 10_000, false) / plain - 1.0).abs() < 1e-3);

    for scenario in [Scenario::OneSpeed, Scenario::TwoSpeeds] {
        let every = scenario == Scenario::TwoSpeeds;
        let mut long = problem(scenario, 2500, 32, every);
        long.passes.iter_mut().for_each(|pass| pass.turns = 300);
        let exact = Gls::new(long.clone()).unwrap().variances();
        for order in 1..=5 {
            let closed = high::variance(&long.passes, order as f64, 10_000, every);
            let ratio = exact[order - 1] / closed;
            assert!(
                (ratio - 1.0).abs() < 0.03,
                "{scenario:?}, order {order}: {ratio}"
            );
        }
    }
}

#[test]
fn the_closed_form_goes_on_where_the_exact_solution_ends() {
    for (scenario, torque) in [
        (Scenario::OneSpeed, LockedTorque::None),
        (Scenario::TwoSpeeds, LockedTorque::Every),
        (Scenario::Ramp, LockedTorque::None),
        (Scenario::Ramp, LockedTorque::Every),
    ] {
        let rig = Rig {
            scenario,
            lines: 2500,
        };
        let last = 16;
        let exact = bound(rig, torque, 4 * last).orders[last - 1];
        let closed = high::variance(
            &passes(rig),
            last as f64,
            10_000,
            torque == LockedTorque::Every,
        );
        let ratio = exact / closed.sqrt();
        assert!(
            (ratio - 1.0).abs() < 0.06,
            "{scenario:?} {torque:?}: {ratio}"
        );
    }
}

#[test]
fn half_the_points_give_the_same_bound() {
    for scenario in [Scenario::OneSpeed, Scenario::TwoSpeeds, Scenario::Ramp] {
        let rig = Rig {
            scenario,
            lines: 2500,
        };
        let torque = if scenario == Scenario::OneSpeed {
            LockedTorque::None
        } else {
            LockedTorque::Every
        };
        let (few, many) = (bound(rig, torque, 32).rms(), bound(rig, torque, 64).rms());
        assert!(
            (few / many - 1.0).abs() < 0.01,
            "{scenario:?}: {few:e} {many:e}"
        );
    }
}

#[test]
fn one_speed_can_not_tell_geometry_from_locked_torque() {
    let none = bound(one_speed(), LockedTorque::Every, 64);
    assert!(none.rms().is_infinite());
    let some = bound(one_speed(), LockedTorque::Cogging, 64);
    assert_eq!(some.unknown(), [5, 10, 15, 30]);
    let truth: Vec<f64> = (0..10_000)
        .map(|k| 3e-4 * (TAU * 5.0 * f64::from(k) / 1e4).sin())
        .collect();
    let expected = some.rms().hypot(3e-4 / 2.0_f64.sqrt());
    assert!((some.rms_left_alone(&truth) / expected - 1.0).abs() < 1e-9);
}

/// A standard normal number.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (u, v): (f64, f64) = (rng.random(), rng.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * v).cos()
}

/// Angles of a shaft pushed by noise, in fine steps of plain Euler, read with normal errors.
fn noisy_angles(pass: &Pass, times: &[f64], share: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    const FINE: usize = 20;
    let shaft = pass.shaft;
    let mut speed = shaft.start_variance().sqrt() * normal(rng);
    let (mut angle, mut before) = (0.0, 0.0);
    let read = times.iter().map(|&time| {
        let step = (time - before) / FINE as f64;
        for _ in 0..FINE {
            angle += speed * step;
            speed -= shaft.damping * speed * step;
            speed += (shaft.density * step).sqrt() * normal(rng);
        }
        before = time;
        angle + pass.speed(time) * pass.stamp_s * share.sqrt() * normal(rng)
    });
    read.collect()
}

#[test]
fn the_estimator_errs_as_much_as_the_bound_says_on_simulated_noise() {
    for (scenario, every) in [
        (Scenario::OneSpeed, false),
        (Scenario::TwoSpeeds, true),
        (Scenario::Ramp, true),
    ] {
        let problem = problem(scenario, 2500, 16, every);
        let gls = Gls::new(problem.clone()).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let draws = 300;
        let mut powers = vec![0.0; problem.orders.len()];
        for _ in 0..draws {
            let deviations: Vec<Vec<f64>> = problem
                .passes
                .iter()
                .map(|pass| noisy_angles(pass, &pass.times(16), problem.stamp_share, &mut rng))
                .collect();
            for (power, [a, b]) in powers.iter_mut().zip(gls.estimate(&deviations)) {
                *power += (a * a + b * b) / 2.0 / f64::from(draws);
            }
        }
        for (i, (power, variance)) in powers.iter().zip(gls.variances()).enumerate() {
            // 600 numbers: their mean power is off by 5.8 %, standard error.
            let ratio = power / variance;
            assert!(
                (ratio - 1.0).abs() < 0.22,
                "{scenario:?}, order {}: {ratio}",
                i + 1
            );
        }
    }
}

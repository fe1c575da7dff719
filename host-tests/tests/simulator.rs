//! Statistics of simulated edges: the noise, errors and ripple are as large as the twin says, whatever the seed.

use std::f64::consts::TAU;

use quadcal_host::sim::{Event, Simulation};
use quadcal_host::twin::{
    Drive, Duration, Encoder, Errors, Harmonic, Noise, Per, Position, Ripple, Timer, Twin,
};

const W_15: f64 = 15.0 * TAU / 60.0;

/// The paper's rig with `lines` perfect lines, no ripple and no index.
fn perfect(lines: u32, turns: f64) -> Twin {
    Twin {
        encoder: Encoder::Quadrature {
            lines,
            index: false,
        },
        errors: Errors::default(),
        ripple: Vec::new(),
        duration: Duration::Turns(turns),
        ..Twin::paper()
    }
}

fn run(twin: &Twin) -> Vec<Event> {
    Simulation::new(twin).unwrap().collect()
}

/// True speed over each interval, relative to `nominal` and less 1, with the angle in its middle.
fn speed_swing(events: &[Event], nominal: f64) -> Vec<(f64, f64)> {
    events
        .windows(2)
        .map(|pair| {
            let (a, b) = (pair[0].truth, pair[1].truth);
            let speed = (b.angle_rad - a.angle_rad) / (b.time_s - a.time_s);
            (0.5 * (a.angle_rad + b.angle_rad), speed / nominal - 1.0)
        })
        .collect()
}

/// Amplitude of one order in a series by angle.
fn amplitude_at(series: &[(f64, f64)], order: f64) -> f64 {
    let (mut re, mut im) = (0.0, 0.0);
    for (angle, value) in series {
        re += value * (order * angle).cos();
        im += value * (order * angle).sin();
    }
    2.0 * re.hypot(im) / series.len() as f64
}

#[test]
fn wander_has_its_rms_and_its_correlation_angle() {
    let (rms, correlation) = (0.01, 0.5);
    let lines = 250;
    let step = TAU / f64::from(4 * lines);
    let lag = (correlation / step).round() as usize;
    let (mut power, mut product, mut samples) = (0.0, 0.0, 0.0);
    for seed in 1..=5 {
        let twin = Twin {
            seed,
            noise: Some(Noise::SpeedWander {
                rms_fraction: rms,
                correlation_rad: Some(correlation),
                hold_s: None,
            }),
            ..perfect(lines, 200.0)
        };
        let swing = speed_swing(&run(&twin), W_15);
        for i in lag..swing.len() {
            power += swing[i].1 * swing[i].1;
            product += swing[i].1 * swing[i - lag].1;
            samples += 1.0;
        }
    }
    // 6283 rad of run are 12,566 correlation angles: the RMS is known to 0.9 %, the correlation angle to about 2.5 %.
    let found_rms = (power / samples).sqrt();
    assert!((found_rms / rms - 1.0).abs() < 0.05, "RMS {found_rms}");
    let found_correlation = -(lag as f64 * step) / (product / power).ln();
    assert!(
        (found_correlation / correlation - 1.0).abs() < 0.1,
        "correlation {found_correlation} rad"
    );
}

#[test]
fn white_torque_noise_gives_the_speed_variance_of_its_density() {
    // S two-sided, time constant J / b: the speed's variance is S / (2 J b).
    let mut twin = perfect(250, 200.0);
    twin.shaft.viscous_n_m_s = 1e-3;
    let variance = (0.01 * W_15) * (0.01 * W_15);
    twin.noise = Some(Noise::White {
        psd_n2_m2_s: 2.0 * twin.shaft.inertia_kg_m2 * twin.shaft.viscous_n_m_s * variance,
        hold_s: None,
    });
    let (mut power, mut samples) = (0.0, 0.0);
    for seed in 11..=15 {
        twin.seed = seed;
        for (_, swing) in speed_swing(&run(&twin), W_15) {
            power += swing * swing;
            samples += 1.0;
        }
    }
    let found = (power / samples).sqrt();
    assert!((found / 0.01 - 1.0).abs() < 0.05, "RMS {found}");
}

/// Mean, mean square and mean product of neighbours of e over a disc's edges.
fn moments(errors: &[f64]) -> (f64, f64, f64) {
    let n = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / n;
    let square = errors.iter().map(|e| e * e).sum::<f64>() / n;
    let neighbours = errors.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n;
    (mean, square, neighbours)
}

#[test]
fn line_position_errors_have_the_moments_of_their_distribution() {
    let size: f64 = 5e-5;
    for seed in 1..=4 {
        for (position, variance, bound) in [
            (
                Position::Uniform {
                    amplitude_rad: size,
                    per: Per::Edge,
                },
                size * size / 3.0,
                size,
            ),
            (
                Position::Normal {
                    rms_rad: size,
                    per: Per::Edge,
                },
                size * size,
                6.0 * size,
            ),
        ] {
            let mut twin = perfect(2500, 1.0);
            twin.seed = seed;
            twin.errors.position = Some(position);
            let errors = Simulation::new(&twin).unwrap().true_errors();
            let (mean, square, neighbours) = moments(&errors);
            // 10,000 draws: bounds are five standard deviations (of the variance: 0.9 % uniform, 1.4 % normal).
            assert!(mean.abs() < 0.05 * variance.sqrt(), "mean {mean:e}");
            assert!(
                (square / variance - 1.0).abs() < 0.07,
                "variance {square:e}"
            );
            assert!(
                neighbours.abs() < 0.05 * variance,
                "neighbours {neighbours:e}"
            );
            assert!(errors.iter().all(|e| e.abs() <= bound));
        }
    }
}

#[test]
fn class_means_of_the_paper_s_disc_are_xi_a_xi_b_and_p() {
    let errors = Simulation::new(&Twin::paper()).unwrap().true_errors();
    let mean = |class: usize| {
        let of_class = errors.iter().skip(class).step_by(4);
        of_class.sum::<f64>() / 2500.0
    };
    // Means of 2500 uniform draws scatter by 7.3e-7 rad, differences by 1.03e-6: five of those.
    for (found, declared) in [
        (mean(2) - mean(0), 1.2566e-4),
        (mean(3) - mean(1), 1.1310e-4),
        (mean(1) - mean(0), 1.2566e-4),
    ] {
        assert!(
            (found - declared).abs() < 5.2e-6,
            "{found:e} for {declared:e}"
        );
    }
}

#[test]
fn one_error_per_line_is_shared_by_its_four_edges() {
    let mut twin = perfect(100, 1.0);
    twin.errors.position = Some(Position::Normal {
        rms_rad: 1e-4,
        per: Per::Line,
    });
    let errors = Simulation::new(&twin).unwrap().true_errors();
    assert!(
        errors
            .chunks(4)
            .all(|line| line.iter().all(|e| *e == line[0]))
    );
    assert!(
        errors
            .chunks(4)
            .zip(errors.chunks(4).skip(1))
            .all(|(a, b)| a[0] != b[0])
    );
}

#[test]
fn ripple_swings_the_speed_by_its_fraction_at_the_nominal_speed() {
    for r_min in [15.0, -1500.0] {
        let twin = Twin {
            ripple: Twin::paper().ripple,
            drive: Drive::Constant { r_min },
            ..perfect(500, 10.0)
        };
        let swing = speed_swing(&run(&twin), r_min * TAU / 60.0);
        for (order, fraction) in [(5.0, 0.01), (10.0, 0.005), (15.0, 0.0025)] {
            let found = amplitude_at(&swing, order);
            // The swing at one order bends the others by its own square, up to 1 % of them.
            assert!(
                (found / fraction - 1.0).abs() < 0.02,
                "order {order} at {r_min} r/min: {found}"
            );
        }
        assert!(amplitude_at(&swing, 7.0) < 1e-4);
    }
}

#[test]
fn a_torque_ripple_of_a_gear_shrinks_with_speed() {
    let order = 3.7;
    let swing_at = |r_min: f64| {
        let mut twin = perfect(500, 10.0);
        twin.drive = Drive::Constant { r_min };
        twin.ripple = vec![Ripple {
            order,
            phase_rad: 0.0,
            torque_n_m: Some(1e-4),
            speed_fraction: None,
        }];
        amplitude_at(&speed_swing(&run(&twin), r_min * TAU / 60.0), order)
    };
    // Far above J / b the relative swing is torque / (J order w^2): a quarter at twice the speed.
    let (slow, fast) = (swing_at(60.0), swing_at(120.0));
    let w = 60.0 * TAU / 60.0;
    assert!(
        (slow / (1e-4 / (1e-4 * order * w * w)) - 1.0).abs() < 0.02,
        "{slow}"
    );
    assert!((slow / fast - 4.0).abs() < 0.1, "{slow} and {fast}");
}

fn looped(lines: u32, turns: f64) -> Twin {
    Twin {
        drive: Drive::SpeedLoop {
            r_min: 15.0,
            f_hz: 10_000.0,
            bandwidth_hz: Some(50.0),
            kp_n_m_s: None,
            ki_n_m: None,
            timeout_s: None,
            limit_n_m: None,
        },
        ..perfect(lines, turns)
    }
}

#[test]
fn a_speed_loop_holds_the_measured_speed_and_lets_the_shaft_swing() {
    let mut twin = looped(500, 6.0);
    twin.errors.eccentricity = Some(Harmonic {
        amplitude_rad: 0.02,
        phase_rad: 0.0,
    });
    let events = run(&twin);
    let step = TAU / 2000.0;
    let measured: Vec<(f64, f64)> = events
        .windows(2)
        .map(|pair| {
            let seconds = (pair[1].row.ticks - pair[0].row.ticks) as f64 / 84e6;
            (pair[0].truth.angle_rad, step / seconds / W_15 - 1.0)
        })
        .collect();
    let seen = amplitude_at(&measured, 1.0);
    let real = amplitude_at(&speed_swing(&events, W_15), 1.0);
    assert!(seen < 1e-3, "the loop sees a swing of {seen}");
    assert!(
        (real / 0.02 - 1.0).abs() < 0.05,
        "the shaft swings by {real}"
    );
}

#[test]
fn a_speed_loop_makes_the_mean_of_what_it_samples_the_speed_asked_for() {
    let twin = Twin {
        errors: Twin::paper().errors,
        ..looped(2500, 2.0)
    };
    let events = run(&twin);
    let step = TAU / 10_000.0;
    // The speed of one interval is what the loop sees during the next.
    let (mut seen, mut seconds) = (0.0, 0.0);
    for three in events.windows(3) {
        let time = |i: usize| three[i].row.ticks as f64 / 84e6;
        seen += step / (time(1) - time(0)) * (time(2) - time(1));
        seconds += time(2) - time(1);
    }
    let mean = seen / seconds;
    assert!((mean / W_15 - 1.0).abs() < 0.002, "{mean} rad/s");
}

#[test]
fn lost_edges_come_at_their_probability() {
    let mut twin = perfect(2500, 4.0);
    twin.faults.lost_probability = 0.02;
    twin.timer = Timer {
        bits: 32,
        ..twin.timer
    };
    let lost = 40_000.0 - run(&twin).len() as f64;
    // 800 expected, standard deviation 28.
    assert!((lost - 800.0).abs() < 140.0, "{lost} lost");
}

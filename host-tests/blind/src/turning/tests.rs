use std::f64::consts::TAU;

use super::{Course, turn};
use crate::effect::Effect;
use crate::rig::{Order, Profile, Rig};
use crate::testing::plain;

/// Largest difference, rad, between the shaft's angle by a closed form and the angle of the edges at their times.
fn furthest(rig: &Rig, course: &Course, angle: impl Fn(f64) -> f64) -> f64 {
    let step = rig.encoder.step_rad();
    let edges = course.crossings.iter().filter(|c| c.class.is_some());
    assert!(edges.clone().count() > 300);
    edges.fold(0.0, |most, c| {
        (angle(c.time_s) - c.place as f64 * step).abs().max(most)
    })
}

fn load(torque_n_m: f64) -> Effect {
    Effect::LoadStep {
        torque_n_m,
        from_s: 0.0,
        until_s: f64::INFINITY,
    }
}

#[test]
fn constant_torque_makes_a_parabola() {
    let rig = plain();
    let course = turn(&rig, &[load(4e-4)], None);
    let angle = |t: f64| rig.start_rad + 10.0 * t + 0.5 * 2.0 * t * t;
    assert!(furthest(&rig, &course, angle) < 1e-12);
}

#[test]
fn damped_step_settles_exponentially() {
    let mut rig = plain();
    rig.stiffness = 6e-4;
    let course = turn(&rig, &[load(-6e-4)], None);
    // Damping 3 / s; the speed falls by 1 rad/s in the end.
    let angle = |t: f64| rig.start_rad + 9.0 * t + (1.0 - (-3.0 * t).exp()) / 3.0;
    assert!(furthest(&rig, &course, angle) < 1e-11);
}

#[test]
fn small_ripple_swings_the_angle_by_torque_over_inertia_and_square_of_its_frequency() {
    let rig = plain();
    let (order, phase_rad, torque_n_m) = (7.0, 0.4, 2e-6);
    let ripple = Effect::TorqueRipple(Order {
        order,
        phase_rad,
        torque_n_m,
    });
    let course = turn(&rig, &[ripple], None);
    let size = torque_n_m / rig.inertia / (order * 10.0_f64).powi(2);
    let swing = |t: f64| (order * (rig.start_rad + 10.0 * t) + phase_rad).sin();
    let angle = |t: f64| rig.start_rad + 10.0 * t - size * (swing(t) - swing(0.0));
    // Second order in the size.
    assert!(furthest(&rig, &course, angle) < 0.05 * size, "{size}");
}

#[test]
fn tone_swings_the_angle_at_its_frequency() {
    let rig = plain();
    let (f_hz, phase_rad, torque_n_m) = (13.0, 1.1, 1e-3);
    let tone = Effect::TorqueTone {
        f_hz,
        phase_rad,
        torque_n_m,
    };
    let course = turn(&rig, &[tone], None);
    let w = TAU * f_hz;
    let size = torque_n_m / rig.inertia / (w * w);
    let angle =
        |t: f64| rig.start_rad + 10.0 * t - size * ((w * t + phase_rad).sin() - phase_rad.sin());
    assert!(furthest(&rig, &course, angle) < 1e-10);
}

#[test]
fn two_masses_swing_freely() {
    let rig = plain();
    let (f_hz, inertia_share, torque) = (11.0, 0.3, 5e-4);
    let mode = Effect::TorsionalResonance {
        f_hz,
        damping_ratio: 0.0,
        inertia_share,
    };
    let course = turn(&rig, &[mode, load(torque)], None);
    let w = TAU * f_hz;
    let near = rig.inertia * (1.0 - inertia_share);
    let angle = |t: f64| {
        let twist = torque / (near * w * w) * (1.0 - (w * t).cos());
        rig.start_rad + 10.0 * t + 0.5 * torque / rig.inertia * t * t + inertia_share * twist
    };
    assert!(furthest(&rig, &course, angle) < 1e-9);
}

#[test]
fn run_down_with_coulomb_and_viscous_friction_ends_at_rest() {
    let mut rig = plain();
    rig.profile = Profile::RunDown {
        speed: 10.0,
        off_s: 1e-9,
    };
    (rig.viscous, rig.coulomb) = (1e-4, 3e-4);
    rig.longest_s = 20.0;
    let course = turn(&rig, &[], None);
    let (rate, drop): (f64, f64) = (0.5, 3.0);
    let angle =
        |t: f64| rig.start_rad + (10.0 + drop) * (1.0 - (-rate * t).exp()) / rate - drop * t;
    assert!(furthest(&rig, &course, angle) < 1e-7);
    let stop = ((10.0 + drop) / drop).ln() / rate;
    let edges = (angle(stop) / rig.encoder.step_rad()) as usize;
    let index = course
        .crossings
        .iter()
        .filter(|c| c.class.is_none())
        .count();
    assert_eq!(course.crossings.len() - index, edges);
}

#[test]
fn run_down_with_drag_falls_as_one_over_time() {
    let mut rig = plain();
    rig.profile = Profile::RunDown {
        speed: 10.0,
        off_s: 1e-9,
    };
    let drag = Effect::Friction {
        coulomb_n_m: 0.0,
        viscous_n_m_s: 0.0,
        drag_n_m_s2: 4e-6,
        stribeck_n_m: 0.0,
        stribeck_rad_s: 1.0,
    };
    let course = turn(&rig, &[drag], None);
    let angle = |t: f64| rig.start_rad + (0.02 * 10.0 * t).ln_1p() / 0.02;
    assert!(furthest(&rig, &course, angle) < 1e-6);
}

#[test]
fn speed_drift_bends_the_way() {
    let mut rig = plain();
    rig.stiffness = 6e-4;
    let fraction_per_s = 0.02;
    let course = turn(&rig, &[Effect::SpeedDrift { fraction_per_s }], None);
    let angle = |t: f64| rig.start_rad + 10.0 * (t + 0.5 * fraction_per_s * t * t);
    assert!(furthest(&rig, &course, angle) < 1e-10);
}

#[test]
fn speed_wanders_as_much_as_the_rig_says() {
    let mut rig = plain();
    (rig.stiffness, rig.turns) = (20.0 * rig.inertia, 60.0);
    rig.noise_psd = 2.0 * 20.0 * (0.003 * 10.0 * rig.inertia).powi(2);
    assert!((rig.wander(10.0) - 0.003).abs() < 1e-12);
    let course = turn(&rig, &[], Some(7));
    let count = course.crossings.len() as f64;
    let mean = course.crossings.iter().map(|c| c.speed).sum::<f64>() / count;
    let square = course.crossings.iter().map(|c| (c.speed - mean).powi(2));
    let wander = (square.sum::<f64>() / count).sqrt() / mean;
    // Some 750 correlation times: 4 % is one and a half standard errors of an RMS.
    assert!((wander / 0.003 - 1.0).abs() < 0.1, "{wander}");
}

#[test]
fn stick_slip_stops_and_goes() {
    let mut rig = plain();
    rig.stiffness = 1e-3;
    let stiffness_n_m_rad = rig.inertia * 100.0_f64.powi(2);
    let stick = Effect::StickSlip {
        stiffness_n_m_rad,
        coulomb_n_m: 0.3,
        stribeck_n_m: 0.4,
        stribeck_rad_s: 4.0,
    };
    let course = turn(&rig, &[stick], None);
    assert!(course.speeds.1 > 15.0, "{:?}", course.speeds);
    assert!(course.speeds.0.abs() < 5.0, "{:?}", course.speeds);
    let last = course.crossings.last().unwrap();
    assert!((last.time_s * 10.0 / (5.0 * TAU) - 1.0).abs() < 0.1);
}
